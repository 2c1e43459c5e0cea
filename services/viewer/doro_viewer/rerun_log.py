"""Puts messages into a Rerun recording. It reads no clock and asks nothing of the bus.

Entities: ``camera/<camera>/image`` (with ``/objects``) and ``/depth``; ``map/grid/<class>``,
``map/floor``, ``map/path``, ``map/camera/<camera>``, ``map/instances``, ``map/target``;
``map/labels``; ``summary``; ``talk``. Timelines: ``frame`` (running over episodes) and
``stamp`` (the data's time).
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
import rerun as rr

from doro_schemas import messages as m
from doro_schemas.messages.base import Message
from doro_schemas.vocabulary import name_satisfies
from doro_viewer.colors import stable_color
from doro_viewer.grid_state import FrameClock
from doro_viewer.rerun_map import RerunMap
from doro_viewer.rerun_views import (
    SUMMARY,
    TALK,
    TIMELINE,
    blueprint,
    depth_entity,
    image_entity,
)
from doro_viewer.settings import ViewerSettings
from doro_viewer.talk import summary, talk_lines
from doro_viewer.words import short_description

LABEL_CHARS = 48
FLUSH_TIMEOUT_S = 10.0
UNCLASSED = (150, 150, 150)
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
        self._clock = FrameClock()
        self._map = RerunMap(stream, settings.world)
        self._cameras: list[str] = []
        self._coded: dict[str, tuple[str, int]] = {}
        self._instruction: m.InstructionGraph | None = None
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
            m.Instances: lambda found: self._map.instances(found, self._query),
            m.Exploration: self._exploration,
            m.Target: self._map.target,
        }
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
        shown = blueprint(self._cameras or ["cam0"], self._map.bounds, depth=self._settings.depth)
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
        self._map.camera(frame)
        if self._settings.depth:
            step = self._settings.depth_stride
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
            [self._label(box) for box in found],
            [stable_color(box.graph.name) for box in found],
        )

    def _label(self, box: m.GraphBox) -> str:
        """Return the caption of what is asked for, of all else the class: it gets crowded."""
        asked = self._instruction.graph if self._instruction else None
        if asked is not None and name_satisfies(asked.name, box.graph.name):
            return box.caption or short_description(box.graph)
        return box.graph.name

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
        if self._map.delta(delta):
            self._arrange()

    def _snapshot(self, snapshot: m.GridSnapshot) -> None:
        if self._map.snapshot(snapshot):
            self._arrange()

    def _exploration(self, exploration: m.Exploration) -> None:
        if exploration.state == "started":
            self._map.forget()
            self._query = None

    def _talk(self, message: Message) -> None:
        if isinstance(message, m.Belief):
            told = f"{message.dialogue_id} {message.state} {message.reason} {message.matches}"
            if told == self._belief:
                return
            self._belief = told
        # One entity for all: Rerun orders lines of one frame by entity, then as they came.
        for level, text in talk_lines(message):
            self._stream.log(TALK, rr.TextLog(text, level=level))
        if isinstance(message, m.InstructionGraph):
            self._instruction, self._query = message, None
        elif isinstance(message, m.Query):
            self._query = message
        else:
            return
        text = summary(self._instruction, self._query)
        self._stream.log(SUMMARY, rr.TextDocument(text, media_type="text/markdown"))
        self.flush()
