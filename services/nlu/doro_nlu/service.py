"""The shell of nlu: which message goes to which handler."""

from __future__ import annotations

from doro_nlu.core import Nlu
from doro_nlu.settings import NluSettings
from doro_schemas.messages import FrameCaptions, Instruction, ParseRequest
from doro_schemas.runner import Shell, run_service


def wire(shell: Shell, settings: NluSettings) -> None:
    """Load and warm up the tagger, then subscribe.

    Of several processes one takes the streams, so that a text gives one graph; all of them
    answer the parser's queryable.
    """
    core = Nlu(settings)
    shell.on(Instruction, core.instruction, by_one=True)
    shell.on(FrameCaptions, core.captions, by_one=True)
    shell.answer(ParseRequest, core.parse)
    shell.counters(lambda: core.counters)


def main() -> None:
    """Run the service until it is told to stop."""
    run_service("nlu", NluSettings, wire)
