"""Real processes on loopback for the integration tests: a router and the services."""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType
from typing import Self

from doro_console.processes import free_port
from doro_schemas.bus import Bus, BusSettings
from doro_schemas.messages import GridRequest, GridSnapshot, Instruction, Query, Rejected
from doro_schemas.messages.base import Message
from doro_schemas.topics import TOPICS
from doro_sim_feeder.play import Player, PlayReport, PlaySettings
from doro_sim_feeder.presence import Presence
from doro_sim_feeder.recording import Recording

ROOT = Path(__file__).resolve().parents[2]
SAMPLE = ROOT / "sim-feeder" / "doro_sim_feeder" / "data" / "sample-kitchen.mcap"
BIN = Path(sys.executable).parent
CHAIN = ("nlu", "perception", "mapper", "dialogue")
READY_S = 60.0
QUERY_S = 60.0


class Chain:
    """A router and services, started in the given order, and a bus to talk to them."""

    def __init__(self, services: Sequence[str] = CHAIN, settings: Sequence[str] = ()) -> None:
        self.endpoint = f"tcp/127.0.0.1:{free_port()}"
        self.settings = BusSettings(endpoint=self.endpoint, open_timeout_s=READY_S)
        self._services = list(services)
        self._folder = tempfile.TemporaryDirectory(prefix="doro-chain-")
        self.state_dir = Path(self._folder.name)
        own = [f"bus.endpoint={self.endpoint}", f"dialogue.state_dir={self.state_dir}"]
        self._overrides = [*own, *settings]
        self.processes: dict[str, subprocess.Popen[str]] = {}
        self.bus = Bus("test", self.settings)
        self.queries: list[Query] = []
        self.rejected: list[Rejected] = []
        self._players = 0

    def __enter__(self) -> Self:
        try:
            self._start_all()
        except BaseException:
            self._stop_all()
            raise
        return self

    def _start_all(self) -> None:
        # Services come up in any order, the router may be the last.
        for name in [*self._services, *([] if "router" in self._services else ["router"])]:
            self.start(name)
        self.bus.open()
        self.bus.subscribe(TOPICS["query"], self._heard, late=False)
        self.bus.subscribe(TOPICS["rejected"], self._heard, late=False)
        self.presence = Presence(self.bus)
        self.presence.wait_for([name for name in self._services if name != "router"], READY_S)

    def _stop_all(self) -> dict[str, int]:
        """Stop everything; return the exit statuses."""
        self.bus.close()
        for process in self.processes.values():
            process.terminate()
        statuses = {name: process.wait(20) for name, process in self.processes.items()}
        self._folder.cleanup()
        return statuses

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        statuses = self._stop_all()
        if error is None:
            assert set(statuses.values()) == {0}, f"not all services stopped cleanly: {statuses}"

    def start(self, name: str) -> None:
        """Start a service (or the router) as a process."""
        command = [str(BIN / f"doro-{name}")]
        for override in self._overrides:
            command += ["--set", override]
        self.processes[name] = subprocess.Popen(command, stdin=subprocess.DEVNULL, text=True)

    def say(self, text: str) -> None:
        """Put an instruction."""
        self.bus.publish(Instruction(text=text, stamp_ns=1))

    def play(self, path: Path = SAMPLE, settings: PlaySettings | None = None) -> PlayReport:
        """Play a recording; lossless unless the settings say otherwise."""
        return Player(self.bus, settings or PlaySettings()).play(Recording(path))

    def query(self, count: int) -> Query:
        """Wait for ``count`` queries in all; return the last."""
        came = self.wait(lambda: len(self.queries) >= count, QUERY_S)
        assert came, f"{len(self.queries)} of {count} queries came: {self.queries}"
        return self.queries[-1]

    def rejection(self, count: int) -> Rejected:
        """Wait for ``count`` rejections in all; return the last."""
        came = self.wait(lambda: len(self.rejected) >= count, 10.0)
        assert came, f"{len(self.rejected)} of {count} rejections came: {self.rejected}"
        return self.rejected[-1]

    def wait(self, done, timeout_s: float) -> bool:  # type: ignore[no-untyped-def]
        """Handle what arrives until ``done()``."""
        return self.bus.run_until(time.monotonic() + timeout_s, done)

    def digest(self) -> str:
        """Return the digest of the mapper's map."""
        snapshot = self.bus.ask(GridRequest())
        assert isinstance(snapshot, GridSnapshot)
        return snapshot.digest

    def _heard(self, message: Message) -> None:
        if isinstance(message, Query):
            self.queries.append(message)
        elif isinstance(message, Rejected):
            self.rejected.append(message)
