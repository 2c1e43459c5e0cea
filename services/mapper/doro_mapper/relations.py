"""Relations of instances: computed between their boxes, and voted from captions."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from doro_mapper.finder import Found, names_agree
from doro_mapper.settings import MapperSettings
from doro_mapper.track import ranked
from doro_schemas.graph import ObjectGraph, Relation, identity
from doro_schemas.spatial import NEAR_M, Box3, gap_m, relation_between

ORDER = ("is-on", "is-at", "is-near")
HOLDS = ("is-on", "is-at")
Option = tuple[bool, float, float, int]
"""Sorts landmarks: lesser, gap, distance of centres (metres); and the landmark's index."""


def box_of(found: Found) -> Box3:
    """Return the instance's box in (ground, ground, up) order, metres."""
    center = (found.low_m + found.high_m) / 2
    size = found.high_m - found.low_m
    return Box3(
        (float(center[0]), float(center[1]), float(center[2])),
        (float(size[0]), float(size[1]), float(size[2])),
    )


def spatial_relations(
    instances: list[Found],
    graphs: list[ObjectGraph],
    max_near: int,
    no_landmarks: Collection[str] = (),
) -> list[list[Relation]]:
    """Return by instance what holds between it and the others.

    The closest thing it is on, or else the closest it is at, and up to ``max_near`` different
    ones near it: first larger things of other classes, then the rest, each nearest first. A
    thing of its own class is a landmark for is-near only, one of ``no_landmarks`` never.
    Landmarks carry class and attributes, no relations of their own.
    """
    boxes = [box_of(found) for found in instances]
    if not boxes:
        return []
    low = np.array([[box.low(0), box.low(1)] for box in boxes])
    high = np.array([[box.high(0), box.high(1)] for box in boxes])
    apart = np.maximum(low[:, None] - high[None], low[None] - high[:, None]).max(-1)
    out = []
    for i, box in enumerate(boxes):
        options: dict[str, list[Option]] = {kind: [] for kind in ORDER}
        for j in np.flatnonzero(apart[i] <= NEAR_M).tolist():
            kind = _relation(box, boxes[j]) if j != i else None
            same = graphs[i].name == graphs[j].name
            if kind is None or (kind != "is-near" and same) or graphs[j].name in no_landmarks:
                continue
            gap = float(np.hypot(gap_m(box, boxes[j], 0), gap_m(box, boxes[j], 1)))
            if kind == "is-on":
                gap = abs(box.low(2) - boxes[j].high(2))
            apart_m = float(np.linalg.norm(np.subtract(box.center_m, boxes[j].center_m)))
            lesser = same or not _landmark(box, boxes[j])
            options[kind].append((lesser, round(gap, 4), round(apart_m, 4), j))
        out.append(_chosen(options, graphs, max_near))
    return out


def _relation(box: Box3, other: Box3) -> str | None:
    """Return how a thing stands to a landmark.

    Only what is larger on the ground carries or holds a thing. What it carries or holds itself
    is not near it: nobody says that a table is near its cup.
    """
    kind = relation_between(box, other)
    if kind is None or (kind != "is-near" and _ground_m2(other) <= _ground_m2(box)):
        return None
    reverse = relation_between(other, box)
    held = reverse is not None and reverse != "is-near" and _ground_m2(other) < _ground_m2(box)
    return None if held else kind


def _ground_m2(box: Box3) -> float:
    return box.size_m[0] * box.size_m[1]


def _landmark(box: Box3, other: Box3) -> bool:
    """Tell whether people would point at a thing by another: larger, and of furniture's size."""
    sides = sorted(other.size_m)
    return _ground_m2(other) > _ground_m2(box) and sides[2] >= 0.3 and sides[1] >= 0.15


def _chosen(
    options: dict[str, list[Option]], graphs: list[ObjectGraph], max_near: int
) -> list[Relation]:
    """Return one holder (on before at) and the nearest landmarks; equal landmarks once."""
    out: list[Relation] = []
    named: set[str] = set()
    for kind in ORDER:
        left = max_near if kind == "is-near" else 1 - len(out)
        for *_, j in sorted(options[kind]):
            key = identity(graphs[j])
            if left > 0 and key not in named:
                named.add(key)
                left -= 1
                out.append(Relation(kind, graphs[j]))
    return out


def captioned_relations(found: Found, share: float) -> list[Relation]:
    """Return the relations that at least ``share`` of the views' captions state.

    Relations vary by view, so one view among several is not enough. The landmark's attributes
    are those most often stated.
    """
    said: dict[tuple[str, str, bool], set[int]] = {}
    variants: dict[tuple[str, str, bool], dict[str, float]] = {}
    graphs: dict[str, ObjectGraph] = {}
    for sighting, weight in zip(found.sightings, found.weights, strict=True):
        for relation in sighting.graph.relations:
            key = (relation.type, relation.target.name, relation.inverse)
            said.setdefault(key, set()).add(sighting.serial)
            text = identity(relation.target)
            graphs[text] = ObjectGraph(relation.target.name, relation.target.attributes)
            votes = variants.setdefault(key, {})
            votes[text] = votes.get(text, 0.0) + weight
    least = min(2, found.hits)
    kept = [key for key, serials in said.items() if len(serials) >= max(least, share * found.hits)]
    kept.sort(key=lambda key: (-len(said[key]), key))
    return [Relation(key[0], graphs[ranked(variants[key])[0]], key[2]) for key in kept]


def relations_of(
    instances: list[Found], graphs: list[ObjectGraph], settings: MapperSettings
) -> list[list[Relation]]:
    """Return by instance its relations, in the order is-on, is-at, is-near, inverse ones last.

    What captions state again and again wins over what was measured about the same class of
    landmark, and about what carries or holds the thing: boxes of large furniture are coarse.
    Where both agree, the landmark is the measured one, with its voted attributes.
    """
    measured = spatial_relations(instances, graphs, settings.max_near, settings.no_landmarks)
    out = []
    for found, own in zip(instances, measured, strict=True):
        captioned = captioned_relations(found, settings.relation_share)
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
            if relation.type != "is-near" or near <= settings.max_near:
                chosen.append(relation)
        rank = {kind: i for i, kind in enumerate(ORDER)}
        ordered = sorted(chosen, key=lambda r: rank.get(r.type, len(ORDER)))
        out.append(ordered + [relation for relation in captioned if relation.inverse])
    return out


def _measured_target(stated: Relation, measured: list[Relation]) -> Relation:
    """Return the measured relation that a caption states as well, or else the caption's."""
    for relation in measured:
        if relation.type == stated.type and names_agree(relation.target.name, stated.target.name):
            return relation
    return stated
