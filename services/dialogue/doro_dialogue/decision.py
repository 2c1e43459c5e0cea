"""The decision by (n, m), and the paper's own formulas beside it (Section IV-C)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import msgspec

from doro_dialogue.facts import Candidate, check_depth, name_of, natural_order, value_of
from doro_dialogue.matching import Match, compare_name, match
from doro_schemas.errors import Refused
from doro_schemas.graph import ObjectGraph
from doro_schemas.messages.talk import State

Reason = Literal[
    "unique_match", "several_match", "no_match", "mismatch", "unknown", "missing", "readings"
]


class Judged(msgspec.Struct, frozen=True):
    """An instance of the class and how what was said stands to it."""

    candidate: Candidate
    match: Match


class Decision(msgspec.Struct, frozen=True):
    """What is to be told or asked.

    Attributes:
        graph: the input graph.
        state: one of the paper's four.
        reason: why this state.
        judged: all instances of the class (n), in natural order of their ids.
        offered: those that the question is about.
        literal: decided by the paper's formulas.
    """

    graph: ObjectGraph
    state: State
    reason: Reason
    judged: list[Judged]
    offered: list[Judged]
    literal: bool = False

    @property
    def matches(self) -> list[str]:
        """Ids of the instances for which all that was said holds (m)."""
        return [one.candidate.id for one in self.judged if one.match.verdict == "holds"]

    @property
    def instances(self) -> list[str]:
        """Ids of all instances of the class."""
        return [one.candidate.id for one in self.judged]

    @property
    def open(self) -> list[Judged]:
        """Instances that may be meant: nothing contradicts, something was not observed."""
        return [one for one in self.judged if one.match.verdict == "unknown"]


def decide(graph: ObjectGraph, instances: Sequence[Candidate]) -> Decision:
    """Decide by n (instances of the class) and m (those for which all that was said holds).

    n=0 INFORM-MISSING; m=1 CONFIRM; m>=2 INFORM-AMBIGUITY among the matches; m=0 and n=1
    INFORM-MISMATCH; m=0 and n>=2 INFORM-AMBIGUITY. The order of the instances does not
    matter, nor do instances of other classes. What was never observed counts as no match.

    Raises:
        Refused: a graph nests too deep, or two instances have one id.
    """
    judged = _judge(graph, instances)
    matched = [one for one in judged if one.match.verdict == "holds"]
    may_be = any(one.match.verdict == "unknown" for one in judged)
    if not judged:
        return Decision(graph, "INFORM-MISSING", "missing", [], [])
    if len(matched) == 1:
        return Decision(graph, "CONFIRM", "unique_match", judged, matched)
    if matched:
        return Decision(graph, "INFORM-AMBIGUITY", "several_match", judged, matched)
    if len(judged) == 1:
        reason: Reason = "unknown" if may_be else "mismatch"
        return Decision(graph, "INFORM-MISMATCH", reason, judged, judged)
    reason = "unknown" if may_be else "no_match"
    return Decision(graph, "INFORM-AMBIGUITY", reason, judged, judged)


def paper_literal(graph: ObjectGraph, instances: Sequence[Candidate]) -> Decision:
    """Decide by the paper's formulas as printed.

    {Ig'} holds the non-empty set differences g - Ig_i, one for each instance. No instance:
    INFORM-MISSING; {Ig'} empty: CONFIRM; one: INFORM-MISMATCH; more: INFORM-AMBIGUITY. The
    differences are over nodes with their paths, token by token: two-valued, without synonyms.
    """
    judged = _judge(graph, instances)
    said = _nodes(graph, ())
    differing = [one for one in judged if not said <= _nodes(one.candidate.graph, ())]
    literal = [Judged(one.candidate, _two_valued(one.match, one in differing)) for one in judged]
    offered = [one for one in literal if one.match.verdict != "holds"]
    if not judged:
        return Decision(graph, "INFORM-MISSING", "missing", [], [], literal=True)
    if not offered:
        reason: Reason = "unique_match" if len(judged) == 1 else "several_match"
        return Decision(graph, "CONFIRM", reason, literal, literal, literal=True)
    if len(offered) == 1:
        return Decision(graph, "INFORM-MISMATCH", "mismatch", literal, offered, literal=True)
    return Decision(graph, "INFORM-AMBIGUITY", "no_match", literal, offered, literal=True)


def _judge(graph: ObjectGraph, instances: Sequence[Candidate]) -> list[Judged]:
    check_depth(graph, "the instruction")
    ids: set[str] = set()
    for one in instances:
        check_depth(one.graph, f"instance '{one.id}'")
        if one.id in ids:
            raise Refused(f"two instances have the id '{one.id}': give each its own")
        ids.add(one.id)
    of_class = [one for one in instances if compare_name(graph.name, one.graph.name) == "holds"]
    return [Judged(one, match(graph, one.graph)) for one in natural_order(of_class)]


def _nodes(graph: ObjectGraph, path: tuple[str, ...]) -> set[tuple[str, ...]]:
    """Return the nodes below the root with their paths; for membership only, never output."""
    nodes = {(*path, key, value_of(value)) for key, value in graph.attributes.items()}
    for relation in graph.relations:
        below = (*path, relation.type, name_of(relation.target.name))
        nodes |= {below} | _nodes(relation.target, below)
    return nodes


def _two_valued(found: Match, differs: bool) -> Match:
    return Match("contradicted" if differs else "holds", found.findings)
