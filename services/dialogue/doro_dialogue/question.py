"""What is said: the paper's templates filled from a decision, in all wordings.

Nothing is named that was not observed; what the person said comes back only as what was
not found or could not be told.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from itertools import product

import msgspec

from doro_dialogue.decision import Decision, Judged
from doro_dialogue.discriminate import Group, discriminate
from doro_dialogue.facts import Fact, facts_of, graph_with, name_of, place_of, words
from doro_dialogue.matching import Match
from doro_dialogue.surface import (
    counted,
    definite,
    indefinite,
    is_plural,
    plural,
    predicate,
    without_article,
)
from doro_schemas.graph import ObjectGraph, Relation
from doro_schemas.messages.talk import SeenFrom

WH_SUFFIXES = (
    "which one do you mean?",
    "which one should I take?",
    "which one do you want?",
    "which one are you referring to?",
)
MISMATCH_SUFFIXES = ("Should I take {it}?", "Do you want {it}?", "Is that what you mean?")
ACKNOWLEDGEMENTS = ("Okay", "Sure", "Alright", "Got it")
CARRYING = words("bring take get fetch grab pick pass give hand carry collect retrieve deliver")
"""Tasks that "I will take it" answers; others get wordings that name no action."""


class Part(msgspec.Struct, frozen=True):
    """One clause: instances, words, and the graph with exactly the facts of the words."""

    instance_ids: list[str]
    text: str
    graph: ObjectGraph


class Question(msgspec.Struct, frozen=True):
    """A question or confirmation.

    Attributes:
        parts: its clauses, in order.
        wordings: every wording, in a fixed order, the plainest first.
        seen_from: the view in which left and right are meant; None where no side is named.
        also: instances that it mentions without offering them.
    """

    parts: list[Part]
    wordings: list[str]
    seen_from: SeenFrom | None = None
    also: list[Part] = []


def compose(decision: Decision, *, task: str = "", unseen_share: float = 0.0) -> Question:
    """Return the clauses and all wordings for a decision.

    Args:
        task: verb phrase of the instruction ("bring"); empty counts as a carrying task.
        unseen_share: share of the area not observed, 0..1; 0 says nothing about it.
    """
    if decision.literal:
        return _literal(decision)
    build: dict[str, Callable[[], Question]] = {
        "CONFIRM": lambda: _confirm(decision, carries(task)),
        "INFORM-MISMATCH": lambda: _mismatch(decision, carries(task)),
        "INFORM-AMBIGUITY": lambda: _ambiguity(decision, carries(task)),
        "INFORM-MISSING": lambda: _missing(decision, unseen_share),
    }
    return build[decision.state]()


def all_wordings(decision: Decision, *, task: str = "", unseen_share: float = 0.0) -> list[str]:
    """Return every text that may be said for a decision (references for scoring)."""
    return compose(decision, task=task, unseen_share=unseen_share).wordings


def pick(wordings: Sequence[str], seed: int, key: str) -> str:
    """Return the wording for a seed and a dialogue id: the same on every machine and run."""
    digest = hashlib.sha256(f"{seed}:{key}".encode()).digest()
    return wordings[int.from_bytes(digest[:8], "big") % len(wordings)]


def carries(task: str) -> bool:
    """Tell whether "I will take it" answers a task; an empty one counts."""
    first = task.strip().lower().split(" ")[0]
    return not first or first in CARRYING


def _confirm(decision: Decision, carries: bool) -> Question:
    """Acknowledge, and say which one; what else might be meant is not kept silent."""
    chosen = decision.offered[0]
    graph = _as_said(chosen)
    what = definite(graph)
    middle = ("I will take {}",) if carries else ("it is {}", "I found {}")
    rest = _cannot_tell_others(decision)
    wordings = [
        f"{word}, {form.format(what)}.{rest}" for word, form in product(ACKNOWLEDGEMENTS, middle)
    ]
    return Question([Part([chosen.candidate.id], what, graph)], wordings)


def _as_said(chosen: Judged) -> ObjectGraph:
    """Return what was said as it was observed, with the place where no place was said."""
    facts = _seen(chosen.match, "holds")
    place = place_of(chosen.candidate.graph)
    if place is not None and not any(isinstance(fact, Relation) for fact in facts):
        facts.append(place)
    return graph_with(chosen.candidate.graph.name, facts)


def _cannot_tell_others(decision: Decision) -> str:
    count = len(decision.open)
    if not count:
        return ""
    name = name_of(decision.graph.name)
    others = f"another {name}" if count == 1 else f"{counted(ObjectGraph(name=name), count)}"
    others = others if count == 1 else others.replace(" ", " other ", 1)
    verb = "is" if count == 1 and not is_plural(name) else "are"
    return f" I could not tell whether {others} {verb} {_open_predicate(decision)}."


def _open_predicate(decision: Decision) -> str:
    """Return what was not observed of the instances that may be meant, in order of facts."""
    unknown = [f.said for one in decision.open for f in one.match.of("unknown")]
    return predicate([fact for fact in facts_of(decision.graph) if fact in unknown])


def _mismatch(decision: Decision, carries: bool) -> Question:
    """Say what was found and in what it differs from what was said."""
    only = decision.offered[0]
    seen, found = only.candidate.graph, only.match
    it, is_ = ("them", "they are") if is_plural(name_of(seen.name)) else ("it", "it is")
    held = _unique([*_seen(found, "holds"), *_seen(found, "unknown")])
    differing = _unique(_seen(found, "contradicted"))
    place = place_of(seen)
    if not differing and place and not any(isinstance(fact, Relation) for fact in held):
        held.append(place)
    # What differs is said once, as what differs.
    held = [fact for fact in held if fact not in differing]
    but = [f"{is_} {predicate(differing)}"] if differing else []
    unknown = [finding.said for finding in found.of("unknown")]
    if unknown:
        whether = is_.split(" ")
        but.append(f"I could not tell whether {' '.join(whether)} {predicate(unknown)}")
    what = counted(graph_with(seen.name, held))
    suffixes = MISMATCH_SUFFIXES if carries else MISMATCH_SUFFIXES[-1:]
    text = f"I found {what}, but {', and '.join(but)}."
    clause = f"{what}, but {is_} {predicate(differing)}" if differing else what
    part = Part([only.candidate.id], clause, graph_with(seen.name, [*held, *differing]))
    return Question([part], [f"{text} {suffix.format(it=it)}" for suffix in suffixes])


def _ambiguity(decision: Decision, carries: bool) -> Question:
    """Name each candidate by what sets it apart, and ask which.

    The own words of the person come along where they hold ("one red cup on top of the
    table" for "the red cup"): without them it is not said that these are red.
    """
    groups = discriminate([one.candidate for one in decision.offered])
    parts = [_part(group, _echo(decision, group), alone=len(groups) == 1) for group in groups]
    clauses = ", and ".join(_series([part.text for part in parts]))
    note = ""
    if decision.reason == "no_match":
        note = f", but no {without_article(decision.graph)}"
    elif decision.reason == "unknown":
        any_ = "either" if len(decision.offered) == 2 else "any"
        note = f", but I could not tell whether {any_} of them is {_open_predicate(decision)}"
    suffixes = list(WH_SUFFIXES if carries else (WH_SUFFIXES[0], WH_SUFFIXES[3]))
    if len(groups) == 1:
        either = "either" if len(groups[0].ids) == 2 else "any"
        suffixes = [f"is {either} of them fine?", f"does it matter which one{_take(carries)}?"]
    return Question(parts, [f"I found {clauses}{note}; {suffix}" for suffix in suffixes])


def _take(carries: bool) -> str:
    return " I take" if carries else ""


def _series(parts: list[str]) -> list[str]:
    """Return the parts so that only the last is joined with "and"."""
    return [", ".join(parts[:-1]), parts[-1]] if len(parts) > 1 else parts


def _echo(decision: Decision, group: Group) -> list[Fact]:
    """Return the self attributes that were said and hold of every member of a group."""
    members = [one for one in decision.offered if one.candidate.id in group.ids]
    held = [_seen(one.match, "holds") for one in members]
    return [
        fact
        for fact in held[0]
        if not isinstance(fact, Relation) and all(fact in other for other in held)
    ]


def _part(group: Group, echo: list[Fact], alone: bool) -> Part:
    """Return the clause of a group; a sole group of twins is described by all own facts."""
    graph = graph_with(group.seen.name, _unique([*echo, *facts_of(group.graph)]))
    if alone:
        place = place_of(group.seen)
        own = [fact for fact in facts_of(group.seen) if not isinstance(fact, Relation)]
        graph = graph_with(group.seen.name, [*own, *([place] if place else [])])
    return Part(group.ids, counted(graph, len(group.ids), other=group.other), graph)


def _missing(decision: Decision, unseen_share: float) -> Question:
    """Say that it was not found, and how much was not seen."""
    percent = int(unseen_share * 100 + 0.5)
    share = f"about {percent} %" if percent >= 1 else "less than 1 %"
    tail = f"; {share} of the area has not been seen" if unseen_share > 0 else ""
    name = name_of(decision.graph.name)
    none = name if indefinite(ObjectGraph(name=name)).startswith("any ") else plural(name)
    none = name if is_plural(name) else none
    stems = (
        f"I could not find {indefinite(decision.graph)}",
        f"I could not find that, and saw no {none} at all",
    )
    return Question([], [f"{stem}{tail}." for stem in stems])


def _literal(decision: Decision) -> Question:
    """Fill the paper's templates with whole graphs, as printed."""
    judged = decision.offered
    if decision.state == "INFORM-MISSING":
        return Question([], ["I could not find that."])
    parts = [
        Part([one.candidate.id], counted(one.candidate.graph), one.candidate.graph)
        for one in judged
    ]
    if decision.state == "CONFIRM":
        return Question(parts, [f"{word}." for word in ACKNOWLEDGEMENTS])
    clauses = ", and ".join(part.text for part in parts)
    if decision.state == "INFORM-MISMATCH":
        wordings = [f"I found {clauses}. {s.format(it='it')}" for s in MISMATCH_SUFFIXES]
        return Question(parts, wordings)
    return Question(parts, [f"I found {clauses}; {suffix}" for suffix in WH_SUFFIXES])


def _seen(found: Match, verdict: str) -> list[Fact]:
    """Return what was observed for the facts with this verdict."""
    return [f.seen for f in found.findings if f.verdict == verdict and f.seen is not None]


def _unique(facts: Sequence[Fact]) -> list[Fact]:
    kept: list[Fact] = []
    for fact in facts:
        if fact not in kept:
            kept.append(fact)
    return kept
