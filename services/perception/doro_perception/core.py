"""The core of perception: frames in, captions out. No clock, no bus, no state but counters."""

from __future__ import annotations

from doro_perception.backend import Detection, DetectionBackend, RgbImage, big_enough, clip_box
from doro_perception.caption import caption
from doro_perception.colour import colour_of_box
from doro_perception.image import decode
from doro_perception.oracle import Oracle
from doro_perception.settings import PerceptionSettings
from doro_schemas.detector_errors import FalsePositivePool, disturb
from doro_schemas.effects import Output
from doro_schemas.errors import Refused
from doro_schemas.graph import ObjectGraph
from doro_schemas.messages import (
    CaptionedBox,
    ClassProbability,
    ColorFrame,
    FrameCaptions,
    SimDetections,
)


class Perception:
    """Turns each frame into one FrameCaptions.

    Args:
        settings: the table ``[perception]``.
        backend: the detector that looks at images; not needed by the oracle.
        pool: what the oracle's false positives are drawn from.
    """

    def __init__(
        self,
        settings: PerceptionSettings,
        backend: DetectionBackend | None = None,
        pool: FalsePositivePool | None = None,
    ) -> None:
        self._settings = settings
        self._errors = settings.error_models()
        self._pool = pool
        self._backend = backend
        self._oracle = Oracle(settings)
        self.counters: dict[str, int] = {"frames": 0, "detections": 0, "left_out": 0}

    def sim_detections(self, frame: SimDetections) -> list[Output]:
        """Caption what the simulator knows, after the error models have been at it.

        Raises:
            Refused: a class or value that cannot be said; false positives from no other room.
        """
        try:
            seen = disturb(frame, self._errors, self._pool) if self._errors.errors else frame
            boxes = self._oracle.describe(seen)
        except Refused as error:
            raise Refused(error.reason, episode=frame.episode, frame=frame.frame) from error
        return [self._captions(seen, boxes, len(seen.detections))]

    def color_frame(self, frame: ColorFrame) -> list[Output]:
        """Detect and caption what a colour image shows.

        Raises:
            Refused: an image that cannot be decoded, or no detector to look at it.
        """
        if self._backend is None:
            raise Refused(
                "a colour frame came, but perception.backend is 'oracle': set it to 'onnx'",
                episode=frame.episode,
                frame=frame.frame,
            )
        rgb = decode(frame)
        found = self._backend.detect(rgb)
        boxes = []
        for detection in found:
            box_px = clip_box(detection.box_px, frame.height_px, frame.width_px)
            if big_enough(box_px, self._settings.min_side_px, self._settings.min_area_px):
                boxes.append(self._describe(rgb, box_px, detection))
        return [self._captions(frame, boxes, len(found))]

    def _describe(self, rgb: RgbImage, box_px: list[float], detection: Detection) -> CaptionedBox:
        """Return the captioned box of a detection; relations are the map's to find."""
        colour = colour_of_box(rgb, box_px) if self._settings.colour else None
        attributes = {} if colour is None else {"color": colour}
        graph = ObjectGraph(name=detection.name, attributes=attributes)
        classes = [
            ClassProbability(name=name, probability=share) for name, share in detection.classes
        ]
        if self._settings.emit == "graphs":
            return CaptionedBox(box_px=box_px, score=detection.score, graph=graph, classes=classes)
        return CaptionedBox(
            box_px=box_px, score=detection.score, caption=caption(graph), classes=classes
        )

    def _captions(
        self, frame: SimDetections | ColorFrame, boxes: list[CaptionedBox], offered: int
    ) -> FrameCaptions:
        """Return the message for a frame; an empty one says that nothing was seen."""
        self.counters["frames"] += 1
        self.counters["detections"] += len(boxes)
        self.counters["left_out"] += offered - len(boxes)
        return FrameCaptions(
            stamp_ns=frame.stamp_ns,
            episode=frame.episode,
            camera=frame.camera,
            frame=frame.frame,
            height_px=frame.height_px,
            width_px=frame.width_px,
            detections=boxes,
        )
