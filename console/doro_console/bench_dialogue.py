"""``doro bench dialogue``: the core's speed, and from instruction to query through the bus."""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import msgspec
import numpy as np
from rich.console import Console
from rich.table import Table

from doro_console.conversation import Conversation
from doro_console.options import sample_recording, talk
from doro_console.processes import free_port
from doro_evaluation.bench.dialogue import (
    TARGETS_MS,
    core_times_ms,
    instructions,
    run_core_bench,
)
from doro_evaluation.figures import Figure, write_figures
from doro_schemas.bus import Bus, BusSettings
from doro_schemas.errors import Refused
from doro_schemas.messages import Health, Instances, InstancesRequest, Instruction, InstructionGraph
from doro_schemas.messages.base import Message
from doro_schemas.topics import TOPICS
from doro_sim_feeder.play import Player, PlaySettings
from doro_sim_feeder.presence import Presence
from doro_sim_feeder.recording import Recording

SERVICES = ("nlu", "perception", "mapper", "dialogue")
READY_S = 60.0
QUERY_S = 10.0
WARM_UP = 5
BUS_TARGET_MS = 10.0
STOP_S = 20.0
AFTER_HEALTH_S = 5.0


def run_bench_dialogue(json_path: Path | None, count: int, scenes: int, through_bus: bool) -> None:
    """Measure, print a table, and write the figures as flat JSON where asked."""
    figures = run_core_bench(scenes)
    if through_bus:
        figures |= bench_bus(count)
    Console().print(_table(figures))
    write_figures(json_path, figures, f"doro bench dialogue --count {count} --scenes {scenes}")


class _Run(msgspec.Struct):
    """What a run through the services gives, milliseconds.

    Attributes:
        graph, query: from each instruction to its graph, and to its query.
        round_trip: of a request to the map; stages: the services' own p50.
        core: the dialogue's core, done again in process.
    """

    graph: list[float]
    query: list[float]
    round_trip: list[float]
    stages: dict[str, float]
    core: list[float]


def bench_bus(count: int) -> dict[str, Figure]:
    """Return the time from an instruction to its query, and where it goes, in milliseconds.

    Router, nlu, perception, mapper and dialogue run as processes on this host; the sample room
    is played first. Every sentence is another one, so that nlu has none of them ready. A second
    run, in which the dialogue keeps no state on disk, tells what that costs.

    Raises:
        Refused: a service did not start, or a query did not come.
    """
    with tempfile.TemporaryDirectory() as folder:
        run = _run(count, folder)
    off = _run(count, "off")
    (p50_ms, p99_ms), off_ms = np.percentile(run.query, [50, 99]), float(np.median(off.query))
    parts = {**off.stages, "dialogue": float(np.median(off.core))}
    measured = {
        "instruction_to_query_p50_ms": float(p50_ms),
        "instruction_to_query_p99_ms": float(p99_ms),
        "instruction_to_graph_p50_ms": float(np.median(run.graph)),
        "instances_round_trip_p50_ms": float(np.median(run.round_trip)),
        "without_state_p50_ms": off_ms,
        **{f"{name}_p50_ms": value for name, value in parts.items()},
        "rest_p50_ms": off_ms - sum(parts.values()),
        "state_p50_ms": float(p50_ms) - off_ms,
    }
    figures: dict[str, Figure] = {name: round(value, 4) for name, value in measured.items()}
    figures["queries"] = len(run.query)
    return {f"speed/dialogue/bus_{name}": value for name, value in figures.items()}


def _run(count: int, state_dir: str) -> _Run:
    sentences = instructions(count + WARM_UP)
    with running_services(state_dir) as bus, sample_recording() as sample:
        conversation = Conversation(bus)
        health = _Health(bus)
        talk.print(f"playing the sample room, state {'off' if state_dir == 'off' else 'kept'}")
        Player(bus, PlaySettings()).play(Recording(sample))
        times = [instruct(bus, conversation, text) for text in sentences][WARM_UP:]
        parsed = conversation.parsed[WARM_UP:]
        asked = [_ask(bus, one) for one in parsed]
        stages = health.after(count)
    return _Run(
        graph=[one for one, _ in times],
        query=[one for _, one in times],
        round_trip=[one for one, _ in asked],
        stages={"nlu": stages["nlu", "instruction"], "mapper": stages["mapper", "instances"]},
        core=core_times_ms([(one, reply) for one, (_, reply) in zip(parsed, asked, strict=True)]),
    )


def instruct(bus: Bus, conversation: Conversation, text: str) -> tuple[float, float]:
    """Return milliseconds from the instruction to its graph, and to its query."""
    graphs, queries = len(conversation.parsed), len(conversation.queries)
    started_s = time.perf_counter()
    instruction = Instruction(text=text, person=conversation.person, stamp_ns=time.time_ns())
    bus.publish(instruction)
    deadline_s = time.monotonic() + QUERY_S
    bus.run_until(deadline_s, lambda: len(conversation.parsed) > graphs)
    graph_s = time.perf_counter()
    bus.run_until(deadline_s, lambda: len(conversation.queries) > queries)
    ended_s = time.perf_counter()
    if len(conversation.queries) == queries:
        refused = f": {conversation.rejected[-1].reason}" if conversation.rejected else ""
        raise Refused(f"no query came within {QUERY_S:g} s for '{text}'{refused}")
    return (graph_s - started_s) * 1e3, (ended_s - started_s) * 1e3


def _ask(bus: Bus, parsed: InstructionGraph) -> tuple[float, Instances]:
    """Return the milliseconds of a request to the map, and its reply."""
    name = parsed.graph.name if parsed.graph is not None else ""
    started_s = time.perf_counter()
    reply = bus.ask(InstancesRequest(name=name))
    elapsed_ms = (time.perf_counter() - started_s) * 1e3
    if not isinstance(reply, Instances):
        raise Refused(f"the mapper did not answer for '{name}'")
    return elapsed_ms, reply


class _Health:
    """Keeps the services' own timings."""

    def __init__(self, bus: Bus) -> None:
        self._bus = bus
        self._latest: dict[str, Health] = {}
        bus.subscribe(TOPICS["health"], self._heard)

    def _heard(self, message: Message) -> None:
        if isinstance(message, Health):
            self._latest[message.service] = message

    def after(self, count: int) -> dict[tuple[str, str], float]:
        """Return p50 in milliseconds by (service, stage) once ``count`` were timed."""
        wanted = (("nlu", "instruction"), ("mapper", "instances"))

        def there() -> bool:
            return all(
                service in self._latest
                and stage in self._latest[service].stages
                and self._latest[service].stages[stage].count >= count
                for service, stage in wanted
            )

        if not self._bus.run_until(time.monotonic() + AFTER_HEALTH_S, there):
            raise Refused("nlu or mapper does not say what its stages took: see 'doro status'")
        return {
            (service, stage): self._latest[service].stages[stage].p50_us / 1e3
            for service, stage in wanted
        }


@contextmanager
def running_services(state_dir: str) -> Iterator[Bus]:
    """Run router and services on a free port; yield a bus to them."""
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    sets = [f"bus.endpoint={endpoint}", f"dialogue.state_dir={state_dir}"]
    with tempfile.TemporaryFile() as log:
        processes = [_start(name, sets, log.fileno()) for name in (*SERVICES, "router")]
        try:
            with Bus("bench", BusSettings(endpoint=endpoint, open_timeout_s=READY_S)) as bus:
                ended = [process for process in processes if process.poll() is not None]
                Presence(bus).wait_for(SERVICES, READY_S, lambda: bool(ended))
                yield bus
        except Refused as refused:
            log.seek(0)
            said = log.read().decode(errors="replace").strip()
            raise Refused(f"{refused.reason}\n{said}".strip()) from refused
        finally:
            _stop(processes)


def _start(name: str, sets: Sequence[str], log: int) -> subprocess.Popen[bytes]:
    command = [str(Path(sys.executable).parent / f"doro-{name}")]
    command += [word for one in sets for word in ("--set", one)]
    return subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=log, stderr=log)


def _stop(processes: Sequence[subprocess.Popen[bytes]]) -> None:
    for process in processes:
        process.terminate()
    for process in processes:
        try:
            process.wait(STOP_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def _table(figures: dict[str, Figure]) -> Table:
    wanted = {f"speed/dialogue/{name}_p50_ms": limit for name, limit in TARGETS_MS.items()}
    wanted["speed/dialogue/bus_instruction_to_query_p50_ms"] = BUS_TARGET_MS
    table = Table("figure", "ms", "wanted")
    for name, value in figures.items():
        if isinstance(value, float):
            limit = wanted.get(name)
            table.add_row(name, f"{value:.3f}", f"< {limit:g}" if limit else "")
    return table
