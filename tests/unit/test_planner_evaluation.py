"""Views needed, measured on part of the sample room: orders, marks, figures and plot."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pytest

from doro_evaluation.chain import Language, Room, load_room
from doro_evaluation.outcomes import Thing, true_things
from doro_evaluation.planning.curve import (
    DONE,
    PLANNED,
    RANDOM,
    RECORDED,
    THIRD,
    PlanningContext,
    Point,
    run_order,
)
from doro_evaluation.planning.report import chosen, figures_of, plot, table_of
from doro_schemas.errors import Refused
from doro_schemas.messages import FrameGraphs

SAMPLE = Path(__file__).resolve().parents[2] / "sim-feeder/doro_sim_feeder/data/sample-kitchen.mcap"
VIEWS = 24
CONTEXT = PlanningContext(seeds=(0, 1), shares=(0.01, THIRD, 1.0))
Given = tuple[Room, Sequence[FrameGraphs], tuple[Thing, ...]]


@pytest.fixture(scope="module")
def given() -> Given:
    whole = load_room(SAMPLE)
    room = replace(whole, depths=whole.depths[::3], detections=whole.detections[::3])
    assert len(room.depths) == VIEWS
    return room, Language().graphs(room), true_things(room)


@pytest.fixture(scope="module")
def points(given: Given) -> list[Point]:
    runs = ((PLANNED, 0), (RECORDED, 0), (RANDOM, 0), (RANDOM, 1))
    return [
        point
        for order, seed in runs
        for point in run_order(*given, CONTEXT, order=order, seed=seed)
    ]


def test_every_order_has_its_marks(points: list[Point]) -> None:
    for order, seeds in ((PLANNED, 1), (RECORDED, 1), (RANDOM, 2)):
        groups = chosen(points, order, THIRD)
        assert len(groups) == seeds
        assert all([point.views for point in group] == [VIEWS // 3] for group in groups)
    assert {point.views for point in points if point.share == 0.01} == {1}
    assert all(point.order == PLANNED for point in points if point.share == DONE)


def test_all_orders_end_with_all_views(points: list[Point]) -> None:
    """Each view is taken once: the area seen at the end is the same, the way is not."""
    ends = [point for point in points if point.share == 1.0]
    assert {point.views for point in ends} == {VIEWS}
    assert len({round(point.coverage, 9) for point in ends}) == 1
    assert len({round(point.travel_m, 6) for point in ends}) == 4


def test_the_planner_is_deterministic(given: Given, points: list[Point]) -> None:
    room, graphs, truth = given
    context = PlanningContext(shares=(THIRD,))
    again = run_order(room, graphs, truth, context, order=PLANNED)
    first = [p for p in points if p.order == PLANNED and p.share == THIRD]
    assert [(p.travel_m, p.outcome.found) for p in again] == [
        (p.travel_m, p.outcome.found) for p in first
    ]


def test_figures_table_and_plot(points: list[Point], tmp_path: Path) -> None:
    figures = figures_of(points)
    for name in ("planned/33/f1", "random/33/accuracy", "recorded/100/travel_m"):
        assert isinstance(figures[f"planning/{name}"], float)
    whole, third = figures["planning/recorded/100/f1"], figures["planning/planned/33/f1"]
    assert isinstance(whole, float)
    assert isinstance(third, float)
    promised = figures["planning/planned/third/f1_minus_all_views"]
    assert isinstance(promised, float)
    assert math.isclose(promised, third - whole, abs_tol=2e-4)
    assert table_of(points).row_count == 3
    plot(tmp_path / "curve.png", points)
    assert (tmp_path / "curve.png").read_bytes().startswith(b"\x89PNG")


def test_an_unknown_order_is_refused(given: Given) -> None:
    with pytest.raises(Refused, match="there is no order 'zigzag'"):
        run_order(*given, CONTEXT, order="zigzag")
