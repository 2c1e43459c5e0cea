"""AI2-THOR events as messages, and dumps of events as recordings."""

from __future__ import annotations

import gzip
import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from doro_schemas.errors import Refused
from doro_schemas.messages import ColorFrame, DepthFrame, Exploration, SimDetections
from doro_sim_feeder.ai2thor_objects import camera_of, objects_of, projected_box
from doro_sim_feeder.events import EventFolder, messages_of_event, read_event
from doro_sim_feeder.folder import FrameFolder
from doro_sim_feeder.recording import Recording, write_recording
from doro_sim_feeder.sources import open_folder
from tests.unit.ai2thor_scenes import (
    BOXES,
    DEPTH,
    EVENTS,
    KINDS,
    SIDE_PX,
    TABLE,
    Event,
    metadata,
    needs_events,
    thing,
)


def test_an_event_becomes_three_messages():
    boxes = {"Cup|1": (56, 72, 63, 79), "Wall|x": (0, 0, 9, 9)}
    color, depth, found = messages_of_event(Event(metadata(90.0), boxes, DEPTH), 4, "e1")
    assert isinstance(color, ColorFrame)
    assert isinstance(depth, DepthFrame)
    assert isinstance(found, SimDetections)
    assert {(m.frame, m.episode) for m in (color, depth, found)} == {(4, "e1")}
    assert color.stamp_ns == depth.stamp_ns == found.stamp_ns > 0
    image = cv2.imdecode(color.data, cv2.IMREAD_COLOR)
    assert image is not None
    assert image.shape == (SIDE_PX, SIDE_PX, 3)
    np.testing.assert_array_equal(depth.depth_m(), DEPTH)
    k = depth.intrinsics
    assert (k.fx, k.fy, k.cx, k.cy) == pytest.approx((60.0, 60.0, 60.0, 60.0))
    forward = np.asarray(depth.pose.rotation).reshape(3, 3)[:, 2]
    np.testing.assert_allclose(forward, [1, 0, 0], atol=1e-9)
    (cup,) = found.detections
    assert cup.box_px == [56.0, 72.0, 64.0, 80.0]
    assert cup.attributes == {"material": "plastic"}
    assert [(r.type, r.object_type, r.attributes) for r in cup.relations] == [
        ("is-on", "DiningTable", {"material": "wood"})
    ]


def test_depth_at_the_far_plane_is_unknown():
    far = DEPTH.copy()
    far[0, 0] = 20.0
    _, depth, _ = messages_of_event(Event(metadata(), {}, far), 0, "e")
    assert isinstance(depth, DepthFrame)
    assert depth.depth_m()[0, 0] == 0
    assert depth.depth_m()[1, 1] == np.float32(2.5)


def test_without_boxes_visible_objects_are_projected():
    _, found = messages_of_event(Event(metadata()), 0, "e")
    assert isinstance(found, SimDetections)
    boxes = {item.object_id: item.box_px for item in found.detections}
    assert sorted(boxes) == ["Cup|1", TABLE]
    # The cup's near face is 1.95 m away, its bottom and top 0.576 and 0.476 m below the camera.
    left, top, right, bottom = boxes["Cup|1"]
    assert left == pytest.approx(60 - 60 * 0.05 / 1.95, abs=1e-6)
    assert right == pytest.approx(60 + 60 * 0.05 / 1.95, abs=1e-6)
    assert top == pytest.approx(60 + 60 * 0.476 / 2.05, abs=1e-6)
    assert bottom == pytest.approx(60 + 60 * 0.576 / 1.95, abs=1e-6)


def test_a_box_that_reaches_behind_the_camera_is_cut_off():
    data = metadata(objects=[thing("Sofa|1", (0.6, 1.576, 0.3), 0.8)])
    (sofa,) = objects_of(data)
    intrinsics, pose = camera_of(data, SIDE_PX, SIDE_PX)
    box = projected_box(sofa.corners, intrinsics, pose, SIDE_PX, SIDE_PX)
    assert box is not None
    assert box[0] == pytest.approx(60 + 60 * 0.2 / 0.7)
    assert box[1:] == [0.0, float(SIDE_PX), float(SIDE_PX)]
    away = camera_of(metadata(180.0), SIDE_PX, SIDE_PX)[1]
    behind = objects_of(metadata(objects=[thing("Sofa|1", (0.6, 1.576, 3.0), 0.8)]))[0]
    assert projected_box(behind.corners, intrinsics, away, SIDE_PX, SIDE_PX) is None


def test_what_the_gripper_holds_stands_nowhere():
    data = metadata()
    data["objects"][0]["isPickedUp"] = True
    _, found = messages_of_event(Event(data, {"Cup|1": (56, 72, 63, 79)}), 0, "e")
    assert isinstance(found, SimDetections)
    assert found.detections[0].relations == []


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"fov": None}, "event 3: .*camera metadata"),
        ({"cameraPosition": {"x": 0.0}}, "event 3: .*camera metadata"),
        ({"objects": [{"objectId": "Cup|1"}]}, "event 3: .*object metadata"),
    ],
)
def test_bad_metadata_is_one_sentence(change: dict[str, Any], sentence: str):
    with pytest.raises(Refused, match=sentence) as caught:
        messages_of_event(Event(metadata(**change)), 3, "e")
    assert (caught.value.frame, caught.value.episode) == (3, "e")


def test_depth_of_another_size_is_refused():
    with pytest.raises(Refused, match="depth of shape"):
        messages_of_event(Event(metadata(), {}, DEPTH[:50]), 0, "e")


def dump(folder: Path, names: tuple[str, ...], *, depth: bool = False, **fields: Any) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for name in names:
        data = gzip.compress(json.dumps(metadata(**fields)).encode())
        (folder / f"{name}.metadata.json.gz").write_bytes(data)
        image = np.full((SIDE_PX, SIDE_PX, 3), 90, np.uint8)
        assert cv2.imwrite(str(folder / f"{name}.rgb.png"), image)
        if depth:
            np.save(folder / f"{name}.depth.npy", DEPTH)


def test_a_dump_with_depth_is_imported(tmp_path: Path):
    dump(tmp_path / "walk", ("000", "001"), depth=True)
    source = open_folder(tmp_path / "walk")
    assert isinstance(source, EventFolder)
    out = tmp_path / "out.mcap"
    assert write_recording(out, source.messages(), source.metadata([])) == 8
    recording = Recording(out)
    assert recording.metadata["room"] == "FloorPlan1"
    assert recording.metadata["depth"] == "f32_m"
    kinds = [type(sample.message()) for sample in recording.samples()]
    assert kinds == [Exploration, *[ColorFrame, DepthFrame, SimDetections] * 2, Exploration]


def test_a_dump_without_depth_says_so(tmp_path: Path):
    dump(tmp_path / "walk", ("000",))
    source = EventFolder(tmp_path / "walk")
    assert source.metadata([])["depth"] == "none"
    assert [type(m) for m in source.messages()] == [
        Exploration,
        ColorFrame,
        SimDetections,
        Exploration,
    ]


def test_dumps_that_cannot_be_one_recording_are_refused(tmp_path: Path):
    dump(tmp_path / "a" / "first", ("000",))
    dump(tmp_path / "a" / "second", ("000",), sceneName="FloorPlan2_physics")
    source = EventFolder(tmp_path / "a")
    assert source.tasks == ["first", "second"]
    with pytest.raises(Refused, match="2 rooms"):
        list(source.messages())
    assert len(list(source.messages(["second"]))) == 4
    with pytest.raises(Refused, match="no episode 'third'"):
        list(source.messages(["third"]))
    dump(tmp_path / "b", ("000",))
    dump(tmp_path / "b", ("001",), depth=True)
    with pytest.raises(Refused, match="no depth, others"):
        EventFolder(tmp_path / "b").metadata([])
    (tmp_path / "b" / "001.metadata.json.gz").write_bytes(b"\x1f\x8bnothing")
    with pytest.raises(Refused, match="cannot be read"):
        EventFolder(tmp_path / "b").metadata([])


def test_folders_are_told_apart(tmp_path: Path):
    frames = {"width": 4, "height": 4, "frames": []}
    (tmp_path / "frames.json").write_text(json.dumps(frames))
    assert isinstance(open_folder(tmp_path), FrameFolder)
    (tmp_path / "empty").mkdir()
    with pytest.raises(Refused, match="neither"):
        open_folder(tmp_path / "empty")
    with pytest.raises(Refused, match="no folder"):
        open_folder(tmp_path / "missing")


@needs_events
def test_projected_boxes_agree_with_hand_checked_ones():
    """The 84 boxes that a person found to lie on a clearly seen object."""
    checked = 0
    worst_px = 0.0
    for entry in json.loads(BOXES.read_text()):
        boxes = [box for box in entry["l"] if not box["ig"]]
        if not boxes:
            continue
        event = read_event(EVENTS.parent / entry["f"].removesuffix(".rgb.png"))
        height_px, width_px = event.frame.shape[:2]
        intrinsics, pose = camera_of(event.metadata, height_px, width_px)
        objects = objects_of(event.metadata)
        for box in boxes:
            kinds = KINDS.get(box["c"], (box["c"],))
            errors = [
                float(np.abs(np.subtract(made, box["b"])).max())
                for item in objects
                if item.object_type in kinds
                and (made := projected_box(item.corners, intrinsics, pose, height_px, width_px))
            ]
            assert errors, (entry["f"], box)
            worst_px = max(worst_px, min(errors))
            checked += 1
    assert checked == 84
    assert worst_px < 0.1  # they are written with one decimal


@needs_events
def test_the_recorded_events_are_imported(tmp_path: Path):
    source = EventFolder(EVENTS)
    assert len(source.tasks) == 12
    name = "look_in_light_book"
    out = tmp_path / "bedroom.mcap"
    write_recording(out, source.messages([name]), source.metadata([name]))
    recording = Recording(out)
    assert recording.metadata["room"] == "FloorPlan301"
    assert recording.metadata["depth"] == "none"
    found = [
        detection
        for sample in recording.samples()
        if isinstance(message := sample.message(), SimDetections)
        for detection in message.detections
    ]
    assert len(found) == 58
    held = {(i.object_type, r.type, r.object_type) for i in found for r in i.relations}
    assert {("Laptop", "is-on", "Bed"), ("AlarmClock", "is-on", "Dresser")} <= held
    assert ("CD", "is-at", "Desk") in held
    assert {"material"} == {key for item in found for key in item.attributes}
