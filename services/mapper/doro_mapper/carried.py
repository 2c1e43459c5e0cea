"""Inverse relations on demand: what an instance has on or in it."""

from __future__ import annotations

from collections.abc import Sequence

import msgspec

from doro_schemas.camera import World, bev_axes
from doro_schemas.graph import ObjectGraph, Relation
from doro_schemas.messages import Instance
from doro_schemas.spatial import Box3, relation_between
from doro_schemas.vocabulary import name_satisfies

HOLDS = ("is-on", "is-at")


def with_carried(
    chosen: Sequence[Instance], everything: Sequence[Instance], names: Sequence[str], world: World
) -> list[Instance]:
    """Return the chosen instances, with inverse relations to the things of the named classes
    that lie on or in them by the rule of :mod:`doro_schemas.spatial`; equal things once.

    Args:
        chosen: the instances that were asked for.
        everything: all instances of the map.
        names: classes as said; empty = nothing is added.
        world: which of the axes are the ground.
    """
    if not names:
        return list(chosen)
    things = [
        (one, _box(one, world))
        for one in everything
        if any(name_satisfies(name, one.graph.name) for name in names)
    ]
    return [_with(one, things, world) for one in chosen]


def _with(one: Instance, things: Sequence[tuple[Instance, Box3]], world: World) -> Instance:
    box = _box(one, world)
    relations = list(one.graph.relations)
    for thing, own in things:
        kind = relation_between(own, box)
        if thing.instance_id == one.instance_id or kind not in HOLDS or _ground(own) > _ground(box):
            continue
        target = ObjectGraph(thing.graph.name, thing.graph.attributes)
        relation = Relation(kind, target, inverse=True)
        if relation not in relations:
            relations.append(relation)
    graph = ObjectGraph(one.graph.name, one.graph.attributes, relations)
    return msgspec.structs.replace(one, graph=graph)


def _box(one: Instance, world: World) -> Box3:
    a, b, up = bev_axes(world)
    position, extent = one.position_m, one.extent_m
    return Box3((position[a], position[b], position[up]), (extent[a], extent[b], extent[up]))


def _ground(box: Box3) -> float:
    return box.size_m[0] * box.size_m[1]
