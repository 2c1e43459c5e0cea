"""Messages made from a decision: Query with its evidence, and Belief."""

from __future__ import annotations

from collections.abc import Sequence

from doro_dialogue.ask_reading import compose_read
from doro_dialogue.decision import Decision, decide, paper_literal
from doro_dialogue.facts import Candidate
from doro_dialogue.question import Part, pick
from doro_dialogue.readings import Read, decide_readings
from doro_dialogue.settings import DialogueSettings
from doro_schemas.graph import ObjectGraph
from doro_schemas.messages import Belief, Clause, Evidence, Instance, Instances, Query, Target
from doro_schemas.messages.language import InstructionGraph
from doro_schemas.messages.talk import SeenFrom

MAX_EVIDENCE = 3


def decide_on(
    readings: Sequence[ObjectGraph], reply: Instances, settings: DialogueSettings
) -> Read:
    """Decide for the instances that the map knows, over all readings of the instruction.

    The paper has one reading, and so has ``paper_literal``.
    """
    seen = candidates_of(reply)
    if settings.paper_literal:
        return Read(paper_literal(readings[0], seen))
    return decide_readings(readings, seen, decide)


def candidates_of(reply: Instances) -> list[Candidate]:
    """Return the instances of a reply as the decision sees them."""
    return [Candidate(one.instance_id, one.graph, tuple(one.evidence)) for one in reply.instances]


def query_of(
    read: Read,
    instruction: InstructionGraph,
    reply: Instances,
    settings: DialogueSettings,
    *,
    dialogue_id: str,
    episode: str,
) -> Query:
    """Return the Query, revision 0, without a stamp: its text, clauses and their evidence."""
    decision = read.decision
    question = compose_read(read, task=instruction.task, unseen_share=reply.unseen_share)
    return Query(
        episode=episode,
        dialogue_id=dialogue_id,
        instruction=instruction.text,
        input_graph=decision.graph,
        state=decision.state,
        reason=decision.reason,
        text=pick(question.wordings, settings.seed, dialogue_id) + _nameless(decision, reply),
        clauses=clauses_of(question.parts, reply.instances, question.seen_from),
        matches=decision.matches,
        instances=decision.instances,
        unseen_share=reply.unseen_share,
        map_digest=reply.digest,
        frames_merged=reply.frames_merged,
        person=instruction.person,
        seen_from=question.seen_from,
        also=clauses_of(question.also, reply.instances),
    )


def _nameless(decision: Decision, reply: Instances) -> str:
    """Return what is said besides of a missing thing: something there has no name."""
    count = len(reply.unnamed)
    if decision.state != "INFORM-MISSING" or decision.literal or not count:
        return ""
    return f" I also saw {'something' if count == 1 else f'{count} things'} that I cannot name."


def clauses_of(
    parts: Sequence[Part], instances: Sequence[Instance], seen_from: SeenFrom | None = None
) -> list[Clause]:
    """Return the clauses with the frames, boxes and cells that support them.

    Args:
        seen_from: the view that gives left and right; it stands first where a clause has it.
    """
    by_id = {one.instance_id: one for one in instances}
    return [
        Clause(
            instance_ids=part.instance_ids,
            text=part.text,
            graph=part.graph,
            evidence=_strongest([by_id[name] for name in part.instance_ids], seen_from),
            cells=[cell for name in part.instance_ids for cell in by_id[name].cells],
        )
        for part in parts
    ]


def belief_of(read: Read, reply: Instances, dialogue_id: str, episode: str) -> Belief:
    """Return the Belief, without a stamp."""
    decision = read.decision
    return Belief(
        episode=episode,
        dialogue_id=dialogue_id,
        state=decision.state,
        reason=decision.reason,
        matches=decision.matches,
        instances=decision.instances,
        frames_merged=reply.frames_merged,
        unseen_share=reply.unseen_share,
        confidence=confidence_of(read, reply),
    )


def confidence_of(read: Read, reply: Instances) -> float:
    """Return the lowest existence of the instances that a decision rests on; -1: none."""
    rests_on = read.decision.instances
    return min(
        (one.confidence for one in reply.instances if one.instance_id in rests_on), default=-1.0
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


def _strongest(instances: list[Instance], seen_from: SeenFrom | None) -> list[Evidence]:
    """Return up to three views, the strongest of every instance first."""
    deepest = max((len(one.evidence) for one in instances), default=0)
    views = [
        one.evidence[level]
        for level in range(deepest)
        for one in instances
        if level < len(one.evidence)
    ]
    if seen_from is not None:
        views.sort(key=lambda one: (one.camera, one.frame) != (seen_from.camera, seen_from.frame))
    return views[: max(MAX_EVIDENCE, len(instances))]
