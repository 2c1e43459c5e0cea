"""What the mapper's benchmark feeds in and how it weighs memory; no time is asserted."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import doro_sim_feeder
from doro_evaluation.bench.mapper import deep_bytes, measure, measure_long, wanted
from doro_evaluation.bench.mapper_scenes import EPISODE, Endless, Scene, scene_of
from doro_schemas.errors import Refused
from doro_schemas.messages import DepthFrame

SAMPLE = Path(doro_sim_feeder.__file__).parent / "data" / "sample-kitchen.mcap"


@pytest.fixture(scope="module")
def kitchen() -> Scene:
    return scene_of("fronts", SAMPLE)


def test_frames_are_distinct_repeat_and_have_as_many_detections(kitchen: Scene) -> None:
    pairs = Endless(kitchen, 8)
    count = len(kitchen.rooms[0].depths)
    first, again = pairs.make(3), Endless(kitchen, 8).make(3)
    later = pairs.make(3 + count)
    assert first[1] == again[1]
    assert first[0].pose == again[0].pose
    assert np.array_equal(first[0].data, again[0].data)
    assert later[0].frame == later[1].frame == 3 + count
    assert later[0].pose != first[0].pose
    assert not np.array_equal(later[0].data, first[0].data)
    assert {len(pairs.make(k)[1].detections) for k in range(count)} == {8}


def test_large_frames_are_scaled_with_boxes_and_lens(kitchen: Scene) -> None:
    small_depth, small = Endless(kitchen, 20).make(5)
    depth, graphs = Endless(kitchen, 20, (480, 640)).make(5)
    assert depth.data.shape == (480, 640)
    assert len(graphs.detections) == 20
    factor = 640 / 300
    assert depth.intrinsics.fx == pytest.approx(small_depth.intrinsics.fx * factor)
    assert depth.intrinsics.cy == pytest.approx(240)
    for large, own in zip(graphs.detections, small.detections, strict=True):
        assert large.graph == own.graph
        assert large.box_px[0] == pytest.approx(own.box_px[0] * factor)
        assert 0 <= large.box_px[1] < large.box_px[3] <= 480
    u, v = 320, 240
    row = int((v + (300 * factor - 480) / 2) / factor)
    assert depth.data[v, u] == small_depth.data[row, int(u / factor)]


def test_memory_counts_arrays_behind_views_once() -> None:
    base = np.zeros(1_000_000)
    holder = {"a": base[:10], "b": [base[5:20], base]}
    assert 8_000_000 < deep_bytes(holder) < 8_010_000
    assert deep_bytes([DepthFrame, len, np]) < 1000


def test_all_figures_are_there() -> None:
    figures = measure("fronts", SAMPLE, frames=60, large_frames=12)
    for name in (
        "frame_300_p50_ms",
        "frame_300_p99_ms",
        "query_after_60_frames_ms",
        "state_after_60_frames_mb",
        "ratio_to_conceptgraphs_like",
        "frame_640_p50_ms",
        "flatness",
    ):
        assert float(figures[f"speed/mapper/fronts/{name}"]) > 0, name
    assert int(figures["speed/mapper/fronts/instances"]) > 10
    assert wanted("speed/mapper/fronts/frame_300_p50_ms") == "< 2"
    assert wanted("speed/mapper/frame_300_early_p50_ms") == ""


def test_only_views_that_show_enough_are_taken_where_nothing_is_filled_up(kitchen: Scene) -> None:
    rooms = (kitchen.rooms[0],)
    pairs = Endless(Scene(rooms, False, "cs+sd"), 8)
    shown = [len(one.detections) for one in rooms[0].detections]
    assert pairs.views == sum(count >= 8 for count in shown) < len(shown)
    for number in range(pairs.views):
        depth, graphs = pairs.make(number)
        assert len(graphs.detections) <= 8
        assert depth.episode == graphs.episode == EPISODE
    with pytest.raises(Refused, match="no view of the scene shows 99 things"):
        Endless(Scene(rooms, False, "gt"), 99)


def test_memory_of_a_long_run_is_told_at_each_tenth() -> None:
    figures = measure_long("fronts", SAMPLE, 100)
    assert len([name for name in figures if "/state_after_" in name]) == 10
    assert float(figures["speed/mapper/long/state_after_100_frames_mb"]) > 0
