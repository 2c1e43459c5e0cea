"""Recording from the simulator: a stand-in for its controller that returns genuine events."""

from __future__ import annotations

import importlib.util
import sys
import types
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from doro_schemas import codec
from doro_schemas.camera import backproject, project
from doro_schemas.errors import Refused
from doro_schemas.messages import ColorFrame, DepthFrame, Exploration, SimDetections
from doro_sim_feeder.ai2thor_objects import camera_of
from doro_sim_feeder.events import messages_of_event, read_event
from doro_sim_feeder.recording import write_recording
from doro_sim_feeder.simulator import SimulatorSettings, explore, open_controller
from tests.unit.ai2thor_scenes import (
    EVENTS,
    Event,
    metadata,
    needs_ai2thor,
    needs_events,
)


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
