"""Puts labels where they hide least: near their thing, off other labels and marks."""

from __future__ import annotations

import math
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

Box = tuple[int, int, int, int]
"""(left, top, right, bottom) pixels."""

_STEPS = 24
_RINGS_PX = (26, 44, 66, 92, 124, 160, 200, 250)
_GAP_PX = 5
_COST_PER_PX = 0.012
"""Cost of distance, beside the mean weight of what a label hides."""
_LEADER_SAMPLES = 48
_SOLID = 10.0
_COST_PER_CROSSED_PX = 0.5


class Label(msgspec.Struct, frozen=True):
    """A text block that belongs to a rectangle of the picture."""

    width_px: int
    height_px: int
    anchor: Box


def place(
    labels: list[Label], obstacles: NDArray[np.uint8], area: Box
) -> list[tuple[Box, tuple[int, int]]]:
    """Return for each label its box and where its leader line meets its thing.

    Greedy: labels are placed in the given order, each on the cheapest of a fixed set of places
    around the anchor; what is placed, leader included, is an obstacle to the next.

    Args:
        obstacles: uint8 (height, width); values weigh how bad it is to hide a pixel.
            It is not changed.
        area: labels stay inside.
    """
    taken = obstacles.astype(np.float64)
    places = []
    for label in labels:
        box = _cheapest(label, taken, area)
        foot = _foot(label.anchor, box)
        left, top, right, bottom = box
        gap = _GAP_PX
        taken[max(0, top - gap) : bottom + gap, max(0, left - gap) : right + gap] += 20.0
        _block_leader(taken, box, foot)
        places.append((box, foot))
    return places


def _cheapest(label: Label, taken: NDArray[Any], area: Box) -> Box:
    sums = np.zeros((taken.shape[0] + 1, taken.shape[1] + 1))
    np.cumsum(np.cumsum(taken, axis=0), axis=1, out=sums[1:, 1:])
    best: tuple[float, Box] | None = None
    for box in _candidates(label, area):
        left, top, right, bottom = box
        hidden = sums[bottom, right] - sums[top, right] - sums[bottom, left] + sums[top, left]
        away_px = math.dist(*_nearest(label.anchor, box))
        cost = hidden / (label.width_px * label.height_px) + away_px * _COST_PER_PX
        if best is not None and cost >= best[0]:
            continue
        cost += _leader_cost(taken, label.anchor, box)
        if best is None or cost < best[0]:
            best = (cost, box)
    if best is None:
        raise ValueError(f"a label of {label.width_px} px does not fit into {area}")
    return best[1]


def _leader_cost(taken: NDArray[Any], anchor: Box, box: Box) -> float:
    """Return how much the leader line crosses of labels, lines and marks not its own.

    Crossing what is only coloured (a table, the path) costs nothing: a thin line hides little.
    """
    (x0, y0), (x1, y1) = leader(_foot(anchor, box), box)
    share = np.linspace(0.0, 1.0, _LEADER_SAMPLES)
    x = (x0 + (x1 - x0) * share).astype(int).clip(0, taken.shape[1] - 1)
    y = (y0 + (y1 - y0) * share).astype(int).clip(0, taken.shape[0] - 1)
    outside = (x < anchor[0] - 4) | (x > anchor[2] + 4) | (y < anchor[1] - 4) | (y > anchor[3] + 4)
    crossed = outside & (taken[y, x] >= _SOLID)
    length_px = math.hypot(x1 - x0, y1 - y0)
    return float(crossed.sum()) / _LEADER_SAMPLES * length_px * _COST_PER_CROSSED_PX


def _candidates(label: Label, area: Box) -> list[Box]:
    """Return boxes whose near side lies on rings around the anchor, shifted into the area."""
    left, top, right, bottom = label.anchor
    x, y = (left + right) / 2, (top + bottom) / 2
    found: list[Box] = []
    for ring in _RINGS_PX:
        for step in range(_STEPS):
            angle = 2 * math.pi * step / _STEPS
            across, down = math.cos(angle), math.sin(angle)
            middle_x = x + across * ((right - left) / 2 + ring + label.width_px / 2)
            middle_y = y + down * ((bottom - top) / 2 + ring + label.height_px / 2)
            box_left = round(middle_x - label.width_px / 2)
            box_top = round(middle_y - label.height_px / 2)
            box_left = max(area[0], min(box_left, area[2] - label.width_px))
            box_top = max(area[1], min(box_top, area[3] - label.height_px))
            if box_left >= area[0] and box_top >= area[1]:
                end = (box_left + label.width_px, box_top + label.height_px)
                found.append((box_left, box_top, *end))
    return found


def _nearest(a: Box, b: Box) -> tuple[tuple[int, int], tuple[int, int]]:
    """Return the point of each box that is nearest to the other's centre."""
    center_a = ((a[0] + a[2]) // 2, (a[1] + a[3]) // 2)
    return _clamp(center_a, b), _clamp(_clamp(center_a, b), a)


def _clamp(point: tuple[int, int], box: Box) -> tuple[int, int]:
    x, y = point
    return max(box[0], min(x, box[2])), max(box[1], min(y, box[3]))


def _foot(anchor: Box, box: Box) -> tuple[int, int]:
    return _nearest(anchor, box)[1]


def leader(anchor_foot: tuple[int, int], box: Box) -> tuple[tuple[int, int], tuple[int, int]]:
    """Return the leader line from a thing to the nearest point of its label."""
    return anchor_foot, _clamp(anchor_foot, box)


def _block_leader(taken: NDArray[Any], box: Box, foot: tuple[int, int]) -> None:
    (x0, y0), (x1, y1) = leader(foot, box)
    count = max(abs(x1 - x0), abs(y1 - y0), 1)
    for step in range(count + 1):
        x = x0 + (x1 - x0) * step // count
        y = y0 + (y1 - y0) * step // count
        taken[max(0, y - 2) : y + 3, max(0, x - 2) : x + 3] = 15.0
