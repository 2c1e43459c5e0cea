"""What is said: the paper's templates filled from a decision, in all wordings.

Nothing is named that was not observed; what the person said comes back only as what was
not found or could not be told.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from itertools import product

from doro_dialogue.decision import Decision, Judged
from doro_dialogue.facts import graph_with, name_of, place_of
from doro_dialogue.surface import counted, definite, indefinite, is_plural, plural, predicate
from doro_dialogue.which import ask_which, open_predicate, seen_facts, unique
from doro_dialogue.wording import (
    ACKNOWLEDGEMENTS,
    CARRYING,
    MISMATCH_SUFFIXES,
    WH_SUFFIXES,
    Part,
    Question,
)
from doro_schemas.graph import ObjectGraph, Relation

__all__ = ["Part", "Question", "all_wordings", "carries", "compose", "pick"]


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
        "INFORM-AMBIGUITY": lambda: ask_which(decision, carries(task)),
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
    also = [one.candidate for one in decision.open]
    return Question(
        [Part([chosen.candidate.id], what, graph)],
        wordings,
        also=[
            Part([one.id], counted(ObjectGraph(one.graph.name)), ObjectGraph(one.graph.name))
            for one in also
        ],
    )


def _as_said(chosen: Judged) -> ObjectGraph:
    """Return what was said as it was observed, with the place where no place was said."""
    facts = seen_facts(chosen.match, "holds")
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
    return f" I could not tell whether {others} {verb} {open_predicate(decision)}."


def _mismatch(decision: Decision, carries: bool) -> Question:
    """Say what was found and in what it differs from what was said."""
    only = decision.offered[0]
    seen, found = only.candidate.graph, only.match
    it, is_ = ("them", "they are") if is_plural(name_of(seen.name)) else ("it", "it is")
    held = unique([*seen_facts(found, "holds"), *seen_facts(found, "unknown")])
    differing = unique(seen_facts(found, "contradicted"))
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
