"""Things as far as merging has come: one track or several, and how two of them lie."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from doro_mapper.boxes import Boxes, distance
from doro_mapper.existence import FURNITURE_M
from doro_mapper.finder import Look, attributes_agree, graph_factor, names_agree
from doro_mapper.tracks.table import TrackTable
from doro_mapper.views import Bools, Floats
from doro_mapper.votes import Votes

MERGE_RANGE_M = 1.5
"""Range assumed for the margin between two tracks."""
PRUNE_REACH_M = 0.5
ABOVE_GAP_M = 0.15
TALLEST_M = 1.4
CORNER_GAP_M, CORNER_GAP_SHARE = 0.3, 0.35
PAD_M = 0.01
ONE_PLACE_IOU = 0.4
Shape = tuple[Floats, Floats, Floats, Floats, Floats, Floats]


@dataclass(eq=False, slots=True)
class Item:
    """One thing as far as merging has come.

    Attributes:
        rows: tracks in it; those before ``shaping`` give its geometry.
        seen, expected: (slots,) views that saw it, and that should have.
        center_m, low_m, high_m, outer_low_m, outer_high_m, spread_m2: geometry.
    """

    rows: list[int]
    shaping: int
    look: Look
    seen: Bools
    expected: Bools
    hits: int
    center_m: Floats
    low_m: Floats
    high_m: Floats
    outer_low_m: Floats
    outer_high_m: Floats
    spread_m2: Floats

    @property
    def longest_m(self) -> float:
        """Its longest side."""
        return float((self.outer_high_m - self.outer_low_m).max())

    @property
    def shape(self) -> Shape:
        """Its geometry, in the order of the fields."""
        return (
            self.center_m,
            self.low_m,
            self.high_m,
            self.outer_low_m,
            self.outer_high_m,
            self.spread_m2,
        )


@dataclass(eq=False, slots=True)
class Group:
    """The tracks of one thing, the one with most views first; or none: explained away.

    Attributes:
        item: rows and geometry as of when it was last looked at.
        read: slots of other tracks' views that are read as views of this one.
        absorbed: rows of tracks that were explained away by it.
    """

    item: Item
    read: Bools | None
    absorbed: list[int]

    @property
    def main(self) -> int:
        return self.item.rows[0]


def counted(group: Group, table: TrackTable) -> tuple[int, int]:
    """Return (hits, misses) of a group as of now."""
    rows = group.item.rows
    if len(rows) == 1 and group.read is None:
        return int(table.hits[rows[0]]), int(table.misses[rows[0]])
    seen = np.asarray(table.seen[rows].any(axis=0))
    older = int((table.hits[rows] - table.seen[rows].sum(axis=1)).sum())
    if group.read is not None:
        seen[: len(group.read)] |= group.read
    expected = table.expected[rows[: group.item.shaping]].any(axis=0)
    misses = int((expected & ~seen).sum()) + int(table.old_misses[rows[0]])
    return int(seen.sum()) + older, misses


def item_of(row: int, table: TrackTable, votes: Votes) -> Item:
    """Return a track as an item."""
    return Item(
        rows=[row],
        shaping=1,
        look=votes.look(),
        seen=table.seen[row],
        expected=table.expected[row],
        hits=int(table.hits[row]),
        center_m=table.center_m[row],
        low_m=table.low_m[row],
        high_m=table.high_m[row],
        outer_low_m=table.outer_low_m[row],
        outer_high_m=table.outer_high_m[row],
        spread_m2=table.spread_m2[row],
    )


def strength(item: Item) -> float:
    missed = int(np.count_nonzero(item.expected & ~item.seen))
    return item.hits / (item.hits + missed + 2.0)


def gaps_between(items: list[Item], others: list[Item]) -> tuple[Floats, Bools]:
    """Return the symmetric distances and whether one may be part of the other, each (n, m).

    A distance is NEVER for what cannot be one thing. A part lies within reach of the whole, and
    looks alike.
    """
    a, b = _boxes(items), _boxes(others)
    there = distance(a, b, np.full(len(items), MERGE_RANGE_M))
    same = others is items
    back = there.T if same else distance(b, a, np.full(len(others), MERGE_RANGE_M)).T
    factors = _factors(items, others)
    apart = np.linalg.norm(a.center_m[:, None] - b.center_m[None], axis=2)
    reach = np.maximum(_reach_m(a)[:, None], _reach_m(b)[None])
    return np.asarray(np.minimum(there, back) * factors), (factors == 1.0) & (apart <= reach)


def _reach_m(boxes: Boxes) -> Floats:
    return np.asarray(PRUNE_REACH_M + 2 * np.linalg.norm(boxes.high_m - boxes.low_m, axis=1))


def _factors(items: list[Item], others: list[Item]) -> Floats:
    """Return the factors of :func:`graph_factor`; few different looks, so each pair once."""
    looks: list[Look] = []
    numbers = []
    for item in (*items, *others):
        if item.look not in looks:
            looks.append(item.look)
        numbers.append(looks.index(item.look))
    table = np.array([[graph_factor(one, other) for other in looks] for one in looks])
    n = len(items)
    return np.asarray(table[np.array(numbers[:n])[:, None], np.array(numbers[n:])])


def _boxes(items: list[Item]) -> Boxes:
    return Boxes(
        np.array([item.center_m for item in items]),
        np.array([item.low_m for item in items]),
        np.array([item.high_m for item in items]),
    )


def one_above(a: Item, b: Item) -> bool:
    """Tell whether two parts of furniture lie above each other: seat and back of one chair.

    From across a table only the back shows, so that the two are never seen together; two
    chairs cannot stand so close.
    """
    size = np.maximum(a.high_m - a.low_m, b.high_m - b.low_m)
    if float(size.max()) < FURNITURE_M:
        return False
    low, high = np.minimum(a.low_m, b.low_m), np.maximum(a.high_m, b.high_m)
    footprint = 0.5 * float(size[:2].max())
    apart = float(np.hypot(*(a.center_m - b.center_m)[:2]))
    gap_up = max(a.low_m[2] - b.high_m[2], b.low_m[2] - a.high_m[2])
    return apart <= footprint and gap_up <= ABOVE_GAP_M and float((high - low)[2]) <= TALLEST_M


def one_place(items: list[Item]) -> Bools:
    """Tell which pairs fill the same place, (n, n): two solid things cannot.

    Volumes are compared with 1 cm around them, so that thin things have one.
    """
    low = np.array([item.low_m for item in items]) - PAD_M
    high = np.array([item.high_m for item in items]) + PAD_M
    overlap = np.minimum(high[:, None], high[None]) - np.maximum(low[:, None], low[None])
    both = np.clip(overlap, 0, None).prod(axis=2)
    volume = (high - low).prod(axis=1)
    share = both / (volume[:, None] + volume[None] - both)
    return np.asarray(share >= ONE_PLACE_IOU)


def agree(a: Item, b: Item) -> bool:
    """Tell whether two items' graphs may be of one thing."""
    return names_agree(a.look[0], b.look[0]) and attributes_agree(a.look[1], b.look[1])


def in_reach(other: Item, item: Item) -> bool:
    """Tell whether an item may be a view of another, by distance."""
    reach = PRUNE_REACH_M + 2 * math.dist(other.high_m.tolist(), other.low_m.tolist())
    return math.dist(other.center_m.tolist(), item.center_m.tolist()) <= reach


def reach_matrix(items: list[Item]) -> Bools:
    """Return by pair whether the second may be a view of the first, by distance, (n, n)."""
    boxes = _boxes(items)
    apart = np.linalg.norm(boxes.center_m[:, None] - boxes.center_m[None], axis=2)
    return np.asarray(apart <= _reach_m(boxes)[:, None])
