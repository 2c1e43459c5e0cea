"""The smallest set of facts that sets each candidate apart from the others.

Exact: for every candidate all sets of its facts are searched by growing size. Size counts
the facts that the words will carry: an attribute or a relation is one, each attribute or
relation of a landmark one more. Sets of one size are ordered by how many of the others they
exclude only because nothing was observed there (fewer first), then by the documented order
of facts: color, material, other attributes, is-on, is-at, is-near, other relations.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence

import msgspec

from doro_dialogue.facts import (
    Candidate,
    Fact,
    facts_of,
    graph_key,
    graph_with,
    name_of,
    value_of,
)
from doro_dialogue.variants import (
    Key,
    Variant,
    bare_variants,
    broader_names,
    described_variants,
)
from doro_schemas.graph import ObjectGraph

MAX_OPTIONS = 16
PIVOTS_TRIED = 6


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


class _Option(msgspec.Struct, frozen=True, gc=False):
    """A fact to choose, with bit masks over the groups.

    Attributes:
        same: groups of which the very same words are observed.
        true: groups of which it is true, in narrower words too.
        known: groups of which something of its type is observed that could contradict it.
    """

    variant: Variant
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
        facts, other = index.single(i), False
        if facts is None:
            facts, other = index.smallest(i)
        graph = graph_with(graphs[i].name, facts)
        groups.append(Group([one.id for one in members], graph, graphs[i], other))
    return sorted(groups, key=_order)


def twins_of(candidates: Sequence[Candidate]) -> list[list[Candidate]]:
    """Return the candidates by what is known of them; several together are twins.

    Landmarks are compared only where all else is equal.
    """
    own = [_own_key(one.graph) for one in candidates]
    counts = Counter(own)
    twins: dict[Key, list[Candidate]] = {}
    for key, one in zip(own, candidates, strict=True):
        twins.setdefault(key if counts[key] == 1 else graph_key(one.graph), []).append(one)
    return list(twins.values())


def _own_key(graph: ObjectGraph) -> Key:
    own = sorted([(key, value_of(value)) for key, value in graph.attributes.items()])
    return (name_of(graph.name), tuple(own))


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
        self._facts = [list(bare_variants(graph)) for graph in graphs]
        self._described = False
        for i, (name, facts) in enumerate(zip(self._names, self._facts, strict=True)):
            bit = 1 << i
            self._add(("name", name), [("name", n) for n in broader_names(name)], bit)
            for one in facts:
                self._add(one.key, one.implied, bit)
                if one.excludes:
                    kind = one.source.type
                    self._known[kind] = self._known.get(kind, 0) | bit

    def _describe(self) -> None:
        """Add what landmarks look like; most groups are set apart without.

        A relation that holds of no other group, in broader words either, gains nothing by it.
        """
        for i, bare in enumerate(self._facts):
            own = 1 << i
            shared = [one for one in bare if self._shared(one, own)]
            for more in (more for one in shared for more in described_variants(one)):
                bare.append(more)
                self._add(more.key, more.implied, own)
        self._described = True

    def _shared(self, one: Variant, own: int) -> bool:
        return self._true[one.key] != own or any(self._true[key] != own for key in one.implied)

    def _add(self, key: Key, implied: list[Key], bit: int) -> None:
        self._same[key] = self._same.get(key, 0) | bit
        self._true[key] = self._true.get(key, 0) | bit
        for one in implied:
            self._true[one] = self._true.get(one, 0) | bit

    def single(self, i: int) -> list[Fact] | None:
        """Return the one fact that sets group ``i`` apart, or none if none is needed."""
        start, goal = self._true["name", self._names[i]], 1 << i
        if start == goal:
            return []
        best: tuple[int, int, int] | None = None
        for number, one in enumerate(self._facts[i]):
            if one.size > 1:
                break  # those with described landmarks stand behind all others
            true = self._true[one.key]
            if start & true != goal or self._same[one.key] == self._all:
                continue
            # Groups that nothing contradicts, then the order of facts: as in _score.
            open_ = ~self._known.get(one.source.type, 0) | true
            place = ((self._all & open_).bit_count(), one.rank, number)
            best = place if best is None else min(best, place)
        return None if best is None else [self._facts[i][best[2]].fact()]

    def smallest(self, i: int) -> tuple[list[Fact], bool]:
        """Return the facts that set group ``i`` apart, and whether only partly."""
        if not self._described:
            self._describe()
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
        for one in self._facts[i]:
            option = _Option(
                variant=one,
                size=one.size,
                order=(one.rank, one.place),
                same=self._same[one.key],
                true=self._true[one.key],
                known=self._known.get(one.source.type, 0),
            )
            slot = (option.same, option.true, option.known)
            if option.same != self._all:
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
            return [option.variant.fact() for option, _ in best]
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
