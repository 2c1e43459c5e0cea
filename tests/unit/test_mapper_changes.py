"""A world that changes, and a map that learns better: labels, moves, merges, corrected poses."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from mapper_scene import Frame, Seen, Thing, messages, room, shoot, table, walk

from doro_mapper.core import Mapper
from doro_mapper.settings import MapperSettings
from doro_schemas.camera import Pose
from doro_schemas.errors import Refused
from doro_schemas.graph import ObjectGraph
from doro_schemas.messages import (
    ClassProbability,
    DepthFrame,
    FrameGraphs,
    GridDelta,
    GridRequest,
    Instances,
    InstancesRequest,
    PoseCorrections,
)

RED = {"color": "red"}
MUG = (0.09, 0.10, 0.09)
POSES = walk(24, 3, radius_m=1.5)
Pair = tuple[DepthFrame, FrameGraphs]


def mugs(*spots: tuple[float, float]) -> list[Thing]:
    return [*room(), table((0, 0)), *(Thing("mug", (x, 0.8, z), MUG, RED) for x, z in spots)]


ONE, TWO = shoot(mugs((-0.4, 0.0)), POSES), shoot(mugs((-0.4, 0.0), (0.4, 0.0)), POSES)


def fed(pairs: list[Pair], **settings: object) -> Mapper:
    mapper = Mapper(MapperSettings(few_views=5, **settings))  # type: ignore[arg-type]
    for depth, graphs in pairs:
        mapper.depth_frame(depth)
        mapper.frame_graphs(graphs)
    return mapper


def numbered(frames: list[Frame], first: int = 0, camera: str = "cam0") -> list[Pair]:
    """Return the frames' messages, numbered from ``first`` on."""
    filler = [frames[0]] * first
    return messages([*filler, *frames], camera=camera)[first:]


def ask(mapper: Mapper, name: str = "") -> Instances:
    return mapper.instances(InstancesRequest(name=name))


def flickering(frames: list[Frame], share: float) -> list[Frame]:
    rng = np.random.default_rng(1)

    def label(seen: Seen) -> Seen:
        other = seen.graph.name == "mug" and rng.random() < share
        return replace(seen, graph=ObjectGraph("cup", RED)) if other else seen

    return [replace(frame, seen=[label(seen) for seen in frame.seen]) for frame in frames]


@pytest.mark.parametrize("share", [0.3, 0.5])
def test_flickering_labels_of_one_thing_do_not_make_two(share: float) -> None:
    found = ask(fed(numbered(flickering(TWO, share)))).instances
    own = [i for i in found if i.graph.name in ("mug", "cup")]
    assert len(own) == 2
    assert all([c.name for c in i.classes] in (["mug", "cup"], ["cup", "mug"]) for i in own)


def test_a_cup_and_a_mug_seen_together_stay_two() -> None:
    things = [*mugs((-0.05, 0.0)), Thing("cup", (0.06, 0.8, 0.0), MUG, RED)]
    found = Counter(i.graph.name for i in ask(fed(numbered(shoot(things, POSES)))).instances)
    assert (found["mug"], found["cup"]) == (1, 1)


def test_class_distributions_are_fused_over_views() -> None:
    pairs = numbered(ONE)
    doubtful = [ClassProbability("Mugs", 0.4), ClassProbability("cup", 0.6)]
    sure = [ClassProbability("mug", 0.9), ClassProbability("cup", 0.1)]
    for number, (_, graphs) in enumerate(pairs):
        graphs.detections = [
            type(box)(
                box.box_px, box.score, box.graph, box.caption, doubtful if number % 2 else sure
            )
            if box.graph.name == "mug"
            else box
            for box in graphs.detections
        ]
    (mug,) = ask(fed(pairs), "mug").instances
    assert [one.name for one in mug.classes] == ["mug", "cup"]
    assert 0.5 < mug.classes[0].probability < 1.0


@pytest.mark.parametrize(("calibrated", "count"), [(False, 1), (True, 0)])
def test_views_count_by_calibrated_scores_and_by_their_word_otherwise(
    calibrated: bool, count: int
) -> None:
    """Four views at .1 are not half a certain one, however well they agree."""
    pairs = numbered(ONE[:4])
    either = [ClassProbability("mug", 0.6), ClassProbability("cup", 0.4)]
    for _, graphs in pairs:
        graphs.calibrated = calibrated
        graphs.detections = [
            type(box)(box.box_px, 0.1, box.graph, "", either)
            for box in graphs.detections
            if box.graph.name == "mug"
        ]
    mapper = Mapper(MapperSettings(few_views=0))
    for depth, graphs in pairs:
        mapper.depth_frame(depth)
        mapper.frame_graphs(graphs)
    assert len(ask(mapper, "mug").instances) == count


def test_a_double_box_with_a_possible_other_class_is_one_detection() -> None:
    pairs = numbered(ONE[:4])
    for _, graphs in pairs:
        for box in list(graphs.detections):
            if box.graph.name == "mug":
                either = [ClassProbability("mug", 0.6), ClassProbability("cup", 0.4)]
                first = type(box)(box.box_px, 0.9, box.graph, "", either)
                double = type(box)(box.box_px, 0.3, ObjectGraph("cup"), "")
                graphs.detections = [first, double]
    mapper = fed(pairs)
    assert mapper.counters["detections_duplicate"] > 0
    assert [i.graph.name for i in ask(mapper).instances] == ["mug"]


def test_a_thing_that_moved_is_gone_there_and_found_here() -> None:
    """Furniture: later views look through the place where it was."""
    box = [Thing("box", (x, 0.3, -1.0), (0.6, 0.6, 0.6)) for x in (-1.2, 1.2)]
    poses = walk(24, 3, radius_m=1.8)
    first, later = (shoot([*room(), thing], poses) for thing in box)
    mapper = fed(numbered(first))
    (before,) = ask(mapper, "box").instances
    for depth, graphs in numbered(later, first=24):
        mapper.depth_frame(depth)
        mapper.frame_graphs(graphs)
    reply = ask(mapper, "box")
    (after,) = reply.instances
    assert before.instance_id == "box-1" != after.instance_id
    assert np.linalg.norm(np.subtract(after.position_m, box[1].center_m)) < 0.15
    assert [(one.instance_id, one.reason) for one in reply.gone] == [("box-1", "moved")]


def test_a_repeated_false_positive_at_one_place_is_outweighed() -> None:
    """A wall's pattern taken for a television in 4 of 24 views that all show the place."""
    poses = [POSES[0]] * 24
    frames = shoot(mugs((-0.4, 0.0)), poses)
    ghost = Seen((100.0, 40.0, 190.0, 110.0), ObjectGraph("television"), -1)
    frames = [
        replace(frame, seen=[*frame.seen, ghost]) if k % 6 == 1 else frame
        for k, frame in enumerate(frames)
    ]
    reply = ask(fed(numbered(frames)), "television")
    assert reply.instances == []
    assert [one.hits for one in reply.tentative] in ([4], [])


def test_two_cameras_see_one_thing_once() -> None:
    left, right = numbered(TWO[::2], camera="left"), numbered(TWO[1::2], camera="right")
    mapper = fed([pair for both in zip(left, right, strict=True) for pair in both])
    found = ask(mapper, "mug").instances
    assert len(found) == 2
    assert {one.camera for mug in found for one in mug.evidence} == {"left", "right"}


def test_ids_stay_with_their_things_and_are_never_used_again() -> None:
    mapper = Mapper(MapperSettings(few_views=5))
    place: dict[str, list[float]] = {}
    for depth, graphs in numbered(flickering(TWO, 0.4)):
        mapper.depth_frame(depth)
        mapper.frame_graphs(graphs)
        reply = ask(mapper)
        for one in reply.instances:
            known = place.setdefault(one.instance_id, one.position_m)
            small = one.graph.name in ("mug", "cup")
            assert np.linalg.norm(np.subtract(one.position_m, known)) < (0.1 if small else 1.0)
            for old in one.replaces:
                assert old in place or old not in {i.instance_id for i in reply.instances}
        shown = {one.instance_id for one in reply.instances}
        gone = {one.instance_id: one for one in reply.gone}
        assert not shown & set(gone)
        assert set(place) <= shown | set(gone)
        assert all(one.replaced_by in shown for one in gone.values() if one.reason == "merged")


def drifted(
    frames: list[Frame], from_frame: int, shift_m: tuple[float, float, float]
) -> list[Frame]:
    out = []
    for number, frame in enumerate(frames):
        pose = frame.pose
        moved = [a + b for a, b in zip(pose.position_m, shift_m, strict=True)]
        wrong = Pose(moved, pose.rotation, pose.world)
        out.append(replace(frame, pose=wrong) if number >= from_frame else frame)
    return out


def test_corrected_poses_place_frames_anew() -> None:
    mapper = fed(numbered(drifted(TWO, 12, [0.9, 0.0, 0.3])))
    assert len(ask(mapper, "mug").instances) > 2
    before = {tuple(c[:4]) for c in mapper.grid(GridRequest()).cells.tolist()}
    poses = [frame.pose for frame in TWO[12:]]
    (delta,) = mapper.pose_corrections(
        PoseCorrections(
            episode="e", stamp_ns=9, frames=[*range(12, 24), 99], poses=[*poses, poses[0]]
        )
    )
    assert isinstance(delta, GridDelta)
    assert (delta.frame, delta.corrected, delta.reset) == (-1, 12, False)
    fixed, right = ask(mapper, "mug").instances, ask(fed(numbered(TWO)), "mug").instances
    assert len(fixed) == 2
    for one in right:
        gaps = [np.linalg.norm(np.subtract(one.position_m, i.position_m)) for i in fixed]
        assert min(gaps) < 0.03
    gone = {tuple(c[:4]) for c in delta.cells.tolist() if c[4] == 0}
    now = {tuple(c[:4]) for c in mapper.grid(GridRequest()).cells.tolist()}
    assert gone == before - now
    assert {tuple(c[:4]) for c in delta.cells.tolist() if c[4]} == now


def test_corrections_of_unknown_frames_or_another_world_change_nothing() -> None:
    mapper = fed(numbered(ONE[:3]))
    digest = mapper.grid(GridRequest()).digest
    assert mapper.pose_corrections(PoseCorrections(frames=[7], poses=[ONE[0].pose])) == []
    ros = Pose([0.0, 0.0, 1.5], [0, 0, 1, -1, 0, 0, 0, -1, 0], "ros")
    with pytest.raises(Refused, match="'ros' world but the map is in 'unity'"):
        mapper.pose_corrections(PoseCorrections(frames=[0], poses=[ros]))
    assert mapper.grid(GridRequest()).digest == digest


def test_memory_is_bounded_in_a_long_run() -> None:
    """A slice of a run of any length: nothing kept grows past its bound."""
    rng = np.random.default_rng(2)
    mapper = fed([], max_views=16, max_tracks=12, max_cells=3000)
    names = [f"thing{k}" for k in range(40)]
    for number in range(150):
        frame = TWO[number % 24]
        x, y = rng.uniform(0, 250, 2)
        ghost = ObjectGraph(names[int(rng.integers(40))])
        seen = [*frame.seen, Seen((x, y, x + 40, y + 40), ghost, -1)]
        ((depth, graphs),) = numbered([replace(frame, seen=seen)], first=number)
        mapper.depth_frame(depth)
        mapper.frame_graphs(graphs)
    area = mapper._area
    tracks = len(area.tracks())
    assert tracks <= 12
    assert (area.views.count, len(area._shots), len(area._serials)) == (16, 16, 16)
    assert len(area.maps) == 3000
    assert mapper.counters["cells_dropped"] > 0
    assert [i.graph.name for i in ask(mapper, "mug").instances] == ["mug", "mug"]


def test_more_new_tracks_in_a_frame_than_may_be_kept() -> None:
    names = [f"thing{k}" for k in range(40)]
    seen = [
        Seen((5.0 * k, 100.0, 5.0 * k + 40, 160.0), ObjectGraph(name), -1)
        for k, name in enumerate(names)
    ]
    mapper = fed(numbered([replace(ONE[0], seen=seen), ONE[1]]), max_tracks=10)
    assert len(mapper.tracks()) == 10
