"""Relations of instances: computed between their boxes, and voted from captions."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray

from doro_mapper.finder import Found, attributes_agree, names_agree
from doro_mapper.holders import AT, LOW_M, NEAR, NONE, ON, lesser_landmarks, standing
from doro_mapper.settings import MapperSettings
from doro_mapper.views import Floats
from doro_mapper.votes import ranked
from doro_schemas.graph import ObjectGraph, Relation, identity
from doro_schemas.spatial import ON_GAP_M

ORDER = ("is-on", "is-at", "is-near")
HOLDS = ("is-on", "is-at")
Option = tuple[bool, int, float, float, int]
"""Sorts landmarks: lesser, kind, gap, distance of centres (metres); and the landmark's index."""


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
    kinds = standing(low, high, level, names, no_landmarks)
    lesser, never = lesser_landmarks(high - low)
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
