"""AI2-THOR events as messages: genuine events, dumps, and a stand-in for the simulator."""

from __future__ import annotations

import gzip
import importlib.util
import json
import sys
import types
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from doro_schemas import codec
from doro_schemas.camera import backproject, project
from doro_schemas.errors import Refused
from doro_schemas.messages import ColorFrame, DepthFrame, Exploration, SimDetections
from doro_sim_feeder.ai2thor_objects import camera_of, objects_of, projected_box
from doro_sim_feeder.events import EventFolder, messages_of_event, read_event
from doro_sim_feeder.folder import FrameFolder
from doro_sim_feeder.recording import Recording, write_recording
from doro_sim_feeder.simulator import SimulatorSettings, explore, open_controller
from doro_sim_feeder.sources import open_folder

SHARED = Path(__file__).resolve().parents[3] / "shared" / "data"
EVENTS = SHARED / "ai2thor_events" / "events"
BOXES = SHARED / "ai2thor_events_boxes" / "boxes.json"
needs_events = pytest.mark.skipif(
    not EVENTS.is_dir(), reason="no recorded events beside the project"
)
needs_ai2thor = pytest.mark.skipif(
    importlib.util.find_spec("ai2thor") is None, reason="the extra 'ai2thor' is not installed"
)
SIDE_PX = 120
KINDS = {"Table": ("Desk",), "Sofa": ("Sofa", "ArmChair")}  # the boxes have COCO's classes


def thing(object_id: str, center: tuple[float, float, float], size: float, **fields: Any) -> Any:
    """Return one object as AI2-THOR's metadata has it."""
    x, y, z = center
    corners = [
        [x + a * size / 2, y + b * size / 2, z + c * size / 2]
        for a in (1, -1)
        for b in (1, -1)
        for c in (1, -1)
    ]
    return {
        "objectId": object_id,
        "objectType": object_id.split("|", maxsplit=1)[0],
        "parentReceptacles": None,
        "salientMaterials": None,
        "pickupable": False,
        "visible": True,
        "isPickedUp": False,
        "axisAlignedBoundingBox": {
            "cornerPoints": corners,
            "center": {"x": x, "y": y, "z": z},
            "size": dict.fromkeys("xyz", size),
        },
        "objectOrientedBoundingBox": None,
        **fields,
    }


TABLE = "DiningTable|1"


def metadata(yaw_deg: float = 0.0, **fields: Any) -> dict[str, Any]:
    """A cup on a table, 2 m ahead of the standing agent; a wall; a far, invisible plate."""
    return {
        "objects": [
            thing(
                "Cup|1",
                (0.0, 1.05, 2.0),
                0.1,
                parentReceptacles=[TABLE],
                salientMaterials=["Food", "Plastic"],
                pickupable=True,
            ),
            thing(TABLE, (0.0, 0.5, 2.0), 1.0, salientMaterials=["Wood"]),
            thing("Plate|1", (0.3, 1.5, 4.0), 0.2, visible=False),
        ],
        "agent": {"rotation": {"x": 0, "y": yaw_deg, "z": 0}, "cameraHorizon": 0.0},
        "fov": 90.0,
        "cameraPosition": {"x": 0.0, "y": 1.576, "z": 0.0},
        "sceneName": "FloorPlan1_physics",
        "lastActionSuccess": True,
        "actionReturn": None,
        **fields,
    }


class Event:
    """What :func:`messages_of_event` needs of an event."""

    def __init__(self, data: dict[str, Any], boxes: Any = None, depth: Any = None) -> None:
        self.metadata = data
        self.frame = np.full((SIDE_PX, SIDE_PX, 3), 90, np.uint8)
        self.depth_frame = depth
        self.instance_detections2D = boxes


DEPTH = np.full((SIDE_PX, SIDE_PX), 2.5, np.float32)


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


class StandIn:
    """Returns genuine ``ai2thor.server.Event`` objects, as the controller would.

    The metadata are recorded ones; depth and instance colours, which were not recorded, are
    rendered from the same room at the recorded pose.
    """

    def __init__(self, blocked: int = 0) -> None:
        from doro_sim_feeder.rooms.renderers import make_renderer
        from doro_sim_feeder.rooms.scene import build_scene

        self.scene = build_scene("FloorPlan301")
        self.renderer = make_renderer("embree", self.scene, color=False)
        stems = sorted(
            {
                path.parent / path.name.removesuffix(".metadata.json.gz")
                for task in ("clean_up_bedroom", "prepare_going_to_bed")
                for path in (EVENTS / task).glob("*.metadata.json.gz")
            }
        )
        self.dumped = [read_event(stem) for stem in stems]
        self.actions: list[dict[str, Any]] = []
        self.blocked = blocked
        self.stopped = False

    def step(self, **action: Any) -> Any:
        self.actions.append(action)
        if action["action"] == "GetReachablePositions":
            return self.event(0, actionReturn=self.positions())
        self.blocked -= 1
        if self.blocked >= 0:
            return self.event(0, lastActionSuccess=False)
        at = action["position"]
        distances = [
            abs(p["x"] - at["x"]) + abs(p["z"] - at["z"])
            for p in (one.metadata["agent"]["position"] for one in self.dumped)
        ]
        return self.event(int(np.argmin(distances)))

    def stop(self) -> None:
        self.stopped = True

    def positions(self) -> list[dict[str, float]]:
        unique: dict[tuple[float, float], dict[str, float]] = {}
        for one in self.dumped:
            at = one.metadata["agent"]["position"]
            unique.setdefault((at["x"], at["z"]), at)
        return list(unique.values())

    def event(self, index: int, **fields: Any) -> Any:
        from ai2thor.server import DepthFormat
        from ai2thor.server import Event as ThorEvent

        dumped = self.dumped[index]
        picture = self.renderer.take(camera_of(dumped.metadata, 300, 300)[1])
        colors = [
            {"name": item.object_id, "color": [number % 256, number // 256, 7]}
            for number, item in enumerate(self.scene.instances, start=1)
        ]
        event = ThorEvent({**dumped.metadata, "colors": colors, **fields})
        ids = np.zeros((300, 300, 4), np.uint8)
        ids[..., 0], ids[..., 1] = picture.ids % 256, picture.ids // 256
        ids[..., 2], ids[..., 3] = 7, 255
        event.add_image(dumped.frame[::-1].tobytes())  # Unity's images stand on their heads
        event.add_image_ids(ids[::-1].tobytes())
        event.add_image_depth(
            picture.depth_m[::-1].tobytes(),
            depth_format=DepthFormat.Meters,
            camera_near_plane=0.1,
            camera_far_plane=20.0,
        )
        return event


SETTINGS = SimulatorSettings(room="FloorPlan301", seed=2)
needs_render = pytest.mark.skipif(
    any(importlib.util.find_spec(name) is None for name in ("embreex", "procthor", "PIL")),
    reason="the extra 'render' is not installed",
)


@needs_ai2thor
@needs_events
@needs_render
def test_an_exploration_of_the_simulator_is_recorded(tmp_path: Path):
    controller = StandIn()
    messages = list(explore(controller, SETTINGS))
    cells = len(controller.positions())
    assert cells > 3
    assert [type(m) for m in messages] == [
        Exploration,
        *[ColorFrame, DepthFrame, SimDetections] * cells,
        Exploration,
    ]
    teleports = [one for one in controller.actions if one["action"] == "Teleport"]
    assert len({(a["position"]["x"], a["position"]["z"]) for a in teleports}) == cells
    assert len({a["rotation"]["y"] for a in teleports}) > 2
    again = StandIn()
    assert [bytes(codec.encode(m)) for m in explore(again, SETTINGS)] == [
        bytes(codec.encode(m)) for m in messages
    ]
    assert again.actions == controller.actions
    out = tmp_path / "thor.mcap"
    assert write_recording(out, messages, SETTINGS.recording_metadata()) == 2 + 3 * cells


@needs_ai2thor
@needs_events
@needs_render
def test_genuine_events_pass_the_checks_of_rendered_frames():
    """Points of a box's pixels lie in the object's 3-D box; the box's edges are exclusive."""
    controller = StandIn()
    numbers = {item.object_id: k for k, item in enumerate(controller.scene.instances, start=1)}
    checked = 0
    for index in range(0, len(controller.dumped), 8):
        event = controller.event(index)
        _, depth, found = messages_of_event(event, index, "e")
        assert isinstance(depth, DepthFrame)
        assert isinstance(found, SimDetections)
        for item in found.detections:
            mask = event.instance_masks[item.object_id]
            left, top, right, bottom = (int(value) for value in item.box_px)
            assert mask[top:bottom, left:right].sum() == mask.sum()
            assert mask[:, right - 1].any()
            assert mask[bottom - 1].any()
            rows, columns = np.nonzero(mask)
            points = backproject(
                columns + 0.5, rows + 0.5, depth.depth_m()[mask], depth.intrinsics, depth.pose
            )
            low, high = controller.scene.instances[numbers[item.object_id] - 1].corners
            outside = np.maximum(np.maximum(low - points, points - high), 0).max(axis=1)
            assert np.percentile(outside, 99) < 0.01
            u, v, z = project(points, depth.intrinsics, depth.pose)
            assert np.abs(u - columns - 0.5).max() < 1e-3
            assert np.abs(v - rows - 0.5).max() < 1e-3
            assert z.min() > 0
            checked += 1
    assert checked > 40


@needs_ai2thor
@needs_events
@needs_render
def test_cells_where_the_agent_does_not_fit_are_left_out():
    controller = StandIn(blocked=2)
    messages = list(explore(controller, SETTINGS))
    frames = [m.frame for m in messages if isinstance(m, DepthFrame)]
    assert frames == list(range(len(controller.positions()) - 2))
    assert isinstance(messages[-1], Exploration)
    assert messages[-1].frames == len(frames)
    with pytest.raises(Refused, match="none of the"):
        list(explore(StandIn(blocked=1000), SETTINGS))


class Bare:
    """A controller whose events have neither depth nor segmentation."""

    def __init__(self, positions: list[dict[str, float]]) -> None:
        self.positions = positions

    def step(self, **action: Any) -> Any:
        reachable = action["action"] == "GetReachablePositions"
        return Event(metadata(actionReturn=self.positions if reachable else None))

    def stop(self) -> None:
        pass


@needs_render
def test_a_simulator_that_gives_too_little_is_refused():
    with pytest.raises(Refused, match="renderDepthImage"):
        list(explore(Bare([{"x": 0.0, "y": 0.9, "z": 0.25}]), SETTINGS))
    with pytest.raises(Refused, match="no reachable position"):
        list(explore(Bare([]), SETTINGS))


def test_without_ai2thor_the_refusal_says_what_to_do(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setitem(sys.modules, "ai2thor.controller", None)
    with pytest.raises(Refused, match="doro-sim-feeder\\[ai2thor\\]"):
        open_controller(SETTINGS)


def test_a_simulator_that_does_not_start_is_one_sentence(monkeypatch: pytest.MonkeyPatch):
    asked: dict[str, Any] = {}

    def fail(**arguments: Any) -> None:
        asked.update(arguments)
        raise RuntimeError("no build for this machine")

    module = types.ModuleType("ai2thor.controller")
    module.Controller = fail  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "ai2thor", types.ModuleType("ai2thor"))
    monkeypatch.setitem(sys.modules, "ai2thor.controller", module)
    with pytest.raises(Refused, match="did not start with FloorPlan301: no build"):
        open_controller(SETTINGS)
    assert asked["renderDepthImage"]
    assert asked["renderInstanceSegmentation"]
    assert (asked["gridSize"], asked["fieldOfView"], asked["width"]) == (0.25, 90, 300)
