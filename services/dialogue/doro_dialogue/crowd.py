"""Many candidates by kind: what a person can answer without hearing all of them named."""

from __future__ import annotations

from collections.abc import Sequence

import msgspec

from doro_dialogue.facts import (
    IS_NEAR,
    Attribute,
    Candidate,
    Fact,
    facts_of,
    name_of,
    rank,
    value_of,
)
from doro_dialogue.surface import count_word, plural, predicate, without_article
from doro_schemas.graph import ObjectGraph, Relation

MAX_NAMED = 5
"""Clauses that a question names one by one; the paper has up to five copies."""

MAX_BUNCHES = 4
MAX_VALUES = 7
"""Kinds that are named at most: places and classes are longer to hear than colors."""

Key = tuple[str, str]
KIND = "kind"


class Bunch(msgspec.Struct, frozen=True):
    """Candidates that share a fact, or the rest.

    Attributes:
        ids: the instances.
        words: count and fact ("five red", "three more").
        fact: what they share; None for kinds of the class and for the rest.
        name: their class, where it is what they share.
    """

    ids: list[str]
    words: str
    fact: Fact | None = None
    name: str = ""


class _Cut(msgspec.Struct, frozen=True):
    """One way to cut the crowd: by a type of fact."""

    order: tuple[int, str]
    kinds: dict[Key, list[Candidate]]
    facts: dict[Key, Fact | None]
    rest: list[Candidate]

    @property
    def largest(self) -> int:
        return max([len(self.rest), *map(len, self.kinds.values())])

    @property
    def cost(self) -> int:
        """What is left to ask about at worst, and what has no name to be asked for."""
        return self.largest + len(self.rest)


def bunches(candidates: Sequence[Candidate], skip: Sequence[str] = ()) -> list[Bunch]:
    """Return the bunches of the best cut, the largest first, what is left over last.

    The best cut leaves the smallest bunch to ask about next and the fewest without a name;
    among equals the documented order of facts decides. Empty where nothing cuts them.

    Args:
        skip: types of facts that all share.
    """
    types = {fact.type: rank(fact) for one in candidates for fact in facts_of(one.graph)}
    cuts = [_by_kind(candidates)]
    cuts += [_by_type(candidates, kind, types[kind]) for kind in types if kind not in skip]
    useful = [cut for cut in cuts if cut.largest < len(candidates) and len(cut.kinds) > 0]
    if not useful:
        return []
    best = min(useful, key=lambda cut: (cut.cost, cut.order))
    return _bunched(best)


def _bunched(cut: _Cut) -> list[Bunch]:
    found = [
        Bunch(
            ids=[one.id for one in members],
            words=_words(len(members), cut.facts[key], key),
            fact=cut.facts[key],
            name=key[1] if cut.facts[key] is None else "",
        )
        for key, members in cut.kinds.items()
    ]
    rest = [one.id for one in cut.rest]
    if rest:
        found.append(Bunch(rest, f"{count_word(len(rest))} more"))
    return found


def _words(count: int, fact: Fact | None, key: Key) -> str:
    if fact is None:
        return f"{count_word(count)} {key[1] if count == 1 else plural(key[1])}"
    if isinstance(fact, Attribute):
        return f"{count_word(count)} {_adjective(fact)}"
    return f"{count_word(count)} {predicate([fact])}"


def _adjective(fact: Attribute) -> str:
    """Return the value as it stands before a noun ("wooden")."""
    return without_article(ObjectGraph(name="x", attributes={fact.type: fact.value})).split(" x")[0]


def _by_kind(candidates: Sequence[Candidate]) -> _Cut:
    kinds: dict[Key, list[Candidate]] = {}
    for one in candidates:
        kinds.setdefault((KIND, name_of(one.graph.name)), []).append(one)
    facts: dict[Key, Fact | None] = dict.fromkeys(kinds)
    return _kept((-1, ""), kinds, facts, [])


def _by_type(candidates: Sequence[Candidate], kind: str, order: tuple[int, str]) -> _Cut:
    kinds: dict[Key, list[Candidate]] = {}
    facts: dict[Key, Fact | None] = {}
    rest: list[Candidate] = []
    for one in candidates:
        own = [fact for fact in facts_of(one.graph) if fact.type == kind]
        if len(own) != 1 and kind != IS_NEAR:
            rest.append(one)
            continue
        if not own:
            rest.append(one)
            continue
        key, fact = _shown(own[0])
        kinds.setdefault(key, []).append(one)
        facts.setdefault(key, fact)
    return _kept(order, kinds, facts, rest)


def _shown(fact: Fact) -> tuple[Key, Fact]:
    """Return a fact as it is said of many: a landmark by its noun alone."""
    if isinstance(fact, Attribute):
        return (fact.type, value_of(fact.value)), fact
    bare = Relation(fact.type, ObjectGraph(name=fact.target.name), fact.inverse)
    return (fact.type + "'" * fact.inverse, name_of(fact.target.name)), bare


def _kept(
    order: tuple[int, str],
    kinds: dict[Key, list[Candidate]],
    facts: dict[Key, Fact | None],
    rest: list[Candidate],
) -> _Cut:
    """Keep the largest kinds; the others join what is left over."""
    ranked = sorted(kinds, key=lambda key: (-len(kinds[key]), key))
    short = all(isinstance(fact, Attribute) for fact in facts.values())
    few = ranked[: MAX_VALUES if short else MAX_BUNCHES]
    over = [one for key in ranked[len(few) :] for one in kinds[key]]
    return _Cut(order, {key: kinds[key] for key in few}, facts, [*rest, *over])
