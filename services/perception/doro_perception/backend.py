"""The one interface of a detector that looks at images; one file per backend."""

from __future__ import annotations

from typing import Any, Protocol

import msgspec
import numpy as np
from numpy.typing import NDArray

RgbImage = NDArray[np.uint8]
"""uint8 (height, width, 3), RGB, row 0 on top."""

Box = tuple[float, float, float, float]
"""``(xmin, ymin, xmax, ymax)``, edges, pixels."""


Shares = tuple[tuple[str, float], ...]
"""(word, probability) of the likeliest words, best first; they sum to at most 1."""


class Detection(msgspec.Struct, frozen=True):
    """One thing that a backend sees.

    Attributes:
        box_px: edges in pixels; may stand out of the image, the core clips it.
        score: 0..1.
        name: canonical class name ("dining table"); empty: something that cannot be named.
        classes: of the likeliest classes.
        colors, materials: of the attributes, where the backend knows them; with ``colors`` None
            the core names the colour of the pixels.
        calibrated: the score is a probability, fitted on frames with truth.
    """

    box_px: Box
    score: float
    name: str
    classes: Shares = ()
    colors: Shares | None = None
    materials: Shares = ()
    calibrated: bool = False


class DetectionBackend(Protocol):
    """Finds things in one image. No state between calls: equal pixels, equal detections."""

    def detect(self, rgb: RgbImage) -> list[Detection]:
        """Return the detections of ``rgb``, best score first.

        Args:
            rgb: uint8 (height, width, 3).
        """
        ...

    def warm_up(self) -> None:
        """Look at a gray image, so that the first frame is not the slowest."""
        ...


def clip_box(box_px: Box | list[float], height_px: int, width_px: int) -> list[float]:
    """Return the part of a box inside the image, ``[xmin, ymin, xmax, ymax]``; may be empty."""
    xmin, ymin, xmax, ymax = box_px
    return [
        min(max(float(xmin), 0.0), float(width_px)),
        min(max(float(ymin), 0.0), float(height_px)),
        min(max(float(xmax), 0.0), float(width_px)),
        min(max(float(ymax), 0.0), float(height_px)),
    ]


def big_enough(box_px: list[float], min_side_px: float, min_area_px: float) -> bool:
    """Tell whether a box has an area and is at least this large; false for NaN."""
    width, height = box_px[2] - box_px[0], box_px[3] - box_px[1]
    side = min(width, height)
    return side > 0 and side >= min_side_px and width * height >= min_area_px


def without_doubles(found: list[Detection], iou: float) -> list[Detection]:
    """Return the detections without those that a better one of the same name overlaps.

    Args:
        found: best first.
        iou: the most that two things of one name may overlap.
    """
    kept: list[Detection] = []
    for item in found:
        box = np.asarray(item.box_px)
        rivals = np.array([one.box_px for one in kept if one.name == item.name])
        if not len(rivals) or intersection_over_union(box, rivals).max() <= iou:
            kept.append(item)
    return kept


def suppressed(boxes: NDArray[Any], scores: NDArray[Any], iou: float) -> list[int]:
    """Return the indices of the best boxes that overlap no better one by more than ``iou``."""
    kept: list[int] = []
    for index in np.argsort(-scores, kind="stable"):
        if not kept or intersection_over_union(boxes[index], boxes[kept]).max() <= iou:
            kept.append(int(index))
    return kept


def intersection_over_union(box: NDArray[Any], boxes: NDArray[Any]) -> NDArray[np.float64]:
    """Return the IoU of ``box`` (4,) with each of ``boxes`` (n, 4); edges, any unit."""
    low = np.maximum(box[:2], boxes[:, :2])
    high = np.minimum(box[2:], boxes[:, 2:])
    common = np.clip(high - low, 0.0, None).prod(axis=1)
    area = float(np.prod(box[2:] - box[:2]))
    areas = (boxes[:, 2:] - boxes[:, :2]).prod(axis=1)
    union = area + areas - common
    result: NDArray[np.float64] = common / np.maximum(union, 1e-12)
    return result
