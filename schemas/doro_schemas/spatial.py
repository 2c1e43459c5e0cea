"""The one geometric rule of is-on, is-near and is-at between axis-aligned boxes.

Ground truth (sim-feeder) and map (mapper) derive relations from it, so that they mean
the same. Boxes are given as centre and size in (ground, ground, up) order, metres.

- ``is-at`` (in): the centre of A lies inside B's box, and A's top does not stand out of
  B by more than half of A's height.
- ``is-on``: A's bottom is within ``ON_GAP_M`` of B's top, or lies inside B above its
  middle (a mug on a table whose box reaches up to its back rest), and at least
  ``ON_OVERLAP`` of A's footprint lies over B.
- ``is-near``: neither, and the horizontal gap between the footprints is at most
  ``NEAR_M`` and the vertical gap at most ``NEAR_UP_M``.
"""

from __future__ import annotations

from typing import Literal

import msgspec

ON_GAP_M = 0.06
ON_OVERLAP = 0.5
NEAR_M = 0.5
NEAR_UP_M = 0.5


class Box3(msgspec.Struct, frozen=True):
    """An axis-aligned box; ``center_m`` and ``size_m`` are (ground, ground, up)."""

    center_m: tuple[float, float, float]
    size_m: tuple[float, float, float]

    def low(self, axis: int) -> float:
        return self.center_m[axis] - self.size_m[axis] / 2

    def high(self, axis: int) -> float:
        return self.center_m[axis] + self.size_m[axis] / 2


def gap_m(a: Box3, b: Box3, axis: int) -> float:
    """Return the distance between two boxes along one axis; 0 where they overlap."""
    return max(0.0, a.low(axis) - b.high(axis), b.low(axis) - a.high(axis))


def footprint_share(a: Box3, b: Box3) -> float:
    """Return the share of A's footprint that lies over B's, 0..1."""
    share = 1.0
    for axis in (0, 1):
        overlap = min(a.high(axis), b.high(axis)) - max(a.low(axis), b.low(axis))
        share *= max(0.0, overlap) / max(a.size_m[axis], 1e-6)
    return min(1.0, share)


def relation_between(a: Box3, b: Box3) -> Literal["is-on", "is-near", "is-at"] | None:
    """Return how A stands to B, or None where nothing holds."""
    inside = all(b.low(axis) <= a.center_m[axis] <= b.high(axis) for axis in (0, 1, 2))
    bottom, top = a.low(2), b.high(2)
    supported = abs(bottom - top) <= ON_GAP_M or b.center_m[2] <= bottom <= top
    over = footprint_share(a, b) >= ON_OVERLAP
    if over and supported:
        return "is-on"
    if inside and a.high(2) <= top + a.size_m[2] / 2:
        return "is-at"
    ground_gap = (gap_m(a, b, 0) ** 2 + gap_m(a, b, 1) ** 2) ** 0.5
    if ground_gap <= NEAR_M and gap_m(a, b, 2) <= NEAR_UP_M:
        return "is-near"
    return None
