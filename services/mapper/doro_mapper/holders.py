"""How things stand to each other, by the boxes that were measured of them.

What the field calls support relations: on, in, near. The rule is that of
:mod:`doro_schemas.spatial`; what is added here allows for boxes of what was seen, which end too
early, reach too high, or take in what stands under or in a thing.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray

from doro_mapper.views import Bools, Floats
from doro_schemas.spatial import NEAR_M, NEAR_UP_M, ON_GAP_M, ON_OVERLAP

NONE, ON, AT, NEAR = range(4)
STACKED_SHARE = 0.5
FITS_SHARE = 0.7
SUNK_M = 0.02
EDGE_M = 0.15
LOW_M = 0.35
"""Things of at most this height (books, plates, boxes, boards) carry others in piles."""
LANDMARK_SIDES_M = (0.15, 0.3)
CONTAINERS = frozenset(
    ("basket", "bowl", "box", "bucket", "crate", "cup", "mug", "pan", "pot", "vase")
)
"""Low things that one looks into: what they hide in part lies in them. A plate hides nothing."""
SEATS = frozenset(("arm chair", "chair", "sofa", "stool"))
"""Their boxes reach up to the back: nothing lies past the edge of it."""


def relation_matrix(low_m: Floats, high_m: Floats) -> NDArray[np.int64]:
    """Return by pair how A stands to B: NONE, ON, AT or NEAR, (n, n).

    The rule of :func:`doro_schemas.spatial.relation_between` for all pairs at once.

    Args:
        low_m, high_m: (n, 3) corners in (ground, ground, up) order.
    """
    center, size = (low_m + high_m) / 2, high_m - low_m
    a, b = np.s_[:, None], np.s_[None]
    inside = ((low_m[b] <= center[a]) & (center[a] <= high_m[b])).all(axis=2)
    bottom, top = low_m[a][..., 2], high_m[b][..., 2]
    supported = np.abs(bottom - top) <= ON_GAP_M
    supported |= (center[b][..., 2] <= bottom) & (bottom <= top)
    overlap = np.minimum(high_m[a], high_m[b]) - np.maximum(low_m[a], low_m[b])
    ground = np.clip(overlap[..., :2], 0, None) / np.maximum(size[a][..., :2], 1e-6)
    over = ground.prod(axis=2) >= ON_OVERLAP
    held = inside & (high_m[a][..., 2] <= top + size[a][..., 2] / 2)
    gaps = np.clip(-overlap, 0, None)
    near = (np.hypot(gaps[..., 0], gaps[..., 1]) <= NEAR_M) & (gaps[..., 2] <= NEAR_UP_M)
    out = np.where(near, NEAR, NONE)
    out[held] = AT
    out[over & supported] = ON
    np.fill_diagonal(out, NONE)
    return out


def standing(
    low_m: Floats,
    high_m: Floats,
    level_m: Floats,
    names: list[str],
    no_landmarks: Collection[str] = (),
) -> NDArray[np.int64]:
    """Return how A stands to B: NONE, ON, AT or NEAR, (n, n).

    Args:
        low_m, high_m: (n, 3) corners in (ground, ground, up) order.
        level_m: (n,) heights of the centres over all views.
        names: classes; to those of ``no_landmarks`` nothing stands in any way.
    """
    kinds = _by_boxes(low_m, high_m, _rests(low_m, high_m, level_m), names)
    kinds[:, [name in no_landmarks for name in names]] = NONE
    tucked = _tucked(kinds, high_m[:, 2] - low_m[:, 2])
    kinds[tucked] = np.where(_same(names)[tucked], NONE, NEAR)
    seats = np.array([name in SEATS for name in names])
    kinds[_edged(low_m, high_m, (kinds == NEAR) & ~seats[None], np.isin(kinds, (ON, AT)))] = ON
    return kinds


def _rests(low_m: Floats, high_m: Floats, level_m: Floats) -> Bools:
    """Tell whether A may lie on B, by what is seen of both, (n, n).

    The box of what lies below is measured too high (in the image its box shows what stands on
    it) and that of what lies above too low or cut off (a rim hides it), so tops and bottoms
    decide little. Centres over all views keep their order, be it by millimetres: A's is higher,
    A reaches down to B but not below it, and lies over it.

    Args:
        level_m: (n,) heights of the centres.
    """
    a, b = np.s_[:, None], np.s_[None]
    overlap = np.minimum(high_m[a], high_m[b]) - np.maximum(low_m[a], low_m[b])
    ground = np.clip(overlap[..., :2], 0, None) / np.maximum((high_m - low_m)[a][..., :2], 1e-6)
    bottom = low_m[:, 2]
    rests = (ground.prod(axis=2) >= ON_OVERLAP) & (overlap[..., 2] >= -ON_GAP_M)
    rests &= (level_m[a] > level_m[b]) & (bottom[a] >= bottom[b] - SUNK_M)
    return np.asarray(rests)


def _by_boxes(low_m: Floats, high_m: Floats, rests: Bools, names: list[str]) -> NDArray[np.int64]:
    """Return how things stand to landmarks.

    Only what is larger on the ground carries or holds a thing; of one class what is not much
    smaller carries it (a book on a book), and it neither holds it nor is it near it. A low
    thing carries what rests on it and nothing else; a container holds what is shorter by a good
    part and, hidden by its rim, seems lower than wide. What a thing carries or holds itself is
    not near it: nobody says that a table is near its cup.

    Args:
        rests: see :func:`_rests`.
    """
    kinds = relation_matrix(low_m, high_m)
    size = high_m - low_m
    area = size[:, 0] * size[:, 1]
    low = size[:, 2] <= LOW_M
    same = _same(names)
    kinds[(kinds == ON) & ~rests & (low[None] | same)] = NEAR
    piled = rests & low[None]
    kinds[piled] = ON
    hollow = np.array([name in CONTAINERS for name in names])
    sunk = hollow[None] & ~same
    sunk &= size[:, None, :2].max(axis=2) <= FITS_SHARE * size[None, :, :2].max(axis=2)
    sunk &= (size[:, 2] < size[:, :2].min(axis=1))[:, None]
    kinds[piled & sunk] = AT
    kinds[(kinds == AT) & (same | (low & ~hollow)[None])] = NONE
    kinds[same & (kinds == NEAR)] = NONE
    held = np.isin(kinds, (ON, AT))
    holds = area[None] > area[:, None]
    holds |= same & (area[None] > STACKED_SHARE * area[:, None])
    kinds[held & ~holds] = NONE
    kinds[(held & holds).T & ~(held & holds)] = NONE
    return kinds


def _same(names: list[str]) -> Bools:
    _, number = np.unique(names, return_inverse=True)
    return np.asarray(number[:, None] == number[None])


def _tucked(kinds: NDArray[np.int64], height_m: Floats) -> Bools:
    """Return which A only seem to be on or in B since B stands in what holds A, (n, n).

    A chair under a desk has its back where the things on the desk are. Low things in others are no
    such case: what lies in a bowl in the sink lies in the bowl.

    Args:
        height_m: (n,) heights of things.
    """
    held, at = np.isin(kinds, (ON, AT)), kinds == AT
    tucked = np.zeros_like(held)
    for number in np.flatnonzero(at.any(axis=1) & (height_m > LOW_M)).tolist():
        tucked[:, number] = held[:, number] & held[:, at[number]].any(axis=1)
    return np.asarray(tucked)


def _edged(low_m: Floats, high_m: Floats, beside: Bools, held: Bools) -> Bools:
    """Return which A lie on furniture B past the edge that was seen of it, (n, n).

    What nothing carries and what is not on the floor lies on something: on the nearest thing
    whose top is at its height and whose box, made from what was seen, ends close to it.

    Args:
        beside: which A are near a B that may carry them; held: which A are on or in which B.
    """
    size = high_m - low_m
    area = size[:, 0] * size[:, 1]
    loose = np.flatnonzero(~held.any(axis=1) & (low_m[:, 2] >= LOW_M))
    bottom, top = low_m[loose, None, 2], high_m[None, :, 2]
    apart = np.maximum(
        low_m[loose, None, :2] - high_m[None, :, :2], low_m[None, :, :2] - high_m[loose, None, :2]
    )
    gap_m = np.hypot(*np.moveaxis(np.clip(apart, 0, None), 2, 0))
    fits = beside[loose] & (gap_m <= EDGE_M) & _furniture(size) & (area > area[loose, None])
    fits &= ((low_m + high_m)[:, 2] / 2 <= bottom) & (bottom <= top + ON_GAP_M)
    gap_m[~fits] = np.inf
    edged = np.zeros_like(held)
    edged[loose] = fits & (gap_m == gap_m.min(axis=1, keepdims=True))
    return np.asarray(edged)


def _furniture(size_m: Floats) -> Bools:
    sides = np.sort(size_m, axis=1)
    large = (sides[:, 2] >= LANDMARK_SIDES_M[1]) & (sides[:, 1] >= LANDMARK_SIDES_M[0])
    return np.asarray(large)


def lesser_landmarks(size_m: Floats) -> tuple[Bools, Bools]:
    """Return which B are second best to point at A by, and which nobody would, (n, n).

    Best is what is larger and of furniture's size. Of the rest, furniture is pointed at by
    furniture alone, a smaller thing by what is at least half as large: no chair is near a cup.
    """
    furniture = _furniture(size_m)
    area = size_m[:, 0] * size_m[:, 1]
    best = (area[None] > area[:, None]) & furniture[None]
    small = furniture[:, None] | (area[None] < STACKED_SHARE * area[:, None])
    return np.asarray(~best), np.asarray(~furniture[None] & small)
