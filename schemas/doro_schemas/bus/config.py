"""Zenoh's configuration: measured defaults for one host, or a JSON5 file."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import msgspec

from doro_schemas.errors import Refused

LOOPBACK = "tcp/127.0.0.1:7447"
_LINK = {"tx": {"queue": {"size": {"data": 16}}}, "rx": {"buffer_size": 4 << 20}}


class BusSettings(msgspec.Struct, frozen=True, kw_only=True):
    """The table ``[bus]`` of the settings file.

    Attributes:
        endpoint: the router's locator; the router listens there, services connect to it.
        namespace: prefix of all keys, one per robot; empty for none.
        config: JSON5 file that replaces the built-in Zenoh configuration of a service.
        router_config: the same for the router.
        shared_memory_mb: large messages between processes of one host go through a pool of
            shared memory of this size, one per publishing process; 0 turns it off.
        insecure: let the router listen beyond this host without TLS and access control.
        open_timeout_s: how long a service waits for the router at its start.
        ask_timeout_s: how long a query waits for its reply.
        health_period_s: how often health is published.
    """

    endpoint: str = LOOPBACK
    namespace: str = ""
    config: str = ""
    router_config: str = ""
    shared_memory_mb: int = 64
    insecure: bool = False
    open_timeout_s: float = 30.0
    ask_timeout_s: float = 5.0
    health_period_s: float = 1.0


def router_config(settings: BusSettings) -> dict[str, Any]:
    """Return the configuration of the embedded router: loopback only, scouting on ``lo``."""
    return {
        "mode": "router",
        "listen": {"endpoints": [settings.endpoint]},
        "scouting": {"delay": 0, "multicast": {"enabled": True, "interface": "lo"}},
        "transport": {"link": _LINK},
    }


def client_config(settings: BusSettings) -> dict[str, Any]:
    """Return the configuration of a service: a client of one router, no scouting."""
    config: dict[str, Any] = {
        "mode": "client",
        "connect": {
            "endpoints": [settings.endpoint],
            "timeout_ms": 1000,
            "retry": {
                "period_init_ms": 100,
                "period_max_ms": 500,
                "period_increase_factor": 2,
            },
        },
        "scouting": {"multicast": {"enabled": False}},
        "timestamping": {"enabled": True},
        "transport": {
            "link": _LINK,
            "shared_memory": {
                "enabled": settings.shared_memory_mb > 0,
                "transport_optimization": {"enabled": True, "messages": ["put"]},
            },
        },
    }
    if settings.namespace:
        config["namespace"] = settings.namespace
    return config


def config_text(settings: BusSettings, *, router: bool) -> str:
    """Return JSON5 for ``zenoh.Config.from_json5``.

    Raises:
        Refused: the file named in the settings cannot be read.
    """
    path = settings.router_config if router else settings.config
    if not path:
        return json.dumps(router_config(settings) if router else client_config(settings))
    try:
        return Path(path).read_text(encoding="utf-8")
    except OSError as error:
        raise Refused(f"zenoh configuration {path} cannot be read: {error}") from error
