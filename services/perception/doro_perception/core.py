"""The core of perception: frames in, captions out. No clock, no bus.

Besides counters it holds colour images that wait for their depth, where relations are to be
measured (``perception.relations = "depth"``).
"""

from __future__ import annotations

from doro_perception.backend import (
    Detection,
    DetectionBackend,
    RgbImage,
    big_enough,
    clip_box,
)
from doro_perception.caption import caption
from doro_perception.colour import colour_of_box
from doro_perception.image import decode
from doro_perception.image_relations import Found, from_boxes, from_depth
from doro_perception.oracle import Oracle
from doro_perception.settings import PerceptionSettings
from doro_perception.stages import Stages
from doro_schemas.detector_errors import FalsePositivePool, disturb
from doro_schemas.effects import Output
from doro_schemas.errors import Refused
from doro_schemas.graph import ObjectGraph, Relation
from doro_schemas.messages import (
    AttributeShares,
    CaptionedBox,
    ClassProbability,
    ColorFrame,
    DepthFrame,
    FrameCaptions,
    SimDetections,
    UnnamedRegion,
)

WAITING_FRAMES = 4
MIN_IMAGE_SIDE_PX = 16
Key = tuple[str, str, int]


class Perception:
    """Turns each frame into one FrameCaptions.

    Args:
        settings: the table ``[perception]``.
        backend: the detector that looks at images; not needed by the oracle.
        pool: what the oracle's false positives are drawn from.
        stages: times the stages; the same object that the backend was given.
    """

    def __init__(
        self,
        settings: PerceptionSettings,
        backend: DetectionBackend | None = None,
        pool: FalsePositivePool | None = None,
        stages: Stages | None = None,
    ) -> None:
        self._settings = settings
        self._errors = settings.error_models()
        self._pool = pool
        self._backend = backend
        self._stages = stages or Stages()
        self._oracle = Oracle(settings)
        self._colors: dict[Key, ColorFrame] = {}
        self._depths: dict[Key, DepthFrame] = {}
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
        return [self._message(seen, boxes, len(seen.detections))]

    def color_frame(self, frame: ColorFrame) -> list[Output]:
        """Detect and caption what a colour image shows.

        Where relations are measured in depth, the image waits for its depth frame; when more
        than a few wait, the oldest is described without.

        Raises:
            Refused: an image that cannot be decoded, or no detector to look at it.
        """
        if self._settings.relations != "depth":
            return [self._look(frame, None)]
        depth = self._depths.pop(_key(frame), None)
        if depth is not None:
            return [self._look(frame, depth)]
        self._colors[_key(frame)] = frame
        if len(self._colors) <= WAITING_FRAMES:
            return []
        return [self._look(self._colors.pop(next(iter(self._colors))), None)]

    def depth_frame(self, depth: DepthFrame) -> list[Output]:
        """Describe the colour image that waits for this depth, or keep the depth for it."""
        color = self._colors.pop(_key(depth), None)
        if color is not None:
            return [self._look(color, depth)]
        self._depths[_key(depth)] = depth
        if len(self._depths) > WAITING_FRAMES:
            del self._depths[next(iter(self._depths))]
        return []

    def _look(self, frame: ColorFrame, depth: DepthFrame | None) -> FrameCaptions:
        if self._backend is None:
            raise Refused(
                "a colour frame came, but perception.backend is 'oracle': set it to 'captioner'",
                episode=frame.episode,
                frame=frame.frame,
            )
        if min(frame.height_px, frame.width_px) < MIN_IMAGE_SIDE_PX:
            raise Refused(
                f"the image is {frame.width_px}x{frame.height_px} px, too small to see anything"
                f" in: send at least {MIN_IMAGE_SIDE_PX}x{MIN_IMAGE_SIDE_PX} px",
                episode=frame.episode,
                frame=frame.frame,
            )
        self._stages.start()
        rgb = decode(frame)
        self._stages.lap("decode")
        try:
            found = self._backend.detect(rgb)
        except Refused as error:
            raise Refused(error.reason, episode=frame.episode, frame=frame.frame) from error
        self._stages.lap("detect")
        kept = []
        for item in found:
            box_px = clip_box(item.box_px, frame.height_px, frame.width_px)
            if big_enough(box_px, self._settings.min_side_px, self._settings.min_area_px):
                kept.append((item, box_px))
        named = [pair for pair in kept if pair[0].name]
        graphs = self._graphs(rgb, named, depth)
        self._stages.lap("describe")
        boxes = [
            self._captioned(item, box_px, graph)
            for (item, box_px), graph in zip(named, graphs, strict=True)
        ]
        message = self._message(frame, boxes, len(found))
        message.unnamed = [
            UnnamedRegion(box_px=box_px, score=item.score) for item, box_px in kept if not item.name
        ]
        message.calibrated = any(item.calibrated for item in found)
        message.shares = _shares([item for item, _ in named])
        message.timing_us = self._stages.taken_us()
        if message.unnamed:
            self.counters["unnamed"] = self.counters.get("unnamed", 0) + len(message.unnamed)
        return message

    def _graphs(
        self,
        rgb: RgbImage,
        named: list[tuple[Detection, list[float]]],
        depth: DepthFrame | None,
    ) -> list[ObjectGraph]:
        """Return the graph of each detection, with relations where the settings ask for them."""
        nodes = [
            ObjectGraph(name=item.name, attributes=self._attributes(rgb, item, box_px))
            for item, box_px in named
        ]
        names, boxes = [node.name for node in nodes], [box_px for _, box_px in named]
        relations: Found = [[] for _ in nodes]
        if self._settings.relations == "boxes" or (
            self._settings.relations == "depth" and depth is None
        ):
            relations = from_boxes(names, boxes)
        elif depth is not None:
            relations = from_depth(names, boxes, depth)
        return [
            ObjectGraph(
                name=node.name,
                attributes=node.attributes,
                relations=[Relation(type=kind, target=nodes[k]) for kind, k in found],
            )
            for node, found in zip(nodes, relations, strict=True)
        ]

    def _attributes(self, rgb: RgbImage, item: Detection, box_px: list[float]) -> dict[str, str]:
        """Return the colour and material that the detector, or the pixels, are sure enough of."""
        least = self._settings.attribute_threshold
        found: dict[str, str] = {}
        if item.colors is None:
            colour = colour_of_box(rgb, box_px) if self._settings.colour else None
            if colour is not None:
                found["color"] = colour
        elif item.colors and item.colors[0][1] >= least:
            found["color"] = item.colors[0][0]
        if item.materials and item.materials[0][1] >= least:
            found["material"] = item.materials[0][0]
        return found

    def _captioned(self, item: Detection, box_px: list[float], graph: ObjectGraph) -> CaptionedBox:
        classes = [ClassProbability(name=name, probability=share) for name, share in item.classes]
        if self._settings.emit == "graphs":
            return CaptionedBox(box_px=box_px, score=item.score, graph=graph, classes=classes)
        text = caption(graph, self._settings.relation_joiner)
        return CaptionedBox(box_px=box_px, score=item.score, caption=text, classes=classes)

    def _message(
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


def _key(frame: ColorFrame | DepthFrame) -> Key:
    return (frame.episode, frame.camera, frame.frame)


def _shares(items: list[Detection]) -> list[AttributeShares]:
    """Return the attribute distributions of all detections; none where no backend knows any."""
    if not any(item.colors or item.materials for item in items):
        return []

    def listed(shares: tuple[tuple[str, float], ...]) -> list[ClassProbability]:
        return [ClassProbability(name=name, probability=share) for name, share in shares]

    return [
        AttributeShares(colors=listed(item.colors or ()), materials=listed(item.materials))
        for item in items
    ]
