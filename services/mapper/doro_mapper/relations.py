"""Relations of instances: computed between their boxes, and voted from captions."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray

from doro_mapper.finder import Found, attributes_agree, names_agree
from doro_mapper.settings import MapperSettings
from doro_mapper.views import Bools, Floats
from doro_mapper.votes import ranked
from doro_schemas.graph import ObjectGraph, Relation, identity
from doro_schemas.spatial import NEAR_M, NEAR_UP_M, ON_GAP_M, ON_OVERLAP

ORDER = ("is-on", "is-at", "is-near")
HOLDS = ("is-on", "is-at")
NONE, ON, AT, NEAR = range(4)
STACKED_SHARE = 0.5
FITS_SHARE = 0.7
SUNK_M = 0.02
LOW_M = 0.35
"""Things of at most this height (books, plates, boxes, boards) carry others in piles."""
LANDMARK_SIDES_M = (0.15, 0.3)
CONTAINERS = frozenset(
    ("basket", "bowl", "box", "bucket", "crate", "cup", "mug", "pan", "pot", "vase")
)
"""Low things that one looks into: what they hide in part lies in them. A plate hides nothing."""
Option = tuple[bool, int, float, float, int]
"""Sorts landmarks: lesser, kind, gap, distance of centres (metres); and the landmark's index."""


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


def _kinds(low_m: Floats, high_m: Floats, rests: Bools, names: list[str]) -> NDArray[np.int64]:
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
    _, number = np.unique(names, return_inverse=True)
    same = number[:, None] == number[None]
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


def _lesser(size_m: Floats) -> tuple[Bools, Bools]:
    """Return which B are second best to point at A by, and which nobody would, (n, n).

    Best is what is larger and of furniture's size. Of the rest, furniture is pointed at by
    furniture alone, a smaller thing by what is at least half as large: no chair is near a cup.
    """
    sides = np.sort(size_m, axis=1)
    furniture = (sides[:, 2] >= LANDMARK_SIDES_M[1]) & (sides[:, 1] >= LANDMARK_SIDES_M[0])
    area = size_m[:, 0] * size_m[:, 1]
    best = (area[None] > area[:, None]) & furniture[None]
    small = furniture[:, None] | (area[None] < STACKED_SHARE * area[:, None])
    return np.asarray(~best), np.asarray(~furniture[None] & small)


def spatial_relations(
    instances: list[Found],
    graphs: list[ObjectGraph],
    max_near: int,
    no_landmarks: Collection[str] = (),
) -> list[list[Relation]]:
    """Return by instance what holds between it and the others.

    What carries it in a pile (the highest low thing below it), or else the closest thing it is
    on, or else the closest it is at, and up to ``max_near`` different ones near it: first
    larger furniture, then the rest, each nearest first. No measured relation leads to one of
    ``no_landmarks``. Landmarks carry class and attributes, no relations of their own.
    """
    if not instances:
        return []
    low = np.array([found.low_m for found in instances])
    high = np.array([found.high_m for found in instances])
    level = np.array([found.center_m[2] for found in instances])
    names = [graph.name for graph in graphs]
    kinds = _kinds(low, high, _rests(low, high, level), names)
    kinds[:, [name in no_landmarks for name in names]] = NONE
    lesser, never = _lesser(high - low)
    kinds[never & (kinds == NEAR)] = NONE
    held = np.isin(kinds, (ON, AT))
    piled = held & (high[:, 2] - low[:, 2] <= LOW_M)[None]
    lesser[held] = ~piled[held]
    gap = _gaps(low, high, kinds)
    gap[piled] = np.abs(level[:, None] - level[None])[piled]
    center = (low + high) / 2
    apart = np.linalg.norm(center[:, None] - center[None], axis=2)
    out = []
    keys = [identity(graph) for graph in graphs]
    for i, row in enumerate(kinds.tolist()):
        options: list[Option] = []
        for j in np.flatnonzero(kinds[i]).tolist():
            # In a pile it does not count whether a thing lies on or in the next one.
            order = row[j] if lesser[i, j] else 0
            ranks = round(float(gap[i, j]), 4), round(float(apart[i, j]), 4)
            options.append((bool(lesser[i, j]), order, *ranks, j))
        out.append(_chosen(sorted(options), row, graphs, keys, max_near))
    return out


def _gaps(low_m: Floats, high_m: Floats, kinds: NDArray[np.int64]) -> Floats:
    """Return how far A is from B on the ground; where it is on B, from B's top; (n, n)."""
    gaps = np.maximum(low_m[:, None] - high_m[None], low_m[None] - high_m[:, None])
    gap: Floats = np.hypot(*np.moveaxis(np.clip(gaps[..., :2], 0, None), 2, 0))
    on = kinds == ON
    gap[on] = np.abs(low_m[:, None, 2] - high_m[None, :, 2])[on]
    return gap


def _chosen(
    options: list[Option],
    kinds: list[int],
    graphs: list[ObjectGraph],
    keys: list[str],
    max_near: int,
) -> list[Relation]:
    """Return the first holder and the first landmarks near; equal landmarks once."""
    holder = [option[-1] for option in options if kinds[option[-1]] != NEAR][:1]
    named = {keys[j] for j in holder}
    near: list[int] = []
    for *_, j in options:
        if kinds[j] == NEAR and len(near) < max_near and keys[j] not in named:
            named.add(keys[j])
            near.append(j)
    return [Relation(ORDER[kinds[j] - 1], graphs[j]) for j in holder + near]


def captioned_relations(found: Found, share: float) -> list[Relation]:
    """Return the relations that at least ``share`` of the views' captions state.

    Relations vary by view, so one view among several is not enough. A thing has one holder,
    that of most views, and is not near or in one of its own class. The landmark's attributes
    are those most often stated.
    """
    stated = found.votes.stated
    least = max(min(2, found.hits), share * found.hits)
    kept = [
        key
        for key, known in stated.items()
        if known.views >= least and (key[0] not in ("is-near", "is-at") or key[1] != found.name)
    ]
    kept.sort(key=lambda key: (-stated[key].views, key))
    holder = next((key for key in kept if key[0] in HOLDS and not key[2]), None)
    return [
        Relation(key[0], stated[key].graphs[ranked(stated[key].variants)[0]], key[2])
        for key in kept
        if key[0] not in HOLDS or key[2] or key == holder
    ]


def relations_of(
    instances: list[Found], graphs: list[ObjectGraph], settings: MapperSettings
) -> list[list[Relation]]:
    """Return by instance its relations, in the order is-on, is-at, is-near, inverse ones last.

    What captions state again and again wins over what was measured about the same class of
    landmark, and about what carries or holds the thing: boxes of large furniture are coarse.
    Where both agree, the landmark is the measured one, with its voted attributes; where only
    the class agrees (red book, blue book), the thing of that look that it touches, if any.
    """
    measured = spatial_relations(instances, graphs, settings.max_near, settings.no_landmarks)
    stated = [captioned_relations(found, settings.relation_share) for found in instances]
    out = []
    for own, captioned, touched in zip(measured, stated, _touched(instances), strict=True):
        around = [graphs[j] for j in touched] if captioned else []
        out.append(_joined(own, captioned, around, settings.max_near))
    return out


def _touched(instances: list[Found]) -> list[list[int]]:
    """Return by thing those whose boxes come within ``ON_GAP_M`` of its own."""
    if not instances:
        return []
    low = np.array([found.low_m for found in instances])
    high = np.array([found.high_m for found in instances])
    apart = np.maximum(low[:, None] - high[None], low[None] - high[:, None]).max(axis=2)
    np.fill_diagonal(apart, np.inf)
    return [np.flatnonzero(row <= ON_GAP_M).tolist() for row in apart]


def _joined(
    own: list[Relation],
    captioned: list[Relation],
    touched: list[ObjectGraph],
    max_near: int,
) -> list[Relation]:
    """Return measured and captioned relations of one thing as one list."""
    if not captioned:
        return own
    stated = [relation for relation in captioned if not relation.inverse]
    held = any(relation.type in HOLDS for relation in stated)
    kept = [
        relation
        for relation in own
        if not (held and relation.type in HOLDS)
        and not any(names_agree(relation.target.name, s.target.name) for s in stated)
    ]
    chosen = [_landmark_of(relation, own, touched) for relation in stated]
    near = sum(relation.type == "is-near" for relation in chosen)
    for relation in kept:
        near += relation.type == "is-near"
        if relation.type != "is-near" or near <= max_near:
            chosen.append(relation)
    rank = {kind: i for i, kind in enumerate(ORDER)}
    ordered = sorted(chosen, key=lambda r: rank.get(r.type, len(ORDER)))
    return ordered + [relation for relation in captioned if relation.inverse]


def _landmark_of(
    stated: Relation, measured: list[Relation], touched: list[ObjectGraph]
) -> Relation:
    """Return what a caption states with the map's own landmark, or else with the caption's."""
    same = [
        relation
        for relation in measured
        if relation.type == stated.type and names_agree(relation.target.name, stated.target.name)
    ]
    alike = [relation.target for relation in same]
    if stated.type in HOLDS:
        alike += [graph for graph in touched if names_agree(graph.name, stated.target.name)]
    for graph in alike:
        if attributes_agree(graph.attributes, stated.target.attributes):
            return Relation(stated.type, graph)
    return same[0] if same else stated
