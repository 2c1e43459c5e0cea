"""The thin shell around a service's core: settings, bus, liveliness, health, clean stop."""

from __future__ import annotations

import argparse
import sys
import time
from collections import deque
from collections.abc import Callable, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any, TypeVar

from doro_schemas.bus import Bus, BusSettings, Request
from doro_schemas.effects import Ask, Output, Unanswered
from doro_schemas.errors import Refused
from doro_schemas.kept import Due, Kept
from doro_schemas.messages.base import Message
from doro_schemas.messages.control import Health, StageTiming
from doro_schemas.settings import load_settings
from doro_schemas.statefile import StateFile
from doro_schemas.topics import topic_of

M = TypeVar("M", bound=Message)
S = TypeVar("S")
Handler = Callable[[Any], list[Output]]
TIMING_WINDOW = 1024
SYNC_S = 1.0


class Shell:
    """Connects a core's handlers to the bus and carries out what they return."""

    def __init__(self, bus: Bus) -> None:
        self._bus = bus
        self._replies: dict[type[Message], Handler] = {}
        self._counters: list[Callable[[], dict[str, int]]] = []
        self._on_stop: list[Callable[[], None]] = []
        self._timings: dict[str, deque[float]] = {}
        self._counts: dict[str, int] = {}
        self._started_s = time.monotonic()
        self._due: list[Due] = []
        self._kept: Kept | None = None
        self._first: list[Output] = []

    @property
    def bus_settings(self) -> BusSettings:
        """The settings of the bus: endpoint and namespace."""
        return self._bus.settings

    def every(self, period_s: float, handler: Callable[[int], list[Output]]) -> None:
        """Call a handler with the time (Unix nanoseconds) every so often while running.

        A core reads no clock: the time comes in as an argument, so that a test or a replay
        gives it the same one again.
        """
        self._due.append(Due(period_s, handler, time.monotonic()))

    def keep(
        self,
        file: StateFile,
        snapshot: Callable[[], bytes],
        restore: Callable[[bytes], list[Output]],
    ) -> None:
        """Keep a core's state over restarts: load it now, write it after every message.

        Args:
            file: where; a damaged one is refused with a sentence, and the core starts afresh.
            snapshot: the core's state as bytes.
            restore: takes such bytes back; returns what is to be done first, once running.
        """
        self._kept = Kept(file, snapshot)
        try:
            self._first = self._kept.load(restore)
        except Refused as refused:
            self._bus.reject(str(file.path), refused)

    def on(
        self,
        kind: type[M],
        handler: Callable[[M], list[Output]],
        *,
        late: bool = True,
        by_one: bool = False,
        newest: bool = False,
    ) -> None:
        """Give every message of a type to a handler; see :meth:`Bus.subscribe` for ``late``.

        Args:
            by_one: several processes of the service may run; one of them handles the message.
            newest: when slower than a live camera, take its newest frame; the others are counted
                as ``dropped``. A replay, which waits, loses none.
        """
        topic = topic_of(kind)
        self._bus.subscribe(
            topic,
            lambda message: self._timed(topic.name, handler, message),
            late=late,
            by_one=by_one,
            newest=newest,
        )

    def answer(self, kind: type[M], handler: Callable[[M], Message]) -> None:
        """Answer every request of a type with the handler's message."""
        topic = topic_of(kind)

        def respond(request: Request) -> None:
            started = time.perf_counter()
            reply = handler(request.message)  # type: ignore[arg-type]
            request.reply(reply)
            self._note(topic.name, time.perf_counter() - started)

        self._bus.answer(topic, respond)

    def on_reply(self, kind: type[M], handler: Callable[[M], list[Output]]) -> None:
        """Give the replies of a type, or :class:`Unanswered`, to a handler."""
        self._replies[kind] = handler

    def counters(self, read: Callable[[], dict[str, int]]) -> None:
        """Merge the core's counters into health."""
        self._counters.append(read)

    def on_stop(self, action: Callable[[], None]) -> None:
        """Do something at the clean stop."""
        self._on_stop.append(action)

    def run(self) -> None:
        """Announce the service and handle what arrives until it is stopped."""
        self._bus.declare_alive()
        health = Due(self._bus.settings.health_period_s, self._publish_health, time.monotonic())
        due = [health, Due(SYNC_S, self._sync, time.monotonic()), *self._due]
        self._publish_health(0)
        self._guarded("start", self._first)
        while not self._bus.stopping:
            self._bus.run_until(min(one.next_s for one in due))
            for one in due:
                if not self._bus.stopping and one.take(time.monotonic()):
                    self._guarded("tick", lambda one=one: one.handler(time.time_ns()))  # type: ignore[misc]
        for action in self._on_stop:
            action()
        self._guarded("state", lambda: self._sync(0))
        self._bus.publish(self.health())

    def health(self) -> Health:
        """Return the counters and timings so far."""
        counters = dict(self._bus.counters)
        for read in self._counters:
            counters.update(read())
        return Health(
            service=self._bus.name,
            version=version("doro-schemas"),
            stamp_ns=time.time_ns(),
            uptime_s=time.monotonic() - self._started_s,
            counters=dict(sorted(counters.items())),
            stages={name: self._timing(name) for name in sorted(self._timings)},
            last_rejection=self._bus.last_rejection,
        )

    def _timed(self, stage: str, handler: Handler, message: Message) -> None:
        started = time.perf_counter()
        outputs = handler(message)
        self._note(stage, time.perf_counter() - started)
        self._carry_out(outputs)

    def _guarded(self, key: str, work: list[Output] | Callable[[], list[Output]]) -> None:
        """Do what no message caused; a refusal is told as one of a message is."""
        try:
            self._carry_out(work() if callable(work) else work)
        except Refused as refused:
            self._bus.reject(key, refused)

    def _publish_health(self, _now_ns: int) -> list[Output]:
        self._bus.publish(self.health())
        return []

    def _carry_out(self, outputs: list[Output]) -> None:
        """Publish messages; put requests and handle their replies, until nothing is left.

        Where a state is kept, it is written before anything is said that rests on it.
        """
        waiting = deque(outputs)
        self._save(waiting)
        while waiting:
            output = waiting.popleft()
            if isinstance(output, Ask):
                reply = self._ask(output.request)
                waiting.extend(self._replies[type(reply)](reply))
                self._save(waiting)
            else:
                self._bus.publish(output)
        self._save(())

    def _save(self, outputs: Sequence[Output]) -> None:
        if self._kept is None:
            return
        try:
            self._kept.save(outputs)
        except Refused as refused:
            self._bus.reject("state", refused)

    def _sync(self, _now_ns: int) -> list[Output]:
        """Bring the state to the disk, once a second: to wait for it costs a message 10 ms."""
        if self._kept is not None:
            self._kept.sync()
        return []

    def _ask(self, request: Message) -> Message:
        topic = topic_of(type(request))
        reply = self._bus.ask(request)
        if reply is not None:
            return reply
        self._bus.counters[f"unanswered.{topic.name}"] += 1
        timeout_s = self._bus.settings.ask_timeout_s
        return Unanswered(
            request=request,
            stamp_ns=request.stamp_ns,
            episode=request.episode,
            reason=f"nobody answered {topic.key} within {timeout_s:g} s: is {topic.receiver} up?",
        )

    def _note(self, stage: str, seconds: float) -> None:
        self._timings.setdefault(stage, deque(maxlen=TIMING_WINDOW)).append(seconds * 1e6)
        self._counts[stage] = self._counts.get(stage, 0) + 1

    def _timing(self, stage: str) -> StageTiming:
        ordered = sorted(self._timings[stage])
        return StageTiming(
            count=self._counts[stage],
            p50_us=ordered[len(ordered) // 2],
            p99_us=ordered[min(len(ordered) - 1, int(len(ordered) * 0.99))],
        )


def parse_arguments(name: str, arguments: Sequence[str] | None) -> tuple[Path | None, list[str]]:
    """Return (settings file, overrides) of a service's command line."""
    parser = argparse.ArgumentParser(prog=f"doro-{name}")
    parser.add_argument("--config", type=Path, help="settings file (TOML), a table per service")
    parser.add_argument("--set", action="append", default=[], metavar="TABLE.KEY=VALUE")
    parsed = parser.parse_args(arguments)
    return parsed.config, parsed.set


def run_service(
    name: str,
    settings_type: type[S],
    wire: Callable[[Shell, S], None],
    arguments: Sequence[str] | None = None,
) -> None:
    """Run a service until SIGTERM: the body of every ``doro-<name>`` command.

    Args:
        name: the service's name and its table in the settings file.
        settings_type: msgspec Struct of its settings.
        wire: builds the core, warms it up and connects its handlers.
    """
    path, overrides = parse_arguments(name, arguments)
    try:
        settings = load_settings(name, settings_type, path, overrides)
        bus_settings = load_settings("bus", BusSettings, path, overrides)
        bus = Bus(name, bus_settings)
        bus.stop_on_signals()
        with bus:
            shell = Shell(bus)
            wire(shell, settings)
            shell.run()
    except Refused as refused:
        sys.exit(f"doro-{name}: {refused.reason}")
