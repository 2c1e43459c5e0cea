"""True states and reference queries of the evaluation's instructions (paper, Section V).

The feeder knows what is true of a room, the dialogue service how that is decided and said;
only here do they meet.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import msgspec

from doro_dialogue.decision import decide
from doro_dialogue.facts import Candidate
from doro_dialogue.question import all_wordings
from doro_schemas.graph import ObjectGraph
from doro_sim_feeder.rooms.expressions import Expression, expressions, true_graph, visible
from doro_sim_feeder.rooms.make_set import RoomTruth


class Reference(msgspec.Struct, frozen=True):
    """A line of ``<recording>.references.jsonl``.

    Attributes:
        instruction, graph, task: what is said, as text and as its true input graph.
        state, reason: what is right to tell, by (n, m) on the visible instances.
        instances: object ids of the class (n); matches: those for which all holds (m).
        references: every wording of the query.
    """

    id: str
    episode: str
    object_type: str
    kind: str
    variant: str
    instruction: str
    task: str
    graph: ObjectGraph
    state: str
    reason: str
    instances: list[str]
    matches: list[str]
    about: str
    references: list[str]


def references(truth: RoomTruth) -> Iterator[Reference]:
    """Yield the instructions of a recording with their true states and wordings.

    Candidates are the instances seen in at least one view: a person who asks for what no
    view shows gets MISSING, and rightly so.
    """
    candidates = [Candidate(item.object_id, true_graph(item)) for item in visible(truth.instances)]
    for one in expressions(truth.episode, truth.instances):
        yield _reference(truth.episode, one, candidates)


def _reference(episode: str, one: Expression, candidates: list[Candidate]) -> Reference:
    decision = decide(one.graph, candidates)
    return Reference(
        id=one.id,
        episode=episode,
        object_type=one.object_type,
        kind=one.kind,
        variant=one.variant,
        instruction=one.text,
        task=one.task,
        graph=one.graph,
        state=decision.state,
        reason=decision.reason,
        instances=decision.instances,
        matches=decision.matches,
        about=one.about,
        references=all_wordings(decision, task=one.task),
    )


def write_references(folder: Path, truth: RoomTruth) -> int:
    """Write the lines beside a recording; return their number."""
    lines = [msgspec.json.encode(one) for one in references(truth)]
    path = folder / f"{truth.episode}.references.jsonl"
    part = path.with_suffix(".jsonl.part")
    part.write_bytes(b"".join(line + b"\n" for line in lines))
    part.replace(path)
    return len(lines)
