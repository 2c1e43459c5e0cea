"""Joining, order, episodes and refusals."""

from __future__ import annotations

import numpy as np
import pytest
from mapper_scene import Frame, Thing, messages, observe, room, shoot, table, walk

from doro_mapper.core import Mapper
from doro_mapper.settings import MapperSettings
from doro_schemas.camera import Pose
from doro_schemas.effects import Output
from doro_schemas.errors import Refused
from doro_schemas.messages import (
    DepthFrame,
    Exploration,
    FrameGraphs,
    GridDelta,
    GridRequest,
    InstancesRequest,
    Rejected,
)

THINGS = [*room(), table((0, 0)), Thing("mug", (0.2, 0.8, 0.1), (0.09, 0.1, 0.09))]
FRAMES = shoot(THINGS, walk(6))
PAIRS = messages(FRAMES)
EMPTY = messages([Frame(frame.pose, frame.depth_m, []) for frame in FRAMES])


def deltas(outputs: list[Output]) -> list[tuple[int, int, bool]]:
    out = []
    for message in outputs:
        assert isinstance(message, GridDelta)
        out.append((message.seq, message.frame, message.reset))
    return out


def start(episode: str = "e") -> Mapper:
    mapper = Mapper(MapperSettings())
    message = Exploration(episode=episode, stamp_ns=5, state="started")
    assert deltas(mapper.exploration(message)) == [(0, -1, True)]
    return mapper


def test_a_frame_is_merged_when_its_second_half_comes_in_either_order() -> None:
    mapper = start()
    (depth0, graphs0), (depth1, graphs1) = PAIRS[:2]
    assert mapper.depth_frame(depth0) == []
    assert mapper.frame_graphs(graphs1) == []
    assert deltas(mapper.depth_frame(depth1)) == [(1, 1, False)]
    merged = mapper.frame_graphs(graphs0)
    assert deltas(merged) == [(2, 0, False)]
    assert isinstance(merged[0], GridDelta)
    assert (merged[0].stamp_ns, merged[0].episode, merged[0].frames_merged) == (1000, "e", 2)


def test_a_frame_without_detections_is_acknowledged() -> None:
    mapper = start()
    depth, graphs = EMPTY[0]
    mapper.depth_frame(depth)
    (delta,) = mapper.frame_graphs(graphs)
    assert isinstance(delta, GridDelta)
    assert (delta.frame, delta.cells.shape, delta.frames_merged) == (0, (0, 6), 1)


def test_the_same_frame_again_changes_nothing() -> None:
    mapper = start()
    depth, graphs = PAIRS[0]
    mapper.depth_frame(depth)
    mapper.frame_graphs(graphs)
    before = mapper.grid(GridRequest()).digest
    assert mapper.depth_frame(depth) == []
    assert mapper.frame_graphs(graphs) == []
    assert mapper.grid(GridRequest()).digest == before
    assert mapper.counters["duplicates"] == 2
    assert mapper.pending == 0


def test_two_cameras_with_equal_frame_numbers_are_two_frames() -> None:
    mapper = start()
    for camera in ("left", "right"):
        depth, graphs = messages(FRAMES[:1], camera=camera)[0]
        mapper.depth_frame(depth)
        mapper.frame_graphs(graphs)
    assert mapper.grid(GridRequest()).frames_merged == 2


def test_sizes_that_disagree_are_refused_and_both_halves_dropped() -> None:
    mapper = start()
    depth, graphs = PAIRS[3]
    small = FrameGraphs(episode="e", frame=3, height_px=240, width_px=320)
    mapper.depth_frame(depth)
    with pytest.raises(Refused, match="300x300 px but the boxes refer to 320x240") as caught:
        mapper.frame_graphs(small)
    assert (caught.value.episode, caught.value.frame) == ("e", 3)
    assert mapper.pending == 0
    mapper.depth_frame(depth)
    assert deltas(mapper.frame_graphs(graphs)) == [(1, 3, False)]


def test_pending_frames_are_bounded_and_the_oldest_goes() -> None:
    mapper = Mapper(MapperSettings(max_pending_frames=3))
    mapper.exploration(Exploration(episode="e", state="started"))
    dropped: list[Output] = []
    for frame in range(5):
        depth = DepthFrame(
            episode="e",
            frame=frame,
            height_px=300,
            width_px=300,
            intrinsics=PAIRS[0][0].intrinsics,
            pose=PAIRS[0][0].pose,
            data=PAIRS[0][0].data,
        )
        dropped += mapper.depth_frame(depth)
    assert [m.frame for m in dropped if isinstance(m, Rejected)] == [0, 1]
    assert isinstance(dropped[0], Rejected)
    assert "graphs did not come" in dropped[0].reason
    assert (mapper.pending, mapper.counters["pending_dropped"]) == (3, 2)


def test_started_empties_the_map_but_keeps_depth_that_was_faster() -> None:
    mapper = Mapper(MapperSettings())
    depth, graphs = PAIRS[0]
    assert deltas(mapper.depth_frame(depth)) == [(0, -1, True)]  # implicit start
    assert deltas(mapper.exploration(Exploration(episode="e", state="started"))) == [(0, -1, True)]
    assert deltas(mapper.frame_graphs(graphs)) == [(1, 0, False)]
    assert deltas(mapper.exploration(Exploration(episode="e", state="started"))) == [(0, -1, True)]
    assert mapper.grid(GridRequest()).frames_merged == 0
    assert mapper.instances(InstancesRequest()).instances == []


def test_another_episode_is_an_implicit_start_and_the_old_one_is_late() -> None:
    mapper = start("a")
    old = messages(FRAMES, episode="a")
    new = messages(FRAMES, episode="b")
    mapper.depth_frame(old[0][0])
    mapper.frame_graphs(old[0][1])
    mapper.depth_frame(old[1][0])
    assert deltas(mapper.depth_frame(new[0][0])) == [(0, -1, True)]
    assert mapper.frame_graphs(old[1][1]) == []
    assert mapper.counters["late"] == 1
    assert deltas(mapper.frame_graphs(new[0][1])) == [(1, 0, False)]
    assert mapper.instances(InstancesRequest(episode="b")).frames_merged == 1
    with pytest.raises(Refused, match="map is of episode 'b', not 'a'"):
        mapper.instances(InstancesRequest(episode="a"))
    mapper.exploration(Exploration(episode="a", state="started"))  # the same place once more
    mapper.depth_frame(old[0][0])
    assert deltas(mapper.frame_graphs(old[0][1])) == [(1, 0, False)]


def test_an_empty_episode_means_the_current_one() -> None:
    mapper = start("a")
    depth, graphs = messages(FRAMES[:1], episode="")[0]
    mapper.depth_frame(depth)
    (delta,) = mapper.frame_graphs(graphs)
    assert delta.episode == "a"


def test_finished_says_nothing() -> None:
    assert start().exploration(Exploration(episode="e", state="finished")) == []


def test_a_change_of_world_within_an_episode_is_refused() -> None:
    mapper = start()
    mapper.depth_frame(PAIRS[0][0])
    mapper.frame_graphs(PAIRS[0][1])
    ros = Pose([0.0, 0.0, 1.5], [0, 0, 1, -1, 0, 0, 0, -1, 0], "ros")
    depth, graphs = messages([Frame(ros, FRAMES[1].depth_m, FRAMES[1].seen)] * 2)[1]
    mapper.depth_frame(depth)
    with pytest.raises(Refused, match="'ros' world but the episode's map is in 'unity'"):
        mapper.frame_graphs(graphs)
    assert mapper.grid(GridRequest()).frames_merged == 1


def test_depth_of_holes_is_merged_and_its_detections_counted() -> None:
    mapper = start()
    blind = Frame(FRAMES[0].pose, np.full((300, 300), np.nan, np.float32), FRAMES[0].seen)
    depth, graphs = messages([blind])[0]
    mapper.depth_frame(depth)
    assert deltas(mapper.frame_graphs(graphs)) == [(1, 0, False)]
    assert mapper.counters["detections_without_depth"] == len(FRAMES[0].seen) > 0


def test_depth_in_millimetres_gives_the_same_instances() -> None:
    positions = []
    for unit in ("f32_m", "u16_mm"):
        mapper = start()
        for (depth, graphs), frame in zip(PAIRS, FRAMES, strict=True):
            millimetres = np.round(frame.depth_m * 1000).astype(np.uint16)
            mapper.depth_frame(
                DepthFrame(
                    episode="e",
                    frame=depth.frame,
                    height_px=300,
                    width_px=300,
                    encoding="f32_m" if unit == "f32_m" else "u16_mm",
                    intrinsics=depth.intrinsics,
                    pose=depth.pose,
                    data=depth.data if unit == "f32_m" else millimetres,
                )
            )
            mapper.frame_graphs(graphs)
        positions.append([i.position_m for i in mapper.instances(InstancesRequest()).instances])
    assert len(positions[0]) == len(positions[1]) == 2
    assert np.abs(np.subtract(*positions)).max() < 0.01


def test_double_boxes_on_one_thing_are_one_sighting() -> None:
    frame = observe(THINGS, walk(6)[0])
    mugs = [seen for seen in frame.seen if seen.graph.name == "mug"]
    assert len(mugs) == 1
    x0, y0, x1, y1 = mugs[0].box_px
    twin = type(mugs[0])((x0, y0, x1 + 1, y1), mugs[0].graph, mugs[0].thing, 0.5)
    mapper = start()
    depth, graphs = messages([Frame(frame.pose, frame.depth_m, [*frame.seen, twin])])[0]
    mapper.depth_frame(depth)
    mapper.frame_graphs(graphs)
    assert mapper.counters["detections_duplicate"] == 1
    assert len(mapper.instances(InstancesRequest(name="mug")).instances) == 1
