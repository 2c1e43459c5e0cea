"""The facts that may set a candidate apart, with the keys by which they are compared."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache
from itertools import combinations

import msgspec

from doro_dialogue.facts import (
    IS_AT,
    IS_ON,
    Attribute,
    Fact,
    facts_of,
    graph_key,
    graph_with,
    name_of,
    rank,
    value_of,
)
from doro_dialogue.matching import broader_values
from doro_schemas.graph import ObjectGraph, Relation

MOST_PARTS = 4
PLACES = 1 << MOST_PARTS
_INVERSE = " inverse"
Key = tuple[object, ...]


class Variant(msgspec.Struct, frozen=True, gc=False):
    """A fact, or a relation with some of its landmark's own facts.

    Attributes:
        source, parts: the observed fact, and which of its landmark's facts are said.
        key: equal for facts that say the same; implied: keys of the broader facts that follow.
        size: number of attributes and relations that the words carry.
        place: grows in the order of the facts, and of the choices within a fact.
    """

    source: Fact
    parts: tuple[Fact, ...]
    key: Key
    implied: list[Key]
    size: int
    place: int

    @property
    def rank(self) -> int:
        """Place in the documented order of facts."""
        return rank(self.source)[0]

    @property
    def excludes(self) -> bool:
        """Whether another of its type contradicts it; being near one thing excludes no other."""
        return isinstance(self.source, Attribute) or self.source.type in (IS_ON, IS_AT)

    def fact(self) -> Fact:
        """Return the fact as it is said."""
        if isinstance(self.source, Attribute):
            return self.source
        flat = [one if isinstance(one, Attribute) else _bare(one) for one in self.parts]
        target = graph_with(self.source.target.name, flat)
        return Relation(self.source.type, target, self.source.inverse)


def bare_variants(graph: ObjectGraph) -> Iterator[Variant]:
    """Yield the facts of a graph, of every landmark the name only."""
    for number, fact in enumerate(facts_of(graph)):
        if isinstance(fact, Attribute):
            value = value_of(fact.value)
            broader: list[Key] = [(fact.type, one) for one in broader_values(value)[1:]]
            yield Variant(fact, (), (fact.type, value), broader, 1, number * PLACES)
        else:
            yield _with_parts(fact, _types(fact), [], number * PLACES)


def described_variants(bare: Variant) -> Iterator[Variant]:
    """Yield a relation with each choice of its landmark's own facts, of the first four."""
    fact = bare.source
    if isinstance(fact, Attribute) or not (fact.target.attributes or fact.target.relations):
        return
    types, place = _types(fact), bare.place
    parts = [(one, _part_key(one)) for one in facts_of(fact.target)[:MOST_PARTS]]
    for count in range(1, len(parts) + 1):
        for chosen in combinations(parts, count):
            place += 1
            yield _with_parts(fact, types, chosen, place)


def _types(fact: Relation) -> tuple[str, ...]:
    """Return the types that a relation says, its own first: what is on a thing is at it."""
    mark = _INVERSE * fact.inverse
    return (IS_ON + mark, IS_AT + mark) if fact.type == IS_ON else (fact.type + mark,)


def _with_parts(
    fact: Relation,
    types: tuple[str, ...],
    chosen: Sequence[tuple[Fact, tuple[str, str] | str]],
    place: int,
) -> Variant:
    own = tuple(sorted([key for _, key in chosen if isinstance(key, tuple)]))
    related = tuple(sorted({key for _, key in chosen if isinstance(key, str)}))
    names = broader_names(name_of(fact.target.name))
    keys: list[Key] = [(kind, name, own, related) for kind in types for name in names]
    parts = tuple([one for one, _ in chosen])
    return Variant(fact, parts, keys[0], keys[1:], 1 + len(parts), place)


def _part_key(part: Fact) -> tuple[str, str] | str:
    """Return the key of a landmark's fact as :func:`graph_key` has it."""
    if isinstance(part, Attribute):
        return (part.type, value_of(part.value))
    return repr((part.type, part.inverse, graph_key(ObjectGraph(name=part.target.name))))


def _bare(relation: Relation) -> Relation:
    return Relation(relation.type, ObjectGraph(name=relation.target.name), relation.inverse)


@lru_cache(4096)
def broader_names(name: str) -> tuple[str, ...]:
    """Return a class name and the broader ones in it: "coffee table", "table"."""
    split = name.split(" ")
    return tuple(" ".join(split[i:]) for i in range(len(split)))
