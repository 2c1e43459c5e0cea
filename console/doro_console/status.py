"""``doro status``: which services are alive, and their counters."""

from __future__ import annotations

import time

from rich.table import Table

from doro_console.processes import NEEDED
from doro_schemas.bus import Bus
from doro_schemas.messages import Health, ServiceStatus
from doro_schemas.messages.base import Message
from doro_schemas.topics import TOPICS


def gather(bus: Bus, seconds: float) -> list[ServiceStatus]:
    """Listen to liveliness and health for ``seconds``; return every service known, by name."""
    alive: dict[str, bool] = dict.fromkeys(NEEDED, False)
    health: dict[str, Health] = {}

    def heard(message: Message) -> None:
        if isinstance(message, Health):
            health[message.service] = message

    bus.watch_alive(lambda service, is_alive: alive.update({service: is_alive}))
    bus.subscribe(TOPICS["health"], heard)
    bus.run_until(
        time.monotonic() + seconds,
        lambda: bool(health) and {name for name, up in alive.items() if up} <= set(health),
    )
    return [ServiceStatus(name, alive[name], health.get(name)) for name in sorted(alive)]


def table(statuses: list[ServiceStatus]) -> Table:
    """Return the statuses as a table for people."""
    view = Table("service", "alive", "up", "received", "published", "refused", "lost", "stages")
    for status in statuses:
        health = status.health
        view.add_row(
            status.service,
            "[green]yes[/green]" if status.alive else "[red]no[/red]",
            "" if health is None else f"{health.uptime_s:.0f} s",
            *("" if health is None else _sum(health, kind) for kind in ("received", "published")),
            "" if health is None else _refused(health),
            "" if health is None else _lost(health),
            "" if health is None else _stages(health),
        )
    return view


def _sum(health: Health, kind: str) -> str:
    return str(sum(n for name, n in health.counters.items() if name.startswith(f"{kind}.")))


def _refused(health: Health) -> str:
    count = health.counters.get("rejected", 0)
    return f"{count}: {health.last_rejection}" if count else "0"


def _lost(health: Health) -> str:
    return str(
        sum(n for name, n in health.counters.items() if name.startswith(("dropped", "missed")))
    )


def _stages(health: Health) -> str:
    return "\n".join(
        f"{name} {timing.count}x, p50 {timing.p50_us / 1000:.2f} ms,"
        f" p99 {timing.p99_us / 1000:.2f} ms"
        for name, timing in health.stages.items()
    )
