"""The service: the core's handlers on the bus."""

from __future__ import annotations

from doro_dialogue.core import Dialogue
from doro_dialogue.settings import DialogueSettings
from doro_schemas.effects import Unanswered
from doro_schemas.messages import (
    Answer,
    Exploration,
    GridDelta,
    Instances,
    InstructionGraph,
    ParseReply,
)
from doro_schemas.runner import Shell, run_service


def wire(shell: Shell, settings: DialogueSettings) -> None:
    """Connect the core: instructions, exploration, deltas and answers in; map and parser
    are asked."""
    core = Dialogue(settings)
    shell.on(InstructionGraph, core.instruction_graph)
    shell.on(Exploration, core.exploration)
    shell.on(GridDelta, core.grid_delta)
    shell.on(Answer, core.answer)
    shell.on_reply(ParseReply, core.parse_reply)
    shell.on_reply(Instances, core.instances)
    shell.on_reply(Unanswered, core.unanswered)
    shell.counters(lambda: core.counters)


def main() -> None:
    """Run ``doro-dialogue`` until SIGTERM."""
    run_service("dialogue", DialogueSettings, wire)
