"""Puts messages into a Rerun recording. It reads no clock and asks nothing of the bus.

Entities: ``camera/<camera>/image`` (with ``/objects``) and ``/depth``; ``map/grid/<class>``,
``map/floor``, ``map/path``, ``map/camera/<camera>``, ``map/instances``, ``map/target``;
``talk/<kind>``. The map is drawn in (ground a, ground b, up), which is right-handed for
both worlds. Timelines: ``frame`` (running over episodes) and ``stamp`` (the data's time).
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
import rerun as rr
from doro_schemas import messages as m
from doro_schemas.camera import World, bev_axes
from doro_schemas.messages.base import Message

from doro_viewer.colors import graph_color, mix, stable_color
from doro_viewer.grid_state import FrameClock, GridState
from doro_viewer.rerun_views import (
    MAP,
    TALK,
    TIMELINE,
    Bounds,
    blueprint,
    depth_entity,
    image_entity,
)
from doro_viewer.settings import ViewerSettings
from doro_viewer.talk import talk_lines
from doro_viewer.words import short_description

LABEL_CHARS = 48
FLUSH_TIMEOUT_S = 10.0
BOUNDS_MARGIN_M = 1.0
UNCLASSED = (150, 150, 150)
INK = (40, 40, 40)
PATH = (30, 90, 200)
ACCENT = (230, 0, 120)
MEDIA_TYPES = {"jpeg": "image/jpeg", "png": "image/png"}


def _short(text: str) -> str:
    return text if len(text) <= LABEL_CHARS else text[: LABEL_CHARS - 3] + "..."


class RerunLog:
    """A screen that shows messages in Rerun.

    Args:
        stream: where to; its sinks (file, live viewer) are the caller's.
        settings: what is shown.
    """

    def __init__(self, stream: rr.RecordingStream, settings: ViewerSettings) -> None:
        self._stream = stream
        self._settings = settings
        self._world: World = settings.world
        self._clock = FrameClock()
        self._grid = GridState()
        self._cameras: list[str] = []
        self._coded: dict[str, tuple[str, int]] = {}
        self._path: list[list[float]] = []
        self._bounds = Bounds()
        self._query: m.Query | None = None
        self._unflushed = 0
        self._belief = ""
        self._show: dict[type[Message], Callable[[Any], None]] = {
            m.ColorFrame: self._color,
            m.DepthFrame: self._depth,
            m.FrameCaptions: self._captions,
            m.FrameGraphs: self._graphs,
            m.GridDelta: self._delta,
            m.GridSnapshot: self._snapshot,
            m.Instances: self._instances,
            m.Exploration: self._exploration,
            m.Target: self._target,
        }
        stream.log(MAP, rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
        self._arrange()

    def show(self, message: Message) -> None:
        """Log a message; a type that nothing is shown of only moves the talk."""
        self._at(message)
        if type(message) in self._show:
            self._show[type(message)](message)
        self._talk(message)

    def flush(self) -> None:
        """Write everything through to the file and the live viewer.

        A live viewer that went away is reported on stderr; the recording goes on.
        """
        self._unflushed = 0
        try:
            self._stream.flush(timeout_sec=FLUSH_TIMEOUT_S)
        except (RuntimeError, ValueError) as error:
            print(f"doro-viewer: Rerun could not be flushed: {error}", file=sys.stderr)

    def close(self) -> None:
        """Flush, then end the recording with its footer."""
        self.flush()
        self._stream.disconnect()

    def _at(self, message: Message) -> None:
        frame = getattr(message, "frame", None)
        if isinstance(message, m.Exploration) and message.state == "started":
            self._clock.start(message.episode)
        position = self._clock.latest
        if isinstance(frame, int) and frame >= 0:
            position = self._clock.place(message.episode, frame)
        self._stream.set_time(TIMELINE, sequence=position)
        if message.stamp_ns > 0:
            self._stream.set_time("stamp", timestamp=np.datetime64(message.stamp_ns, "ns"))
        else:
            self._stream.disable_timeline("stamp")

    def _arrange(self) -> None:
        shown = blueprint(self._cameras or ["cam0"], self._bounds, depth=self._settings.depth)
        self._stream.send_blueprint(shown)

    def _meet(self, camera: str) -> None:
        """Give a camera that is new its view."""
        if camera not in self._cameras:
            self._cameras.append(camera)
            self._arrange()

    def _color(self, frame: m.ColorFrame) -> None:
        self._meet(frame.camera)
        if frame.encoding == "rgb8":
            quality = [cv2.IMWRITE_JPEG_QUALITY, self._settings.jpeg_quality]
            bgr = cv2.cvtColor(frame.data, cv2.COLOR_RGB2BGR)
            contents, kind = cv2.imencode(".jpg", bgr, quality)[1].tobytes(), "jpeg"
        else:
            contents, kind = frame.data.tobytes(), frame.encoding
        image = rr.EncodedImage(contents=contents, media_type=MEDIA_TYPES[kind])
        self._stream.log(image_entity(frame.camera), image)
        self._unflushed += 1
        if self._unflushed >= self._settings.flush_frames:
            self.flush()

    def _depth(self, frame: m.DepthFrame) -> None:
        self._world = frame.pose.world
        axes = list(bev_axes(self._world))
        position_m = [frame.pose.position_m[axis] for axis in axes]
        self._path.append(position_m)
        self._stream.log(
            f"{MAP}/path",
            rr.LineStrips3D([self._path], colors=[PATH], radii=rr.Radius.ui_points(1.5)),
        )
        inner, step = frame.intrinsics, self._settings.depth_stride
        self._stream.log(
            f"{MAP}/camera/{frame.camera}",
            rr.Transform3D(translation=position_m, mat3x3=frame.pose.matrix()[axes]),
            rr.Pinhole(
                focal_length=(inner.fx, inner.fy),
                principal_point=(inner.cx, inner.cy),
                resolution=(frame.width_px, frame.height_px),
                image_plane_distance=0.35,
                color=PATH,
            ),
        )
        if self._settings.depth:
            depth = np.ascontiguousarray(frame.depth_m()[::step, ::step])
            self._stream.log(depth_entity(frame.camera), rr.DepthImage(depth, meter=1.0))

    def _captions(self, captions: m.FrameCaptions) -> None:
        """Show boxes at once; the coloured ones of the same frame's graphs replace them."""
        if self._coded.get(captions.camera) == (captions.episode, captions.frame):
            return
        found = captions.detections
        self._boxes(
            captions.camera,
            [box.box_px for box in found],
            [short_description(box.graph) if box.graph else box.caption for box in found],
            [UNCLASSED] * len(found),
        )

    def _graphs(self, graphs: m.FrameGraphs) -> None:
        self._coded[graphs.camera] = (graphs.episode, graphs.frame)
        found = graphs.detections
        self._boxes(
            graphs.camera,
            [box.box_px for box in found],
            [box.caption or short_description(box.graph) for box in found],
            [stable_color(box.graph.name) for box in found],
        )

    def _boxes(self, camera: str, boxes: list[list[float]], labels: list[str], colors: Any) -> None:
        self._stream.log(
            f"{image_entity(camera)}/objects",
            rr.Boxes2D(
                array=np.asarray(boxes, dtype=np.float32).reshape(-1, 4),
                array_format=rr.Box2DFormat.XYXY,
                labels=[_short(label) for label in labels],
                colors=colors,
                show_labels=True,
            ),
        )

    def _delta(self, delta: m.GridDelta) -> None:
        if delta.reset:
            self._forget_map()
        self._draw_classes(self._grid.apply(delta))

    def _snapshot(self, snapshot: m.GridSnapshot) -> None:
        self._draw_classes(self._grid.replace(snapshot))
        if len(snapshot.floor):
            ground_m = (snapshot.floor.astype(np.float32) + 0.5) * np.float32(snapshot.cell_m)
            points = np.column_stack([ground_m, np.full(len(ground_m), -0.02, np.float32)])
            floor = rr.Points3D(points, radii=[snapshot.cell_m / 2], colors=[(225, 225, 225)])
            self._stream.log(f"{MAP}/floor", floor)

    def _draw_classes(self, names: list[str]) -> None:
        for name in names:
            centers = self._grid.centers_m(name)
            points = rr.Points3D(
                centers, radii=[self._grid.cell_m / 2], colors=[stable_color(name)]
            )
            self._stream.log([MAP, "grid", name], points)
            self._widen(centers)

    def _widen(self, centers: np.ndarray[Any, Any]) -> None:
        """Lift the eye when the map outgrows what is in view: seldom, as it undoes zooming."""
        if not len(centers):
            return
        low, high = centers[:, :2].min(axis=0).tolist(), centers[:, :2].max(axis=0).tolist()
        if not self._bounds.covers(Bounds(low_m=(low[0], low[1]), high_m=(high[0], high[1]))):
            lows = [min(a, b) for a, b in zip(self._bounds.low_m, low, strict=True)]
            highs = [max(a, b) for a, b in zip(self._bounds.high_m, high, strict=True)]
            seen = Bounds(low_m=(lows[0], lows[1]), high_m=(highs[0], highs[1]))
            self._bounds = seen.grown(BOUNDS_MARGIN_M)
            self._arrange()

    def _instances(self, instances: m.Instances) -> None:
        axes = list(bev_axes(self._world))
        found = instances.instances
        matches = self._query.matches if self._query else []
        self._stream.log(
            f"{MAP}/instances",
            rr.Boxes3D(
                centers=[[one.position_m[axis] for axis in axes] for one in found],
                half_sizes=[[one.extent_m[axis] / 2 for axis in axes] for one in found],
                labels=[f"{one.instance_id}: {short_description(one.graph, 0)}" for one in found],
                colors=[mix(graph_color(one.graph), INK, 0.3) for one in found],
                radii=[0.02 if one.instance_id in matches else 0.008 for one in found],
                show_labels=True,
            ),
        )

    def _exploration(self, exploration: m.Exploration) -> None:
        if exploration.state == "started":
            self._forget_map()

    def _forget_map(self) -> None:
        for name in self._grid.clear():
            self._stream.log([MAP, "grid", name], rr.Clear(recursive=False))
        for leaf in ("floor", "path", "instances", "target"):
            self._stream.log(f"{MAP}/{leaf}", rr.Clear(recursive=False))
        self._path.clear()

    def _target(self, target: m.Target) -> None:
        axes = list(bev_axes(self._world))
        self._stream.log(
            f"{MAP}/target",
            rr.Boxes3D(
                centers=[[target.position_m[axis] for axis in axes]],
                half_sizes=[[target.extent_m[axis] / 2 + 0.03 for axis in axes]],
                labels=[f"target: {target.instance_id}"],
                colors=[ACCENT],
                radii=[0.02],
            ),
        )

    def _talk(self, message: Message) -> None:
        if isinstance(message, m.Query):
            self._query = message
        if isinstance(message, m.Belief):
            told = f"{message.dialogue_id} {message.state} {message.reason} {message.matches}"
            if told == self._belief:
                return
            self._belief = told
        for kind, level, text in talk_lines(message):
            self._stream.log(f"{TALK}/{kind}", rr.TextLog(text, level=level))
        if isinstance(message, m.Query):
            self.flush()
