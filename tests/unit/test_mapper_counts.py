"""How many things are there: counts under the paper's error models."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from mapper_scene import Frame, Seen, Thing, disturb, messages, room, shoot, table, walk

from doro_mapper.core import Mapper
from doro_mapper.settings import MapperSettings
from doro_schemas.camera import Pose
from doro_schemas.graph import ObjectGraph
from doro_schemas.messages import Instances, InstancesRequest

RED = {"color": "red"}
SPOTS = [(-0.5, -0.25), (0.0, -0.25), (0.5, -0.25), (-0.25, 0.25), (0.25, 0.25)]
MUG = (0.09, 0.10, 0.09)
FALSE = [ObjectGraph("mug", RED), ObjectGraph("lamp", {"color": "white"})]


def scene(mugs: int) -> list[Thing]:
    """Red twin mugs 0.5 m apart on a table, a lamp, two equal arm chairs."""
    twins = [Thing("mug", (x, 0.8, z), MUG, RED) for x, z in SPOTS[:mugs]]
    chairs = [Thing("arm chair", (1.9, 0.4, z), (0.7, 0.8, 0.7)) for z in (-1.6, 1.6)]
    lamp = Thing("lamp", (0.7, 0.95, 0.3), (0.2, 0.4, 0.2), {"color": "white"})
    return [*room(), table((0, 0)), *twins, lamp, *chairs]


_FRAMES: dict[int, list[Frame]] = {}


def frames(mugs: int) -> list[Frame]:
    if mugs not in _FRAMES:
        _FRAMES[mugs] = shoot(scene(mugs), walk(24, mugs, radius_m=1.5))
    return _FRAMES[mugs]


def answer(observed: list[Frame], finder: str = "tracks", name: str = "") -> Instances:
    mapper = Mapper(MapperSettings(finder="grid" if finder == "grid" else "tracks", few_views=10))
    for depth, graphs in messages(observed):
        mapper.depth_frame(depth)
        mapper.frame_graphs(graphs)
    return mapper.instances(InstancesRequest(name=name))


def counts(observed: list[Frame], finder: str = "tracks") -> Counter[str]:
    return Counter(i.graph.name for i in answer(observed, finder).instances)


def truth(mugs: int) -> Counter[str]:
    return Counter({"mug": mugs, "lamp": 1, "arm chair": 2, "dining table": 1})


@pytest.mark.parametrize("finder", ["tracks", "grid"])
@pytest.mark.parametrize("mugs", [1, 2, 3, 4, 5])
def test_perfect_detections_give_exact_counts(mugs: int, finder: str) -> None:
    assert counts(frames(mugs), finder) == truth(mugs)


@pytest.mark.parametrize("mugs", [1, 2, 3, 4, 5])
@pytest.mark.parametrize("errors", ["shift", "shift scale", "shift scale drop"])
def test_shifted_scaled_and_missing_boxes_keep_the_counts(mugs: int, errors: str) -> None:
    wrong = disturb(frames(mugs), 7, **dict.fromkeys(errors.split(), True))
    assert counts(wrong) == truth(mugs)


@pytest.mark.parametrize("mugs", [1, 2, 3])
def test_false_positives_do_not_change_the_counts(mugs: int) -> None:
    wrong = disturb(frames(mugs), 3, false=FALSE)
    assert sum(seen.thing < 0 for frame in wrong for seen in frame.seen) >= 3
    assert counts(wrong) == truth(mugs)


@pytest.mark.parametrize("finder", ["tracks", "grid"])
def test_a_false_positive_seen_once_is_no_instance(finder: str) -> None:
    observed = list(frames(1))
    ghost = Seen((100.0, 150.0, 130.0, 180.0), ObjectGraph("vase", {"color": "blue"}), -1)
    observed[5] = replace(observed[5], seen=[*observed[5].seen, ghost])
    assert counts(observed, finder) == truth(1)


def test_a_single_view_counts_what_it_shows() -> None:
    observed = frames(3)[:1]
    expected = Counter(seen.graph.name for seen in observed[0].seen)
    assert expected["mug"] >= 2
    assert counts(observed) == expected


def test_positions_and_extents_are_those_of_the_things() -> None:
    instances = answer(frames(3), name="mug").instances
    expected = np.array([thing.center_m for thing in scene(3) if thing.name == "mug"])
    for instance in instances:
        gap = np.linalg.norm(expected - instance.position_m, axis=1)
        assert gap.min() < 0.03
        assert np.abs(np.array(instance.extent_m) - MUG).max() < 0.03


def test_a_wrong_colour_in_some_captions_is_outvoted() -> None:
    observed = []
    for number, frame in enumerate(frames(1)):
        seen = [
            replace(s, graph=ObjectGraph("mug", {"color": "pink"}))
            if number % 4 == 1 and s.graph.name == "mug"
            else s
            for s in frame.seen
        ]
        observed.append(replace(frame, seen=seen))
    (mug,) = answer(observed, name="mug").instances
    assert mug.graph.attributes == {"color": "red"}
    assert mug.runner_up == {"color": "pink"}


def moved(pose: Pose, turn: np.ndarray, shift: np.ndarray, world: str) -> Pose:
    rotation = turn @ pose.matrix()
    position = turn @ np.asarray(pose.position_m) + shift
    return Pose(position.tolist(), rotation.ravel().tolist(), "ros" if world == "ros" else "unity")


def test_unity_and_ros_worlds_give_equal_instances_up_to_axes() -> None:
    unity = frames(3)
    swap = np.array([[1.0, 0, 0], [0, 0, 1], [0, 1, 0]])  # y and z change places
    ros = [replace(f, pose=moved(f.pose, swap, np.zeros(3), "ros")) for f in unity]
    first, second = answer(unity), answer(ros)
    assert len(first.instances) == len(second.instances) == 7
    for a, b in zip(first.instances, second.instances, strict=True):
        assert (a.instance_id, a.graph, a.hits, a.misses) == (
            b.instance_id,
            b.graph,
            b.hits,
            b.misses,
        )
        assert np.allclose((swap @ a.position_m), b.position_m, atol=1e-3)
        assert a.cells == b.cells
    assert first.digest == second.digest


@pytest.mark.parametrize("turn_deg", [0, 37, 90])
def test_a_rigid_motion_of_the_world_moves_the_answer(turn_deg: float) -> None:
    angle = np.radians(turn_deg)
    cos, sin = np.cos(angle), np.sin(angle)
    turn = np.array([[cos, 0, sin], [0, 1, 0], [-sin, 0, cos]])
    shift = np.array([-7.31, 0.42, 13.77])
    still = answer(frames(3))
    away = answer([replace(f, pose=moved(f.pose, turn, shift, "unity")) for f in frames(3)])
    for name, number in truth(3).items():
        here = [i for i in still.instances if i.graph.name == name]
        there = [i for i in away.instances if i.graph.name == name]
        assert len(here) == len(there) == number
        for a in here:
            expected = turn @ np.asarray(a.position_m) + shift
            gap = min(float(np.linalg.norm(expected - b.position_m)) for b in there)
            assert gap < (0.02 if name in ("mug", "lamp") else 0.15)


def test_equal_input_gives_equal_bytes() -> None:
    import msgspec

    wrong = disturb(frames(2), 5, shift=True, drop=True, false=FALSE)
    first, second = (msgspec.msgpack.encode(answer(wrong)) for _ in range(2))
    assert first == second


def test_asking_in_between_does_not_change_the_end() -> None:
    mapper = Mapper(MapperSettings())
    for depth, graphs in messages(disturb(frames(3), 2, shift=True, false=FALSE)):
        mapper.depth_frame(depth)
        mapper.frame_graphs(graphs)
        mapper.instances(InstancesRequest())
    asked = mapper.instances(InstancesRequest())
    fresh = Mapper(MapperSettings())
    for depth, graphs in messages(disturb(frames(3), 2, shift=True, false=FALSE)):
        fresh.depth_frame(depth)
        fresh.frame_graphs(graphs)
    assert fresh.instances(InstancesRequest()) == asked


def test_forgetting_old_views_keeps_what_they_saw_and_missed() -> None:
    forgetful, whole = (Mapper(MapperSettings(max_views=views)) for views in (12, 2000))
    for mapper in (forgetful, whole):
        for depth, graphs in messages(frames(2)):
            mapper.depth_frame(depth)
            mapper.frame_graphs(graphs)
    kept, all_of = (
        mapper.instances(InstancesRequest(name="mug")).instances for mapper in (forgetful, whole)
    )
    assert [i.hits for i in kept] == [i.hits for i in all_of]
    assert max(i.hits for i in kept) > 12
