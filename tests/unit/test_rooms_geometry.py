"""Rendered depth, ids and boxes agree; the same seed gives the same bytes."""

from __future__ import annotations

import importlib.util

import numpy as np
import pytest

from doro_schemas import codec
from doro_schemas.camera import Intrinsics, Pose, backproject, pose_from_ai2thor
from doro_schemas.messages import ColorFrame, DepthFrame, Exploration, SimDetections
from doro_sim_feeder.rooms.camera import Camera
from doro_sim_feeder.rooms.episode import EPOCH_NS, FRAME_NS, RoomEpisode, render_episode
from doro_sim_feeder.rooms.instances import Instance
from doro_sim_feeder.rooms.parts import blob_part, box_part, place
from doro_sim_feeder.rooms.placement import CopySpec
from doro_sim_feeder.rooms.raycast import RayCaster, make_soup

MISSING = [
    name for name in ("embreex", "procthor", "PIL") if importlib.util.find_spec(name) is None
]
pytestmark = pytest.mark.skipif(
    bool(MISSING), reason=f"the extra 'render' is not installed: no {', '.join(MISSING)}"
)
CUPS = CopySpec("Cup", 4, ("red", "red", "green", "yellow"))
ROOM = "FloorPlan19"


@pytest.fixture(scope="module")
def episode() -> RoomEpisode:
    return RoomEpisode(ROOM, seed=3, copies=CUPS, views=72, color=False)


def outside_m(instance: Instance, points: np.ndarray) -> np.ndarray:
    low, high = instance.corners
    return np.maximum(np.maximum(low - points, points - high), 0).max(axis=1)


def points_of(
    ids: np.ndarray, number: int, depth_m: np.ndarray, intrinsics: Intrinsics, pose: Pose
) -> np.ndarray:
    rows, columns = np.nonzero(ids == number)
    return backproject(columns + 0.5, rows + 0.5, depth_m[rows, columns], intrinsics, pose)


def test_depth_of_a_wall_is_planar_and_metric():
    wall = Instance("Wall|0", "Wall", (box_part((-9, -9, 2), (9, 9, 2.5), (1, 1, 1)),))
    picture = Camera(60).take(
        RayCaster(make_soup([(1, wall.parts)])), pose_from_ai2thor((0.0, 1.576, 0.0), 0, 0)
    )
    assert picture.ids.min() == 1
    assert np.abs(picture.depth_m - 2.0).max() < 1e-5


def test_image_axes_are_those_of_ai2thor():
    """Yaw 90 faces +x: what lies at -z is on the right, what is high is at the top."""
    right = Instance("a", "Box", (box_part((2, 1.4, -1.2), (2.2, 1.7, -0.8), (1, 0, 0)),))
    above = Instance("b", "Box", (box_part((2, 2.4, -0.2), (2.2, 2.7, 0.2), (1, 0, 0)),))
    soup = make_soup([(1, right.parts), (2, above.parts)])
    ids = Camera(100).take(RayCaster(soup), pose_from_ai2thor((0.0, 1.576, 0.0), 90, 0)).ids
    rows, columns = np.nonzero(ids == 1)
    assert columns.min() > 60
    assert abs(rows.mean() - 50) < 5
    rows, columns = np.nonzero(ids == 2)
    assert rows.max() < 40
    assert abs(columns.mean() - 50) < 3


@pytest.mark.parametrize(("yaw_deg", "horizon_deg"), [(0, 0), (45, 30), (315, 30)])
def test_points_of_a_synthetic_scene_lie_in_their_boxes(yaw_deg, horizon_deg):
    table = Instance("Table", "DiningTable", (box_part((-1, 0, 1), (1, 0.75, 2.5), (1, 1, 1)),))
    blob = place((blob_part((0.2, 0.15, 0.3), (1, 0, 0)),), 30, (0.2, 0.75, 1.6))
    apple = Instance("Apple", "Apple", blob)
    caster = RayCaster(make_soup([(1, table.parts), (2, apple.parts)]))
    camera, pose = Camera(150), pose_from_ai2thor((0.1, 1.576, 0.0), yaw_deg, horizon_deg)
    picture = camera.take(caster, pose)
    seen = 0
    for number, instance in ((1, table), (2, apple)):
        points = points_of(picture.ids, number, picture.depth_m, camera.intrinsics, pose)
        if len(points):
            seen += 1
            assert outside_m(instance, points).max() < 1e-4
    assert seen >= 1


def test_points_of_a_real_room_lie_in_their_boxes(episode: RoomEpisode):
    checked = 0
    worst_m = 0.0
    messages = {}
    for view in episode.views[:48:8]:
        picture = episode.picture(view)
        depth_m = np.rint(picture.depth_m * 1000) / 1000  # as it travels, in millimetres
        for number in np.unique(picture.ids):
            instance = episode.scene.instances[number - 1]
            points = points_of(picture.ids, number, depth_m, Camera(300).intrinsics, view.pose())
            if len(points) >= 30:
                checked += 1
                p99_m = float(np.percentile(outside_m(instance, points), 99))
                worst_m = max(worst_m, p99_m)
                messages[instance.object_id] = p99_m
    assert checked > 60
    assert worst_m < 0.01, sorted(messages.items(), key=lambda pair: -pair[1])[:3]


def test_every_pixel_of_a_room_hits_something(episode: RoomEpisode):
    for view in episode.views[:40:10]:
        picture = episode.picture(view)
        assert picture.ids.min() >= 1
        assert picture.depth_m.min() > 0.02


def test_boxes_enclose_exactly_the_visible_pixels(episode: RoomEpisode):
    numbers = {item.object_id: item.number for item in episode.truth()}
    found = 0
    short = RoomEpisode(ROOM, seed=3, copies=CUPS, views=6, color=False)
    for message in short.messages():
        if not isinstance(message, SimDetections):
            continue
        ids = short.picture(short.views[message.frame]).ids
        for detection in message.detections:
            xmin, ymin, xmax, ymax = (int(value) for value in detection.box_px)
            mask = ids == numbers[detection.object_id]
            assert mask.sum() >= 30
            assert mask[ymin:ymax, xmin:xmax].sum() == mask.sum()
            assert mask[:, xmin].any()
            assert mask[:, xmax - 1].any()
            assert mask[ymin].any()
            assert mask[ymax - 1].any()
            assert detection.object_type not in ("Wall", "Floor", "Ceiling", "Structure")
            found += 1
    assert found > 30


def test_same_seed_same_bytes_other_seed_other_bytes():
    def encoded(seed: int) -> list[bytes]:
        messages = render_episode(ROOM, seed=seed, copies=CUPS, views=2, size_px=96)
        return [bytes(codec.encode(message)) for message in messages]

    first = encoded(3)
    assert encoded(3) == first
    assert encoded(4) != first


def test_messages_of_an_episode_come_in_order():
    messages = list(render_episode(ROOM, seed=1, views=2, size_px=64))
    assert [type(message) for message in messages] == [
        Exploration,
        *[ColorFrame, DepthFrame, SimDetections] * 2,
        Exploration,
    ]
    started, finished = messages[0], messages[-1]
    assert isinstance(started, Exploration)
    assert isinstance(finished, Exploration)
    assert (started.state, finished.state, finished.frames) == ("started", "finished", 2)
    assert {message.episode for message in messages} == {"FloorPlan19-seed1"}
    stamps = [message.stamp_ns for message in messages]
    assert stamps == sorted(stamps)
    assert stamps[4] == EPOCH_NS + FRAME_NS
