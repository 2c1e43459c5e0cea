"""Distances between 3-D boxes, and overlaps of image boxes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from doro_mapper.views import Floats

REACH = 1.3
MARGIN_M = 0.10
MARGIN_PER_M = 0.015
CONTAINED = 0.5
CONTAINED_SLACK_M = 0.03


@dataclass(frozen=True, slots=True)
class Boxes:
    """n boxes in map axes: centre, low and high corners, each (n, 3) metres."""

    center_m: Floats
    low_m: Floats
    high_m: Floats


def distance(a: Boxes, b: Boxes, range_m: Floats) -> Floats:
    """Return the normalised distance (n, m) of boxes ``a`` measured at ``range_m`` (n,) to ``b``.

    The smaller of two: centre distance ``sqrt((dh/(1.3 r_h + m))^2 + (dv/(1.3 r_v + m))^2)``
    with the larger half extents and m = 0.10 + 0.015 range, and ``0.5 + 1 - share`` where
    share of ``a`` lies inside ``b``, if any. Below 1 is near.
    """
    wide = Boxes(a.center_m[:, None], a.low_m[:, None], a.high_m[:, None])
    return pair_distance(wide, b, range_m[:, None])


def pair_distance(a: Boxes, b: Boxes, range_m: Floats) -> Floats:
    """Return the distance of :func:`distance` of box to box.

    Args:
        a, b: (..., 3), of shapes that go together.
        range_m: (...) of ``a``.
    """
    size_a, size_b = a.high_m - a.low_m, b.high_m - b.low_m
    offset = np.abs(a.center_m - b.center_m)
    horizontal = np.hypot(offset[..., 0], offset[..., 1])
    wide_a = np.maximum(size_a[..., 0], size_a[..., 1])
    wide_b = np.maximum(size_b[..., 0], size_b[..., 1])
    half_h = 0.5 * np.maximum(wide_a, wide_b)
    half_v = 0.5 * np.maximum(size_a[..., 2], size_b[..., 2])
    margin = MARGIN_M + MARGIN_PER_M * range_m
    centered = np.hypot(
        horizontal / (REACH * half_h + margin), offset[..., 2] / (REACH * half_v + margin)
    )
    slack = np.minimum(margin, CONTAINED_SLACK_M)[..., None]
    low_a, high_a = a.low_m - 0.01, a.high_m + 0.01
    overlap = np.minimum(high_a, b.high_m + slack) - np.maximum(low_a, b.low_m - slack)
    inside = np.maximum(overlap, 0) / (high_a - low_a)
    share = inside[..., 0] * inside[..., 1] * inside[..., 2]
    out: Floats = np.minimum(centered, np.where(share > 0, CONTAINED + 1 - share, np.inf))
    return out


def covered(boxes: Floats, others: Floats) -> tuple[Floats, Floats]:
    """Return, row by row, intersection over the smaller image box, and the ratio of areas.

    Args:
        boxes, others: (n, 4) pixels, or broadcastable to it.
    """
    wide = np.minimum(boxes[..., 2], others[..., 2]) - np.maximum(boxes[..., 0], others[..., 0])
    tall = np.minimum(boxes[..., 3], others[..., 3]) - np.maximum(boxes[..., 1], others[..., 1])
    area = (boxes[..., 2] - boxes[..., 0]) * (boxes[..., 3] - boxes[..., 1])
    other = (others[..., 2] - others[..., 0]) * (others[..., 3] - others[..., 1])
    inter = np.clip(wide, 0, None) * np.clip(tall, 0, None)
    return inter / np.maximum(1.0, np.minimum(area, other)), area / np.maximum(1.0, other)


def ious(boxes_px: Floats) -> Floats:
    """Return intersection over union of all pairs of image boxes, (n, n)."""
    low = np.maximum(boxes_px[:, None, :2], boxes_px[None, :, :2])
    high = np.minimum(boxes_px[:, None, 2:], boxes_px[None, :, 2:])
    inter = np.clip(high - low, 0, None).prod(axis=2)
    area = (boxes_px[:, 2:] - boxes_px[:, :2]).prod(axis=1)
    out: Floats = inter / np.maximum(area[:, None] + area[None] - inter, 1e-9)
    return out
