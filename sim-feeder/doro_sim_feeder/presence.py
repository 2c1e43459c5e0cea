"""Waits until the services that a play needs are alive."""

from __future__ import annotations

import time
from collections.abc import Iterable

from doro_schemas.bus import Bus
from doro_schemas.errors import Refused


class Presence:
    """Keeps the set of services that are alive, by their liveliness tokens."""

    def __init__(self, bus: Bus) -> None:
        self._bus = bus
        self.alive: set[str] = set()
        bus.watch_alive(self._changed)

    def wait_for(self, names: Iterable[str], timeout_s: float) -> None:
        """Wait until all of ``names`` are alive.

        Raises:
            Refused: some are not there in time; says which.
        """
        wanted = set(names)
        self._bus.run_until(time.monotonic() + timeout_s, lambda: wanted <= self.alive)
        missing = sorted(wanted - self.alive)
        if missing:
            raise Refused(
                f"not running on this router: {', '.join(f'doro-{name}' for name in missing)};"
                " start all services with 'doro up'"
            )

    def _changed(self, service: str, is_alive: bool) -> None:
        if is_alive:
            self.alive.add(service)
        else:
            self.alive.discard(service)
