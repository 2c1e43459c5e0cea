"""Waits until the services that a play needs are alive."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable

from doro_schemas.bus import Bus
from doro_schemas.errors import Refused

CHECK_PERIOD_S = 0.5


class Presence:
    """Keeps the set of services that are alive, by their liveliness tokens."""

    def __init__(self, bus: Bus) -> None:
        self._bus = bus
        self.alive: set[str] = set()
        bus.watch_alive(self._changed)

    def wait_for(
        self,
        names: Iterable[str],
        timeout_s: float,
        given_up: Callable[[], bool] = lambda: False,
    ) -> None:
        """Wait until all of ``names`` are alive.

        Args:
            given_up: looked at every half second; true ends the wait early.

        Raises:
            Refused: some are not there in time; says which.
        """
        wanted = set(names)
        deadline_s = time.monotonic() + timeout_s
        while time.monotonic() < deadline_s and not self._bus.stopping:
            slice_s = min(deadline_s, time.monotonic() + CHECK_PERIOD_S)
            if self._bus.run_until(slice_s, lambda: wanted <= self.alive) or given_up():
                break
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
