"""The same pair in process and through the running services: the same query?

In process: error models, perception's oracle, nlu, mapper and the dialogue's own functions, one
after the other. Live: a player, four services and a router as processes, msgpack on the bus.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import msgspec

from doro_dialogue.settings import DialogueSettings
from doro_dialogue.talk import decide_on, query_of
from doro_evaluation.chain import ERROR_MODELS, Language, load_room, run_mapper
from doro_evaluation.context import Context
from doro_evaluation.figures import Figure
from doro_mapper.core import Mapper
from doro_nlu.core import Nlu
from doro_schemas.messages import InstancesRequest, Instruction, InstructionGraph, Query

COMPARED = ("text", "state", "reason", "matches", "instances", "clauses", "seen_from", "also")
"""What of a query has to be equal; stamps and names of dialogues are the bus' own."""


class Compared(msgspec.Struct, frozen=True):
    """A pair and the fields in which its two queries differ."""

    recording: str
    instruction: str
    live: str
    in_process: str
    differences: tuple[str, ...]


class InProcess:
    """A recording's map and the dialogue's decision on it, without a bus."""

    def __init__(self, path: Path, errors: str, context: Context, language: Language) -> None:
        room = load_room(path)
        graphs = language.graphs(room, ERROR_MODELS[errors], context.seed)
        self._mapper: Mapper = run_mapper(room, graphs, context.mapper)
        self._nlu = Nlu(context.nlu)
        self._episode = room.episode

    def query(self, instruction: str, dialogue_id: str) -> Query | None:
        """Return the query; None where the instruction is not understood."""
        said = Instruction(text=instruction, stamp_ns=1)
        parsed = next(o for o in self._nlu.instruction(said) if isinstance(o, InstructionGraph))
        if parsed.graph is None:
            return None
        readings = [parsed.graph, *parsed.readings]
        reply = self._mapper.instances(InstancesRequest(name=parsed.graph.name))
        settings = DialogueSettings()
        return query_of(
            decide_on(readings, reply, settings), parsed, reply, settings,
            dialogue_id=dialogue_id, episode=self._episode,
        )  # fmt: skip


def differences(live: Query, own: Query | None) -> tuple[str, ...]:
    """Return the fields in which two queries differ."""
    if own is None:
        return ("understood",)
    return tuple(name for name in COMPARED if getattr(live, name) != getattr(own, name))


def figures_of(found: Sequence[Compared]) -> dict[str, Figure]:
    """Return ``live/ours/pairs`` and ``live/ours/same_query``, the number of equal ones."""
    return {
        "live/ours/pairs": len(found),
        "live/ours/same_query": sum(not one.differences for one in found),
    }
