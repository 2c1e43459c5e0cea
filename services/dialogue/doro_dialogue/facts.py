"""Single facts of an object graph, their order, and graphs built from chosen facts."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from functools import lru_cache

import msgspec

from doro_schemas.errors import Refused
from doro_schemas.graph import MAX_DEPTH, ObjectGraph, Relation
from doro_schemas.messages.map import Evidence
from doro_schemas.vocabulary import canonical_name, canonical_value

COLOR, MATERIAL = "color", "material"
IS_ON, IS_AT, IS_NEAR = "is-on", "is-at", "is-near"
ATTRIBUTE_ORDER = (COLOR, MATERIAL)
RELATION_ORDER = (IS_ON, IS_AT, IS_NEAR)
WORDS_CACHED = 4096

name_of = lru_cache(WORDS_CACHED)(canonical_name)
value_of = lru_cache(WORDS_CACHED)(canonical_value)


def words(text: str) -> frozenset[str]:
    """Return the words of a table line as a set for look-ups (never iterated)."""
    return frozenset(text.split())


class Attribute(msgspec.Struct, frozen=True):
    """One self attribute: its type and its value."""

    type: str
    value: str


Fact = Attribute | Relation


class Candidate(msgspec.Struct, frozen=True):
    """An instance as the decision sees it.

    Attributes:
        id, graph: its id and what is known of it.
        views: frames that show it, the strongest first; for left and right, nothing else.
    """

    id: str
    graph: ObjectGraph
    views: tuple[Evidence, ...] = ()


def rank(fact: Fact) -> tuple[int, str]:
    """Return the place of a fact in the documented order.

    color, material, other attributes, is-on, is-at, is-near, other relations, inverse ones;
    types that share a place are ordered by name.
    """
    if isinstance(fact, Attribute):
        return _attribute_rank(fact.type)
    return _relation_rank(fact.type, fact.inverse)


@lru_cache(WORDS_CACHED)
def _attribute_rank(kind: str) -> tuple[int, str]:
    order = ATTRIBUTE_ORDER
    return (order.index(kind) if kind in order else len(order), kind)


@lru_cache(WORDS_CACHED)
def _relation_rank(kind: str, inverse: bool) -> tuple[int, str]:
    order = RELATION_ORDER
    place = order.index(kind) if kind in order else len(order)
    return ((20 if inverse else 10) + place, kind)


def facts_of(graph: ObjectGraph) -> list[Fact]:
    """Return a graph's own facts in the documented order; equal types keep their order."""
    facts: list[Fact] = [Attribute(key, value) for key, value in graph.attributes.items()]
    facts += graph.relations
    return sorted(facts, key=rank) if len(facts) > 1 else facts


def graph_with(name: str, facts: Iterable[Fact]) -> ObjectGraph:
    """Return the graph that has exactly these facts, in the documented order."""
    ordered = list(facts)
    if len(ordered) > 1:
        ordered.sort(key=rank)
    return ObjectGraph(
        name=name,
        attributes={fact.type: fact.value for fact in ordered if isinstance(fact, Attribute)},
        relations=[fact for fact in ordered if isinstance(fact, Relation)],
    )


def place_of(graph: ObjectGraph) -> Relation | None:
    """Return the relation that says best where a thing is: is-on, then is-at, then is-near."""
    relations = [f for f in facts_of(graph) if isinstance(f, Relation) and not f.inverse]
    return shallow(relations[0]) if relations else None


def carried_by(*graphs: ObjectGraph) -> list[str]:
    """Return the classes of things that an object is said to have on or in it, each once."""
    names = [one.target.name for graph in graphs for one in graph.relations if one.inverse]
    return list(dict.fromkeys(names))


def shallow(relation: Relation) -> Relation:
    """Return the relation without what is known of the landmark's own surroundings."""
    bare = ObjectGraph(name=relation.target.name, attributes=relation.target.attributes)
    return Relation(relation.type, bare, relation.inverse)


def graph_key(graph: ObjectGraph) -> tuple[object, ...]:
    """Return a value that is equal for graphs that say the same in canonical words."""
    own = [(key, value_of(value)) for key, value in graph.attributes.items()]
    relations = [(one.type, one.inverse, graph_key(one.target)) for one in graph.relations]
    if len(relations) > 1:
        relations = sorted(dict.fromkeys(relations), key=repr)
    return (name_of(graph.name), tuple(sorted(own)), tuple(relations))


def natural_order(candidates: Sequence[Candidate]) -> list[Candidate]:
    """Return candidates by id with numbers in order (cup-2 before cup-10)."""
    return sorted(candidates, key=lambda candidate: (_natural(candidate.id), candidate.id))


@lru_cache(WORDS_CACHED)
def _natural(text: str) -> tuple[tuple[int, int, str], ...]:
    parts = re.findall(r"[0-9]+|[^0-9]+", text)
    return tuple((0, int(part), "") if part.isdecimal() else (1, 0, part) for part in parts)


def check_depth(graph: ObjectGraph, owner: str) -> None:
    """Raise Refused if a graph nests deeper than the wire allows.

    Args:
        owner: whose graph it is, for the sentence ("the instruction").
    """
    if any(depth > MAX_DEPTH for depth in _depths(graph)):
        raise Refused(
            f"the graph of {owner} nests deeper than {MAX_DEPTH} landmarks: say it with fewer"
        )


def _depths(graph: ObjectGraph) -> Iterator[int]:
    level = [graph]
    depth = 0
    while level and depth <= MAX_DEPTH + 1:
        yield depth
        level = [relation.target for node in level for relation in node.relations]
        depth += 1
