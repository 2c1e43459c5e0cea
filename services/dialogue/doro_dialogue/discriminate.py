"""The smallest set of facts that sets each candidate apart from the others.

Exact: for every candidate all sets of its facts are searched by growing size. Size counts
the facts that the words will carry: an attribute or a relation is one, each attribute or
relation of a landmark one more. Sets of one size are ordered by how many of the others they
exclude only because nothing was observed there (fewer first), then by the documented order
of facts: color, material, other attributes, is-on, is-at, is-near, other relations.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache
from itertools import combinations

import msgspec

from doro_dialogue.facts import (
    IS_AT,
    IS_ON,
    WORDS_CACHED,
    Attribute,
    Candidate,
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

MAX_OPTIONS = 16
PIVOTS_TRIED = 6
Key = tuple[object, ...]
_INVERSE = " inverse"


class Group(msgspec.Struct, frozen=True):
    """A candidate, or several that nothing observed tells apart.

    Attributes:
        ids: instances, in the order given.
        graph: name and the facts that set it apart, no others.
        seen: all that was observed.
        other: all that is known of it holds of another candidate too, so that it can only
            be called "one other".
    """

    ids: list[str]
    graph: ObjectGraph
    seen: ObjectGraph
    other: bool = False


class _Option(msgspec.Struct, frozen=True):
    """A fact to choose, with bit masks over the groups.

    Attributes:
        same: groups of which the very same words are observed.
        true: groups of which it is true, in narrower words too.
        known: groups of which something of its type is observed that could contradict it.
    """

    fact: Fact
    size: int
    order: tuple[int, int]
    same: int
    true: int
    known: int


def discriminate(candidates: Sequence[Candidate]) -> list[Group]:
    """Return a group for every candidate or set of twins; those called "other" come last."""
    twins = twins_of(candidates)
    graphs = [members[0].graph for members in twins]
    index = _Index(graphs)
    groups = []
    for i, members in enumerate(twins):
        facts, other = index.smallest(i)
        graph = graph_with(graphs[i].name, facts)
        groups.append(Group([one.id for one in members], graph, graphs[i], other))
    return sorted(groups, key=_order)


def twins_of(candidates: Sequence[Candidate]) -> list[list[Candidate]]:
    """Return the candidates by what is known of them; several together are twins."""
    twins: dict[Key, list[Candidate]] = {}
    for candidate in candidates:
        twins.setdefault(graph_key(candidate.graph), []).append(candidate)
    return list(twins.values())


def _order(group: Group) -> tuple[bool, int]:
    """Others last, and of those the one with more words first ("one other red cup")."""
    return group.other, -len(facts_of(group.graph)) if group.other else 0


class _Index:
    """Which groups have which fact, as bit masks by fact key."""

    def __init__(self, graphs: Sequence[ObjectGraph]) -> None:
        self._all = (1 << len(graphs)) - 1
        self._same: dict[Key, int] = {}
        self._true: dict[Key, int] = {}
        self._known: dict[str, int] = {}
        self._names = [name_of(graph.name) for graph in graphs]
        self._facts = [
            [(fact, size, _key(fact)) for fact, size in _variants(graph)] for graph in graphs
        ]
        for i, (name, facts) in enumerate(zip(self._names, self._facts, strict=True)):
            bit = 1 << i
            self._add(("name", name), [("name", n) for n in _broader_names(name)], bit)
            for fact, _, key in facts:
                self._add(key, _implied(fact, key), bit)
                # Being near one thing excludes no other: nothing there contradicts.
                if isinstance(fact, Attribute) or fact.type in (IS_ON, IS_AT):
                    self._known[fact.type] = self._known.get(fact.type, 0) | bit

    def _add(self, key: Key, implied: list[Key], bit: int) -> None:
        self._same[key] = self._same.get(key, 0) | bit
        for one in (key, *implied):
            self._true[one] = self._true.get(one, 0) | bit

    def smallest(self, i: int) -> tuple[list[Fact], bool]:
        """Return the facts that set group ``i`` apart, and whether only partly."""
        own, name = 1 << i, ("name", self._names[i])
        options = self._options(i)
        strict = [(option, option.true) for option in options]
        facts = _search(strict, self._true[name], own, self._all)
        if facts is not None:
            return facts, False
        # "blue" is true of a dark blue one, but said beside it the contrast is clear.
        literal = [(option, option.same) for option in options]
        reach = self._same[name]
        for option in options:
            reach &= option.same
        return _search(literal, self._same[name], reach, self._all) or [], reach != own

    def _options(self, i: int) -> list[_Option]:
        """Return the facts of group ``i``; of those that exclude the same groups, the best."""
        best: dict[tuple[int, int, int], _Option] = {}
        for order, (fact, size, key) in enumerate(self._facts[i]):
            if self._same[key] == self._all:
                continue
            option = _Option(
                fact=fact,
                size=size,
                order=(rank(fact)[0], order),
                same=self._same[key],
                true=self._true[key],
                known=self._known.get(fact.type, 0),
            )
            slot = (option.same, option.true, option.known)
            kept = best.setdefault(slot, option)
            if (option.size, option.order) < (kept.size, kept.order):
                best[slot] = option
        return sorted(best.values(), key=lambda option: (option.size, option.order))[:MAX_OPTIONS]


def _search(
    options: list[tuple[_Option, int]], start: int, goal: int, everyone: int
) -> list[Fact] | None:
    """Return the best smallest set whose masks meet in ``goal``; None if there is none."""
    if start == goal:
        return []
    reach = start
    for _, mask in options:
        reach &= mask
    if reach != goal:
        return None
    for size in range(1, sum(option.size for option, _ in options) + 1):
        found = list(_sets_of_size(options, start, goal, size))
        if found:
            best = min(found, key=lambda chosen: _score(chosen, everyone))
            return [option.fact for option, _ in best]
    return None


def _sets_of_size(
    options: list[tuple[_Option, int]], mask: int, goal: int, size: int
) -> Iterator[tuple[tuple[_Option, int], ...]]:
    """Yield the sets of at most this size that exclude every group of ``mask`` but ``goal``.

    Every such set has a fact that excludes any one of those groups: only such branches are
    followed, and none of the smallest sets is missed.
    """
    if mask == goal:
        yield ()
        return
    if size == 1:
        yield from ((pair,) for pair in options if pair[0].size == 1 and mask & pair[1] == goal)
        return
    for pair in _branches(options, mask & ~goal):
        if pair[0].size <= size:
            for more in _sets_of_size(options, mask & pair[1], goal, size - pair[0].size):
                yield (pair, *more)


def _branches(options: list[tuple[_Option, int]], left: int) -> list[tuple[_Option, int]]:
    """Return the facts that exclude one of the groups left, one that few facts exclude."""
    fewest = options
    for _ in range(PIVOTS_TRIED):
        lowest = left & -left
        if not lowest:
            break
        excluding = [pair for pair in options if not pair[1] & lowest]
        fewest = min(fewest, excluding, key=len)
        left ^= lowest
    return fewest


def _score(
    chosen: tuple[tuple[_Option, int], ...], everyone: int
) -> tuple[int, list[tuple[int, int]]]:
    """Order sets of one size: groups that nothing contradicts, then the order of facts."""
    open_ = everyone
    for option, _ in chosen:
        open_ &= ~(option.known & ~option.true)
    return open_.bit_count(), sorted(option.order for option, _ in chosen)


def _variants(graph: ObjectGraph) -> Iterator[tuple[Fact, int]]:
    """Yield facts and their sizes; a relation once with each part of its landmark."""
    for fact in facts_of(graph):
        if isinstance(fact, Attribute):
            yield fact, 1
            continue
        parts = facts_of(fact.target)[:4]
        for count in range(len(parts) + 1):
            for chosen in combinations(parts, count):
                flat = [p if isinstance(p, Attribute) else _bare(p) for p in chosen]
                target = graph_with(fact.target.name, flat)
                yield Relation(fact.type, target, fact.inverse), 1 + count


def _bare(relation: Relation) -> Relation:
    return Relation(relation.type, ObjectGraph(name=relation.target.name), relation.inverse)


def _key(fact: Fact) -> Key:
    if isinstance(fact, Attribute):
        return (fact.type, value_of(fact.value))
    return (fact.type + _INVERSE * fact.inverse, *graph_key(fact.target))


def _implied(fact: Fact, key: Key) -> list[Key]:
    """Return the keys of broader facts that this one, with its key, implies."""
    if isinstance(fact, Attribute):
        return [(fact.type, value) for value in broader_values(value_of(fact.value))[1:]]
    _, name, own, relations = key
    types = (IS_ON, IS_AT) if fact.type == IS_ON else (fact.type,)
    mark = _INVERSE * fact.inverse
    names = _broader_names(str(name))
    return [(type_ + mark, one, own, relations) for type_ in types for one in names]


@lru_cache(WORDS_CACHED)
def _broader_names(name: str) -> tuple[str, ...]:
    split = name.split(" ")
    return tuple(" ".join(split[i:]) for i in range(len(split)))
