"""Relations of instances: computed between their boxes, and voted from captions."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray

from doro_mapper.finder import Found, names_agree
from doro_mapper.settings import MapperSettings
from doro_mapper.views import Bools, Floats
from doro_mapper.votes import ranked
from doro_schemas.graph import ObjectGraph, Relation, identity
from doro_schemas.spatial import NEAR_M, NEAR_UP_M, ON_GAP_M, ON_OVERLAP

ORDER = ("is-on", "is-at", "is-near")
HOLDS = ("is-on", "is-at")
NONE, ON, AT, NEAR = range(4)
STACKED_SHARE = 0.5
LANDMARK_SIDES_M = (0.15, 0.3)
Option = tuple[bool, float, float, int]
"""Sorts landmarks: lesser, gap, distance of centres (metres); and the landmark's index."""


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


def _kinds(low_m: Floats, high_m: Floats, area_m2: Floats, same: Bools) -> NDArray[np.int64]:
    """Return how things stand to landmarks.

    Only what is larger on the ground carries or holds a thing; of one class, as measured, what
    is not much smaller (a book on a book). What a thing carries or holds itself is not near
    it: nobody says that a table is near its cup.
    """
    kinds = relation_matrix(low_m, high_m)
    held = np.isin(kinds, (ON, AT))
    holds = area_m2[None] > area_m2[:, None]
    holds |= same & (kinds == ON) & (area_m2[None] > STACKED_SHARE * area_m2[:, None])
    kinds[held & ~holds] = NONE
    kinds[(held & holds).T] = NONE
    return kinds


def _landmarks(size_m: Floats, area_m2: Floats) -> Bools:
    """Tell whether people would point at A by B: larger, and of furniture's size, (n, n)."""
    sides = np.sort(size_m, axis=1)
    furniture = (sides[:, 2] >= LANDMARK_SIDES_M[1]) & (sides[:, 1] >= LANDMARK_SIDES_M[0])
    return np.asarray((area_m2[None] > area_m2[:, None]) & furniture[None])


def spatial_relations(
    instances: list[Found],
    graphs: list[ObjectGraph],
    max_near: int,
    no_landmarks: Collection[str] = (),
) -> list[list[Relation]]:
    """Return by instance what holds between it and the others.

    The closest thing it is on, or else the closest it is at, and up to ``max_near`` different
    ones near it: first larger things of other classes, then the rest, each nearest first. A
    thing lies on or in one of its own class as on any other (a book on a book). No measured
    relation leads to one of ``no_landmarks``. Landmarks carry class and attributes, no
    relations of their own.
    """
    if not instances:
        return []
    low = np.array([found.low_m for found in instances])
    high = np.array([found.high_m for found in instances])
    size = high - low
    area = size[:, 0] * size[:, 1]
    same = np.array([[a.name == b.name for b in graphs] for a in graphs], dtype=bool)
    kinds = _kinds(low, high, area, same)
    kinds[:, [graph.name in no_landmarks for graph in graphs]] = NONE
    lesser = same | ~_landmarks(size, area)
    gaps = np.clip(np.maximum(low[:, None] - high[None], low[None] - high[:, None]), 0, None)
    gap = np.hypot(gaps[..., 0], gaps[..., 1])
    on = kinds == ON
    gap[on] = np.abs(low[:, None, 2] - high[None, :, 2])[on]
    center = (low + high) / 2
    apart = np.linalg.norm(center[:, None] - center[None], axis=2)
    keys = [identity(graph) for graph in graphs]
    out = []
    for i in range(len(instances)):
        options: dict[str, list[Option]] = {kind: [] for kind in ORDER}
        for j in np.flatnonzero(kinds[i]).tolist():
            option = (bool(lesser[i, j]), round(float(gap[i, j]), 4), round(float(apart[i, j]), 4))
            options[ORDER[int(kinds[i, j]) - 1]].append((*option, j))
        out.append(_chosen(options, graphs, keys, max_near))
    return out


def _chosen(
    options: dict[str, list[Option]], graphs: list[ObjectGraph], keys: list[str], max_near: int
) -> list[Relation]:
    """Return one holder (on before at) and the nearest landmarks; equal landmarks once."""
    out: list[Relation] = []
    named: dict[str, None] = {}
    for kind in ORDER:
        left = max_near if kind == "is-near" else 1 - len(out)
        ranks = (
            sorted(options[kind])
            if kind == "is-near"
            else sorted(options[kind], key=lambda option: option[1:])
        )
        for *_, j in ranks:
            if left > 0 and keys[j] not in named:
                named[keys[j]] = None
                left -= 1
                out.append(Relation(kind, graphs[j]))
    return out


def captioned_relations(found: Found, share: float) -> list[Relation]:
    """Return the relations that at least ``share`` of the views' captions state.

    Relations vary by view, so one view among several is not enough. The landmark's attributes
    are those most often stated.
    """
    stated = found.votes.stated
    least = max(min(2, found.hits), share * found.hits)
    kept = [key for key, known in stated.items() if known.views >= least]
    kept.sort(key=lambda key: (-stated[key].views, key))
    return [
        Relation(key[0], stated[key].graphs[ranked(stated[key].variants)[0]], key[2])
        for key in kept
    ]


def relations_of(
    instances: list[Found], graphs: list[ObjectGraph], settings: MapperSettings
) -> list[list[Relation]]:
    """Return by instance its relations, in the order is-on, is-at, is-near, inverse ones last.

    What captions state again and again wins over what was measured about the same class of
    landmark, and about what carries or holds the thing: boxes of large furniture are coarse.
    Where both agree, the landmark is the measured one, with its voted attributes.
    """
    measured = spatial_relations(instances, graphs, settings.max_near, settings.no_landmarks)
    return [
        _joined(own, captioned_relations(found, settings.relation_share), settings.max_near)
        for found, own in zip(instances, measured, strict=True)
    ]


def _joined(own: list[Relation], captioned: list[Relation], max_near: int) -> list[Relation]:
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
    chosen = [_measured_target(relation, own) for relation in stated]
    near = sum(relation.type == "is-near" for relation in chosen)
    for relation in kept:
        near += relation.type == "is-near"
        if relation.type != "is-near" or near <= max_near:
            chosen.append(relation)
    rank = {kind: i for i, kind in enumerate(ORDER)}
    ordered = sorted(chosen, key=lambda r: rank.get(r.type, len(ORDER)))
    return ordered + [relation for relation in captioned if relation.inverse]


def _measured_target(stated: Relation, measured: list[Relation]) -> Relation:
    """Return the measured relation that a caption states as well, or else the caption's."""
    for relation in measured:
        if relation.type == stated.type and names_agree(relation.target.name, stated.target.name):
            return relation
    return stated
