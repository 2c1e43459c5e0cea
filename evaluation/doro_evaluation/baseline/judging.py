"""Is a text right? The rule of QA (``queries/judge.py``) for systems without positions.

Our own queries know where their instances are, so each is compared with its true one. A text has
words only, so it is judged in its favour: right is a text of the true state whose clauses can be
given to the true instances, each clause to as many as it counts, so that all that is said is
true of them; and which says at least as many different things as the truth can tell apart.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from doro_dialogue.decision import Decision
from doro_dialogue.facts import facts_of
from doro_dialogue.matching import match
from doro_dialogue.question import compose
from doro_evaluation.baseline.examples import caption_of
from doro_evaluation.baseline.reading import Clause, Parser, read_query
from doro_evaluation.queries.judge import Fault, Truth, Verdict
from doro_schemas.graph import ObjectGraph
from doro_schemas.vocabulary import name_satisfies

_STATE: Fault = "state"
_UNREAD: Fault = "not understood"


def judge_text(
    truth: Truth, true_input: ObjectGraph, task: str, text: str, parse: Parser
) -> Verdict:
    """Return the verdict on a text.

    Args:
        true_input: graph of what the instruction really says.
        parse: a noun phrase to its graph.
    """
    right = truth.decide(true_input)
    parts = compose(right, task=task).parts
    references = truth.wordings(right, task, 0.0)
    said = read_query(text, parse)
    if said.state != right.state:
        fault, why = _STATE, f"{said.state or 'no state'} for {right.state}"
    elif not said.understood:
        fault, why = _UNREAD, "a clause cannot be parsed"
    else:
        fault, why = _fault(truth, right, len(parts), said.clauses)
    return Verdict(fault, str(said.state), right.state, text, references, why)


def _fault(
    truth: Truth, right: Decision, parts: int, clauses: Sequence[Clause]
) -> tuple[Fault, str]:
    """Return what is wrong first, and in words; the true question has ``parts`` clauses."""
    if right.state == "INFORM-MISSING":
        return _missing_fault(right.graph, clauses)
    offered = [one.candidate.id for one in right.offered]
    count = sum(clause.count for clause in clauses)
    if count != len(offered):
        return "instances", f"{count} named, {len(offered)} are meant"
    slots = [clause.graph for clause in clauses for _ in range(clause.count)]
    fits = {
        number: [name for name in offered if _true_of(truth, graph, name)]
        for number, graph in enumerate(slots)
    }
    if untrue := next((slots[number] for number, names in fits.items() if not names), None):
        return "attributes", f"{caption_of(untrue)}: true of none"
    if not _assigned(fits):
        return "attributes", "two clauses are true of one instance only"
    return _told_apart(right, parts, clauses)


def _told_apart(right: Decision, parts: int, clauses: Sequence[Clause]) -> tuple[Fault, str]:
    """Return what is not said that should be, where all that is said is true."""
    if right.reason == "mismatch" and not _contradicts(right.graph, clauses):
        return "attributes", "what differs is not said"
    different = {(repr(clause.graph), clause.other) for clause in clauses}
    if len(different) < parts:
        return "attributes", f"{len(different)} different clauses, {parts} can be told apart"
    return "", ""


def _missing_fault(wanted: ObjectGraph, clauses: Sequence[Clause]) -> tuple[Fault, str]:
    """What could not be found is what was asked for, and nothing else."""
    for clause in clauses:
        if clause.graph.name != wanted.name:
            return "instances", f"{clause.graph.name} for {wanted.name}"
        if match(clause.graph, wanted).verdict != "holds":
            return "attributes", "not what was asked for"
    return "", ""


def _true_of(truth: Truth, said: ObjectGraph, object_id: str) -> bool:
    return name_satisfies(said.name, truth.graphs[object_id].name) and truth.holds(said, object_id)


def _contradicts(wanted: ObjectGraph, clauses: Sequence[Clause]) -> bool:
    """Tell whether a clause says in what the thing differs from what was wanted."""
    return any(
        facts_of(clause.graph) and match(wanted, clause.graph).verdict == "contradicted"
        for clause in clauses
    )


def _assigned(fits: Mapping[int, Sequence[str]]) -> bool:
    """Tell whether every slot can have an instance of its own (augmenting paths)."""
    owner: dict[str, int] = {}

    def place(slot: int, tried: set[str]) -> bool:
        for name in fits[slot]:
            if name not in tried:
                tried.add(name)
                if name not in owner or place(owner[name], tried):
                    owner[name] = slot
                    return True
        return False

    return all(place(slot, set()) for slot in fits)
