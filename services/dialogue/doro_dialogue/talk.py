"""Messages made from a decision: Query with its evidence, and Belief."""

from __future__ import annotations

from collections.abc import Sequence

from doro_dialogue.decision import Decision, decide, paper_literal
from doro_dialogue.facts import Candidate
from doro_dialogue.question import Part, compose, pick
from doro_dialogue.settings import DialogueSettings
from doro_schemas.graph import ObjectGraph
from doro_schemas.messages import Belief, Clause, Evidence, Instance, Instances, Query, Target
from doro_schemas.messages.language import InstructionGraph

MAX_EVIDENCE = 3


def decide_on(graph: ObjectGraph, reply: Instances, settings: DialogueSettings) -> Decision:
    """Decide for the instances that the map knows."""
    candidates = [Candidate(one.instance_id, one.graph) for one in reply.instances]
    rule = paper_literal if settings.paper_literal else decide
    return rule(graph, candidates)


def query_of(
    decision: Decision,
    instruction: InstructionGraph,
    reply: Instances,
    settings: DialogueSettings,
    *,
    dialogue_id: str,
    episode: str,
) -> Query:
    """Return the Query, revision 0, without a stamp: its text, clauses and their evidence."""
    question = compose(decision, task=instruction.task, unseen_share=reply.unseen_share)
    return Query(
        episode=episode,
        dialogue_id=dialogue_id,
        instruction=instruction.text,
        input_graph=decision.graph,
        state=decision.state,
        reason=decision.reason,
        text=pick(question.wordings, settings.seed, dialogue_id),
        clauses=clauses_of(question.parts, reply.instances),
        matches=decision.matches,
        instances=decision.instances,
        unseen_share=reply.unseen_share,
        map_digest=reply.digest,
    )


def clauses_of(parts: Sequence[Part], instances: Sequence[Instance]) -> list[Clause]:
    """Return the clauses with the frames, boxes and cells that support them."""
    by_id = {one.instance_id: one for one in instances}
    return [_clause(part, [by_id[name] for name in part.instance_ids]) for part in parts]


def belief_of(decision: Decision, reply: Instances, dialogue_id: str, episode: str) -> Belief:
    """Return the Belief, without a stamp."""
    return Belief(
        episode=episode,
        dialogue_id=dialogue_id,
        state=decision.state,
        reason=decision.reason,
        matches=decision.matches,
        instances=decision.instances,
        frames_merged=reply.frames_merged,
    )


def targets_of(query: Query, ids: Sequence[str], reply: Instances) -> list[Target]:
    """Return where the instances are that the person means, in the order given."""
    by_id = {one.instance_id: one for one in reply.instances}
    return [
        Target(
            stamp_ns=query.stamp_ns,
            episode=query.episode,
            dialogue_id=query.dialogue_id,
            instance_id=name,
            graph=by_id[name].graph,
            position_m=by_id[name].position_m,
            extent_m=by_id[name].extent_m,
        )
        for name in ids
    ]


def same_decision(a: Query, b: Query) -> bool:
    """Tell whether two queries decide and name the same; wording and evidence aside."""
    return _substance(a) == _substance(b)


def _substance(query: Query) -> tuple[object, ...]:
    named = [(clause.instance_ids, clause.graph) for clause in query.clauses]
    return (query.state, query.reason, query.matches, query.instances, named)


def _clause(part: Part, instances: list[Instance]) -> Clause:
    return Clause(
        instance_ids=part.instance_ids,
        text=part.text,
        graph=part.graph,
        evidence=_strongest(instances),
        cells=[cell for one in instances for cell in one.cells],
    )


def _strongest(instances: list[Instance]) -> list[Evidence]:
    """Return up to three views, the strongest of every instance first."""
    deepest = max((len(one.evidence) for one in instances), default=0)
    views = [
        one.evidence[level]
        for level in range(min(deepest, MAX_EVIDENCE))
        for one in instances
        if level < len(one.evidence)
    ]
    return views[:MAX_EVIDENCE]
