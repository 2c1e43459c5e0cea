"""Playing planned: which recorded view a goal means, how many views, what is sent."""

from __future__ import annotations

from pathlib import Path

import pytest

from doro_schemas.errors import Refused
from doro_schemas.messages import Exploration
from doro_schemas.viewpoint import Viewpoint
from doro_sim_feeder.planned import nearest_view, tours, view_count
from doro_sim_feeder.play import PlaySettings
from doro_sim_feeder.recording import Recording
from doro_sim_feeder.steps import steps

SAMPLE = Path(__file__).resolve().parents[2] / "sim-feeder/doro_sim_feeder/data/sample-kitchen.mcap"


def test_nearest_view_weighs_place_and_direction() -> None:
    views = [
        Viewpoint([0.0, 1.5, 0.0], 0.0, 0.0),
        Viewpoint([0.0, 1.5, 0.0], 180.0, 0.0),
        Viewpoint([0.9, 1.5, 0.0], 350.0, 0.0),
        Viewpoint([0.0, 1.5, 0.0], 0.0, 30.0),
    ]
    goal = Viewpoint([0.1, 1.5, 0.0], 355.0, 0.0)
    assert nearest_view(views, range(4), goal) == 0
    assert nearest_view(views, [1, 2, 3], goal) == 3
    assert nearest_view(views, [1, 2], goal) == 2
    assert nearest_view(views, [2, 1], Viewpoint([0.0, 1.5, 0.0])) == 1
    assert nearest_view([views[0], views[0]], [1, 0], goal) == 0  # of equal ones the first


@pytest.mark.parametrize(
    ("text", "count"), [("", 72), ("20", 20), ("33%", 24), ("500", 72), (" 1% ", 1)]
)
def test_view_count(text: str, count: int) -> None:
    assert view_count(text, 72) == count


@pytest.mark.parametrize("text", ["0", "-3", "some", "0%", "nan", "inf"])
def test_view_count_refuses(text: str) -> None:
    with pytest.raises(Refused, match="give a number of views"):
        view_count(text, 72)


def test_a_tour_takes_every_view_once_and_says_what_it_can_reach() -> None:
    (tour,) = tours(steps(Recording(SAMPLE)))
    started = tour.start().samples[0].message()
    assert isinstance(started, Exploration)
    assert started.goals is True
    assert started.reachable == tour.views
    assert len(tour.views) == started.frames == 72
    frames, step = [], tour.next(None)
    assert step is not None
    assert step.frame == 0
    while step is not None:
        frames.append(step.frame)
        step = tour.next(tour.views[40])
    assert frames[1] == 40
    assert sorted(frames) == list(range(72))
    finished = tour.finish(24).samples[0].message()
    assert isinstance(finished, Exploration)
    assert (finished.state, finished.frames, finished.room) == ("finished", 24, "FloorPlan19")


def test_planned_play_refuses_what_does_not_go_with_it() -> None:
    with pytest.raises(Refused, match="leave out --speed"):
        PlaySettings(order="planned", speed=1.0)
    with pytest.raises(Refused, match="--views is for --order planned"):
        PlaySettings(views="20")
