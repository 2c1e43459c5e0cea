"""The service: the core's handlers on the bus."""

from __future__ import annotations

from pathlib import Path

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
from doro_schemas.statefile import StateFile, default_folder, file_name

STATE = "doro.DialogueState"
OFF = "off"
TICK_S = 1.0


def wire(shell: Shell, settings: DialogueSettings) -> None:
    """Connect the core: instructions, exploration, deltas, answers and time in; map and parser
    are asked; its state is kept over restarts."""
    core = Dialogue(settings)
    if settings.state_dir != OFF:
        folder = Path(settings.state_dir).expanduser() if settings.state_dir else default_folder()
        bus = shell.bus_settings
        file = StateFile(folder / file_name("dialogue", bus.namespace, bus.endpoint), STATE)
        shell.keep(file, core.snapshot, core.restore)
    shell.every(TICK_S, core.tick)
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
