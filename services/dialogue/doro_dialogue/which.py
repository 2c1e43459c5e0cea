"""The question among several: each named by what sets it apart, rows by side, crowds by kind."""

from __future__ import annotations

from collections.abc import Sequence

import msgspec

from doro_dialogue.crowd import MAX_NAMED, Bunch, bunches
from doro_dialogue.decision import Decision
from doro_dialogue.discriminate import Group, discriminate, twins_of
from doro_dialogue.facts import (
    COLOR,
    Attribute,
    Fact,
    facts_of,
    graph_with,
    place_of,
)
from doro_dialogue.matching import Match
from doro_dialogue.rows import Row, row_of
from doro_dialogue.surface import (
    counted,
    predicate,
    without_article,
)
from doro_dialogue.wording import WH_SUFFIXES, Part, Question
from doro_schemas.graph import Relation


def ask_which(decision: Decision, carries: bool) -> Question:
    """Name each candidate by what sets it apart, and ask which.

    The own words of the person come along where they hold ("one red cup on top of the
    table" for "the red cup"): without them it is not said that these are red. Twins that one
    view shows side by side are told apart by side. More than a person can keep in mind are
    told by kind ("twelve cups: five red, four blue, and three more").
    """
    offered = [one.candidate for one in decision.offered]
    if len(offered) > MAX_NAMED and len(twins_of(offered)) > MAX_NAMED:
        return _ask_crowd(decision, carries)
    groups = discriminate(offered)
    rows = _rows(decision, groups)
    alone = len(groups) == 1
    texts, parts = [], []
    for group in groups:
        part = _part(group, _echo(decision, group.ids), alone=alone)
        row = rows.get(group.ids[0])
        texts.append(part.text if row is None else f"{part.text}, {row.words}")
        parts += [part] if row is None else _sides(part, row)
    suffixes = _which_suffixes(carries)
    if alone and not rows:
        either = "either" if len(groups[0].ids) == 2 else "any"
        suffixes = [f"is {either} of them fine?", f"does it matter which one{_take(carries)}?"]
    found = ", and ".join(_series(texts)) + _note(decision)
    seen_from = next((row.seen_from for row in rows.values()), None)
    return Question(parts, [f"I found {found}; {one}" for one in suffixes], seen_from)


def ask_from_left(decision: Decision, carries: bool) -> Question | None:
    """Name each from left to right in the view that shows all; None where there is none."""
    row = row_of([one.candidate for one in decision.offered])
    if row is None:
        return None
    groups = discriminate([one.candidate for one in decision.offered])
    parts = {
        name: _part(msgspec.structs.replace(group, ids=[name]), [], alone=False)
        for group in groups
        for name in group.ids
    }
    ordered = [parts[name] for name in row.ids]
    found = ", and ".join(_series([part.text for part in ordered]))
    text = f"From left to right, as I saw them, I found {found}"
    wordings = [f"{text}; {suffix}" for suffix in _which_suffixes(carries)]
    return Question(ordered, wordings, row.seen_from)


def _rows(decision: Decision, groups: Sequence[Group]) -> dict[str, Row]:
    """Return the row of the only group of twins, by its first instance.

    With two such groups "the left one" would be two things.
    """
    twins = [group for group in groups if len(group.ids) > 1]
    if len(twins) != 1:
        return {}
    by_id = {one.candidate.id: one.candidate for one in decision.offered}
    row = row_of([by_id[name] for name in twins[0].ids])
    return {} if row is None else {twins[0].ids[0]: row}


def _sides(part: Part, row: Row) -> list[Part]:
    """Return a clause for each twin, from left to right."""
    one = counted(part.graph)
    return [
        Part([name], f"{one}, {side}", part.graph)
        for name, side in zip(row.ids, row.sides, strict=True)
    ]


def _ask_crowd(decision: Decision, carries: bool) -> Question:
    """Say how many there are of each kind, and ask for the kind."""
    offered = [one.candidate for one in decision.offered]
    echo = _echo(decision, [one.id for one in offered])
    name = decision.graph.name
    found = bunches(offered, skip=[fact.type for fact in echo])
    whole = counted(graph_with(name, echo), len(offered), alike=False)
    parts = [_bunch_part(one, name, echo) for one in found]
    kinds = ", and ".join(_series([one.words for one in found]))
    text = f"I found {whole}{': ' if found else ''}{kinds}{_note(decision)}"
    if not found:
        ids = [one.id for one in offered]
        parts = [Part(ids, whole, graph_with(name, echo))]
    suffixes = [*_kind_suffixes(found), *_which_suffixes(carries)]
    return Question(parts, [f"{text}; {suffix}" for suffix in suffixes])


def _bunch_part(bunch: Bunch, name: str, echo: list[Fact]) -> Part:
    facts = [*echo, *([bunch.fact] if bunch.fact is not None else [])]
    graph = graph_with(bunch.name or name, facts)
    text = counted(graph, len(bunch.ids), alike=False)
    if bunch.fact is None and not bunch.name:
        # Not "other": "the other one" would be too short for one that nobody has described.
        text = text.replace(" ", " more ", 1)
    return Part(bunch.ids, text, graph)


def _kind_suffixes(found: Sequence[Bunch]) -> list[str]:
    """Return the question for the very thing that tells the kinds apart."""
    if not found:
        return ["please tell me more about the one you mean, its color or where it is."]
    fact = found[0].fact
    if isinstance(fact, Relation):
        return ["where is the one you mean?"]
    if isinstance(fact, Attribute):
        what = "what color is" if fact.type == COLOR else "what is the"
        end = "the one you mean?" if fact.type == COLOR else f"{fact.type} of the one you mean?"
        return [f"{what} {end}"]
    return []


def _which_suffixes(carries: bool) -> list[str]:
    return list(WH_SUFFIXES if carries else (WH_SUFFIXES[0], WH_SUFFIXES[3]))


def _note(decision: Decision) -> str:
    """Return what the person said and none of them is, or is not known to be."""
    if decision.reason == "no_match":
        return f", but no {without_article(decision.graph)}"
    if decision.reason == "unknown":
        any_ = "either" if len(decision.offered) == 2 else "any"
        return f", but I could not tell whether {any_} of them is {open_predicate(decision)}"
    return ""


def open_predicate(decision: Decision) -> str:
    """Return what was not observed of the instances that may be meant, in order of facts."""
    unknown = [f.said for one in decision.open for f in one.match.of("unknown")]
    return predicate([fact for fact in facts_of(decision.graph) if fact in unknown])


def _take(carries: bool) -> str:
    return " I take" if carries else ""


def _series(parts: list[str]) -> list[str]:
    """Return the parts so that only the last is joined with "and"."""
    return [", ".join(parts[:-1]), parts[-1]] if len(parts) > 1 else parts


def _echo(decision: Decision, ids: Sequence[str]) -> list[Fact]:
    """Return the self attributes that were said and hold of every one of these."""
    members = [one for one in decision.offered if one.candidate.id in ids]
    held = [seen_facts(one.match, "holds") for one in members]
    return [
        fact
        for fact in held[0]
        if not isinstance(fact, Relation) and all(fact in other for other in held)
    ]


def _part(group: Group, echo: list[Fact], *, alone: bool) -> Part:
    """Return the clause of a group; a sole group of twins is described by all own facts."""
    graph = graph_with(group.seen.name, unique([*echo, *facts_of(group.graph)]))
    if alone:
        place = place_of(group.seen)
        own = [fact for fact in facts_of(group.seen) if not isinstance(fact, Relation)]
        graph = graph_with(group.seen.name, [*own, *([place] if place else [])])
    return Part(group.ids, counted(graph, len(group.ids), other=group.other), graph)


def seen_facts(found: Match, verdict: str) -> list[Fact]:
    """Return what was observed for the facts with this verdict."""
    return [f.seen for f in found.findings if f.verdict == verdict and f.seen is not None]


def unique(facts: Sequence[Fact]) -> list[Fact]:
    """Return facts, each once, in order."""
    kept: list[Fact] = []
    for fact in facts:
        if fact not in kept:
            kept.append(fact)
    return kept
