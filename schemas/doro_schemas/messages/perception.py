"""Detections on their way from the camera to the map."""

from __future__ import annotations

from typing import ClassVar

import msgspec

from doro_schemas.graph import ObjectGraph
from doro_schemas.messages.base import FrameMessage, check_box, check_probability


class SimRelation(msgspec.Struct, frozen=True):
    """A true relation of a simulated object: type, and the landmark's class and attributes."""

    type: str
    object_type: str
    attributes: dict[str, str] = {}


class SimDetection(msgspec.Struct, frozen=True):
    """One object as the simulator knows it.

    Attributes:
        object_id: the simulator's id ("Cup|+01.2|+00.9|-00.3").
        object_type: the simulator's class ("CoffeeTable").
        box_px: ``[xmin, ymin, xmax, ymax]``, edges, so xmax - xmin is the width.
        attributes: true self attributes by type.
        relations: true relations.
    """

    object_id: str
    object_type: str
    box_px: list[float]
    attributes: dict[str, str] = {}
    relations: list[SimRelation] = []


class SimDetections(FrameMessage, kw_only=True):
    """All objects that the simulator sees in a frame."""

    detections: list[SimDetection] = []

    def __post_init__(self) -> None:
        super().__post_init__()
        for detection in self.detections:
            check_box(detection.box_px, self.height_px, self.width_px)


class ClassProbability(msgspec.Struct, frozen=True):
    """One entry of a detector's class distribution."""

    name: str
    probability: float


class CaptionedBox(msgspec.Struct, frozen=True):
    """A detection: box, score, and a caption or a graph.

    Attributes:
        box_px: ``[xmin, ymin, xmax, ymax]``, edges, inside the image.
        score: 0..1.
        caption: English, for example "a red plastic cup on the table"; empty if ``graph``.
        graph: the description as a graph, from a detector that has attributes.
        classes: class distribution, top-k, optional.
    """

    box_px: list[float]
    score: float
    caption: str = ""
    graph: ObjectGraph | None = None
    classes: list[ClassProbability] = []

    def __post_init__(self) -> None:
        check_probability(self.score, "a detection's score")
        if not self.caption.strip() and self.graph is None:
            raise ValueError("a detection needs a caption or a graph, and this one has neither")


class AttributeShares(msgspec.Struct, frozen=True):
    """Distributions of the attributes of one detection, top-k, best first.

    What the caption or the graph says of them is what the detector is sure enough of.
    """

    colors: list[ClassProbability] = []
    materials: list[ClassProbability] = []


class UnnamedRegion(msgspec.Struct, frozen=True):
    """Something is there, and the detector cannot name it.

    Attributes:
        box_px: ``[xmin, ymin, xmax, ymax]``, edges, inside the image.
        score: how sure the detector is that a thing is there, 0..1.
    """

    box_px: list[float]
    score: float

    def __post_init__(self) -> None:
        check_probability(self.score, "a region's score")


class FrameCaptions(FrameMessage, kw_only=True):
    """All detections of a frame. A frame without detections is sent with an empty list.

    Attributes:
        timing_us: time of each stage of the detector, microseconds, for the operator.
        unnamed: things without a name; they are no instances of anything and not counted, but
            "there is no cup" and "there is something that I cannot name" differ.
        shares: attribute distributions of the detections in their order, or empty.
        calibrated: scores are probabilities that box and name are right, fitted on frames with
            truth; the mapper then counts a view by its score, others by their word.
    """

    ADDED: ClassVar[dict[str, object]] = {"unnamed": [], "shares": [], "calibrated": False}

    detections: list[CaptionedBox] = []
    timing_us: dict[str, float] = {}
    unnamed: list[UnnamedRegion] = []
    shares: list[AttributeShares] = []
    calibrated: bool = False

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.shares and len(self.shares) != len(self.detections):
            raise ValueError(
                f"shares are of {len(self.shares)} detections, and there are {len(self.detections)}"
            )
        boxes = [item.box_px for item in self.detections] + [item.box_px for item in self.unnamed]
        for box_px in boxes:
            check_box(box_px, self.height_px, self.width_px)


class GraphBox(msgspec.Struct, frozen=True):
    """A detection as the mapper takes it: box, score, graph, and the caption it came from."""

    box_px: list[float]
    score: float
    graph: ObjectGraph
    caption: str = ""
    classes: list[ClassProbability] = []

    def __post_init__(self) -> None:
        check_probability(self.score, "a detection's score")


class FrameGraphs(FrameMessage, kw_only=True):
    """All detections of a frame as graphs.

    Attributes:
        not_understood: captions that gave no graph.
        unnamed, calibrated: of :class:`FrameCaptions`, handed on.
    """

    ADDED: ClassVar[dict[str, object]] = {"unnamed": [], "calibrated": False}

    detections: list[GraphBox] = []
    not_understood: list[str] = []
    unnamed: list[UnnamedRegion] = []
    calibrated: bool = False

    def __post_init__(self) -> None:
        super().__post_init__()
        boxes = [item.box_px for item in self.detections] + [item.box_px for item in self.unnamed]
        for box_px in boxes:
            check_box(box_px, self.height_px, self.width_px)
