"""``doro demo``: the whole chain on this host, from an instruction to a question."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path

import msgspec
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from doro_console.conversation import Conversation
from doro_console.options import Common, sample_recording, talk
from doro_console.processes import SERVICES, Processes, free_port
from doro_console.report import describe_graph, describe_query
from doro_schemas.bus import Bus
from doro_schemas.errors import Refused
from doro_schemas.messages import Health, Query
from doro_schemas.messages.base import Message
from doro_schemas.topics import TOPICS
from doro_sim_feeder.play import Player, PlayReport, PlaySettings
from doro_sim_feeder.presence import Presence
from doro_sim_feeder.recording import Recording

READY_TIMEOUT_S = 60.0
QUERY_TIMEOUT_S = 30.0
PICTURE_TIMEOUT_S = 15.0


class DemoSettings(msgspec.Struct, frozen=True, kw_only=True):
    """What the demo does.

    Attributes:
        recording: the room; None for the sample that comes with sim-feeder.
        instructions: said one after the other, the first one before the room is played.
        out: folder for the Rerun recording and the picture of the map.
        backend: perception's backend.
        as_json: print the queries as JSON lines on stdout instead of talk.
    """

    recording: Path | None
    instructions: tuple[str, ...]
    out: Path
    backend: str
    as_json: bool = False


def run_demo(common: Common, settings: DemoSettings) -> list[Query]:
    """Start the services, play the room, say the instructions; return the queries.

    Raises:
        Refused: a service did not start, or no query came.
    """
    settings.out.mkdir(parents=True, exist_ok=True)
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    with _recording(settings.recording) as path:
        recording = Recording(path)
        with Processes(_arguments(common, settings, endpoint)) as processes:
            try:
                queries = _converse(common, settings, endpoint, recording, processes.failed)
            except Refused as refused:
                raise Refused(f"{refused.reason}\n{processes.logs()}".strip()) from refused
    more = f" to map-{len(queries)}.png" if len(queries) > 1 else ""
    talk.print(f"\nmap:    {settings.out / 'map.png'}{more}")
    rrd = settings.out / "demo.rrd"
    talk.print(f"replay: {rrd} (open it with: .venv/bin/rerun {rrd})")
    return queries


def _arguments(common: Common, settings: DemoSettings, endpoint: str) -> list[str]:
    arguments = ["--config", str(common.config)] if common.config else []
    own = [
        f"bus.endpoint={endpoint}",
        "dialogue.state_dir=off",  # every run is the first
        f"perception.backend={settings.backend}",
        f"viewer.rrd={settings.out.resolve() / 'demo.rrd'}",
        f"viewer.png={settings.out.resolve() / 'map.png'}",
    ]
    for override in [*own, *common.overrides]:
        arguments += ["--set", override]
    return arguments


def _converse(
    common: Common,
    settings: DemoSettings,
    endpoint: str,
    recording: Recording,
    failed: Callable[[], bool],
) -> list[Query]:
    started_s = time.monotonic()
    bus = Bus("demo", common.bus_settings(endpoint=endpoint, open_timeout_s=READY_TIMEOUT_S))
    bus.stop_on_signals()
    with bus:
        Presence(bus).wait_for(SERVICES, READY_TIMEOUT_S, failed)
        talk.print(
            f"[dim]router and {len(SERVICES)} services ready after"
            f" {time.monotonic() - started_s:.1f} s: {', '.join(SERVICES)}[/dim]"
        )
        conversation = Conversation(bus)
        queries = []
        for number, text in enumerate(settings.instructions):
            _tell(conversation, text)
            if number == 0:
                report = _play(bus, recording)
                talk.print(
                    f"[dim]looked around {report.episode}: {report.merged} of {report.frames}"
                    f" frames merged in {report.elapsed_s:.1f} s[/dim]"
                )
            query = conversation.wait_for_query(number + 1, QUERY_TIMEOUT_S)
            if query is None:
                raise Refused(f"no query came within {QUERY_TIMEOUT_S:g} s for '{text}'")
            for line in [] if settings.as_json else describe_query(query):
                talk.print(line, markup=False)
            queries.append(query)
        _wait_for_pictures(bus, len(queries))
    return queries


def _wait_for_pictures(bus: Bus, count: int) -> None:
    """Wait until the viewer has drawn a picture for each query; it says so in its health."""
    drawn = 0

    def heard(message: Message) -> None:
        nonlocal drawn
        if isinstance(message, Health) and message.service == "viewer":
            drawn = message.counters.get("pictures", 0)

    bus.subscribe(TOPICS["health"], heard)
    if not bus.run_until(time.monotonic() + PICTURE_TIMEOUT_S, lambda: drawn >= count):
        talk.print(f"doro: only {drawn} of {count} pictures were drawn in time", style="yellow")


def _tell(conversation: Conversation, text: str) -> None:
    talk.print(f'\nperson: "{text}"', markup=False, style="bold")
    parsed = conversation.say(text)
    if parsed.graph is None:
        raise Refused(f"'{text}' was not understood: {parsed.reason}")
    talk.print(f"heard:  {describe_graph(parsed)}", markup=False)


def _play(bus: Bus, recording: Recording) -> PlayReport:
    total = max(
        [count for key, count in recording.counts.items() if key.endswith("/depth")], default=0
    )
    with Progress(
        TextColumn("        playing"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(),
        console=talk, transient=True,
    ) as progress:  # fmt: skip
        task = progress.add_task("frames", total=total)
        player = Player(
            bus, PlaySettings(), lambda _sent, merged: progress.update(task, completed=merged)
        )
        return player.play(recording)


def _recording(path: Path | None) -> AbstractContextManager[Path]:
    if path is not None:
        return nullcontext(path)
    return sample_recording()
