"""The TOML file that describes a user's own detector; see the README for an example."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import msgspec

from doro_schemas.errors import Refused
from doro_schemas.vocabulary import canonical_name

Layout = Literal["ssd", "yolo", "detr"]


class InputDescription(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The image as the model takes it.

    Attributes:
        width_px, height_px: size of the input.
        order: ``nchw`` (torch) or ``nhwc`` (tensorflow).
        channels: ``rgb`` or ``bgr``.
        type: ``float32``: (pixel - mean) / std per channel, in ``channels``' order; ``uint8``:
            the pixels as they are, mean and std do not apply.
        fit: ``stretch`` the image, or ``letterbox``: keep its shape, gray around it.
    """

    width_px: int
    height_px: int
    order: Literal["nchw", "nhwc"] = "nchw"
    channels: Literal["rgb", "bgr"] = "rgb"
    type: Literal["float32", "uint8"] = "float32"
    mean: tuple[float, float, float] = (0.0, 0.0, 0.0)
    std: tuple[float, float, float] = (255.0, 255.0, 255.0)
    fit: Literal["stretch", "letterbox"] = "letterbox"

    def __post_init__(self) -> None:
        if not (8 <= self.width_px <= 4096 and 8 <= self.height_px <= 4096):
            raise ValueError("input.width_px and input.height_px must be in 8..4096")
        if min(self.std) <= 0:
            raise ValueError("input.std must be positive")


class OutputDescription(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What the model gives. Empty strings: the default of the layout.

    Attributes:
        boxes, scores: names of the outputs. ``yolo`` has one output, named in ``boxes``.
        labels: ssd only: the model has chosen the class of each box already; (n,) numbers.
        box_format: ``xyxy``, ``yxyx`` (tensorflow) or ``cxcywh``.
        box_units: ``share`` of the input, or its ``pixels``.
        activation: what makes the scores probabilities.
        background: where the scores have a column for nothing.
        objectness: yolo only: the fifth row or column is one (YOLOv5, not v8).
    """

    boxes: str = ""
    scores: str = ""
    labels: str = ""
    box_format: Literal["", "xyxy", "yxyx", "cxcywh"] = ""
    box_units: Literal["", "share", "pixels"] = ""
    activation: Literal["", "none", "sigmoid", "softmax"] = ""
    background: Literal["", "none", "first", "last"] = ""
    objectness: bool = False


class Description(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A detector. ``model`` lies beside the description; ``classes`` in the model's order.

    A class named "" or "-" is not reported.
    """

    model: str
    layout: Layout
    classes: tuple[str, ...]
    input: InputDescription
    output: OutputDescription = OutputDescription()
    score_threshold: float = 0.4
    nms_iou: float = 0.55
    max_boxes: int = 100

    def __post_init__(self) -> None:
        if not self.classes:
            raise ValueError("classes must name at least one class")
        if not (0 <= self.score_threshold <= 1 and 0 <= self.nms_iou <= 1):
            raise ValueError("score_threshold and nms_iou must be in 0..1")
        if self.output.labels and self.layout != "ssd":
            raise ValueError("output.labels is for the layout ssd only")

    def names(self) -> tuple[str, ...]:
        """Return canonical names, empty where a class is not reported."""
        return tuple(
            "" if word.strip() in ("", "-") else canonical_name(word) for word in self.classes
        )


DEFAULTS: dict[Layout, OutputDescription] = {
    "ssd": OutputDescription(
        boxes="boxes",
        scores="scores",
        box_format="yxyx",
        box_units="share",
        activation="none",
        background="none",
    ),
    "yolo": OutputDescription(
        boxes="output0",
        box_format="cxcywh",
        box_units="pixels",
        activation="none",
        background="none",
    ),
    "detr": OutputDescription(
        boxes="pred_boxes",
        scores="pred_logits",
        box_format="cxcywh",
        box_units="share",
        activation="softmax",
        background="last",
    ),
}


def read_description(path: Path) -> Description:
    """Return the description with the layout's defaults filled in.

    Raises:
        Refused: the file is missing or says something that does not fit.
    """
    advice = "see 'Your own detector' in the README of doro-perception"
    try:
        found = msgspec.toml.decode(path.read_bytes(), type=Description)
    except OSError as error:
        raise Refused(
            f"detector description {path} cannot be read ({error.strerror}): name a TOML file in"
            " perception.detector"
        ) from error
    except (msgspec.MsgspecError, ValueError) as error:
        raise Refused(f"detector description {path} does not fit ({error}): {advice}") from error
    default = DEFAULTS[found.layout]
    filled = {
        name: getattr(found.output, name) or getattr(default, name)
        for name in OutputDescription.__struct_fields__
    }
    return msgspec.structs.replace(found, output=OutputDescription(**filled))
