"""The embedded router, and opening a session."""

from __future__ import annotations

import ipaddress
import json
import signal
import time
from collections.abc import Callable

import zenoh

from doro_schemas.bus.config import BusSettings, config_text
from doro_schemas.errors import Refused

ENCRYPTED = ("tls", "quic")


def parse_config(text: str) -> zenoh.Config:
    """Return Zenoh's configuration of a JSON5 text.

    Raises:
        Refused: Zenoh does not take it.
    """
    try:
        return zenoh.Config.from_json5(text)
    except zenoh.ZError as error:
        raise Refused(f"the Zenoh configuration does not fit: {error}") from error


def open_session(settings: BusSettings, stopping: Callable[[], bool]) -> zenoh.Session:
    """Connect to the router, waiting for it up to ``open_timeout_s``.

    Raises:
        Refused: no router there in time, or ``stopping()`` became true.
    """
    config = parse_config(config_text(settings, router=False))
    deadline_s = time.monotonic() + settings.open_timeout_s
    while not stopping():
        try:
            return zenoh.open(config)
        except zenoh.ZError as error:
            if time.monotonic() >= deadline_s:
                raise Refused(
                    f"no Zenoh router answers at {settings.endpoint}: start one with 'doro up' or"
                    f" set bus.endpoint ({_words(error)})"
                ) from error
    raise Refused("stopped before the router was reached")


def _words(error: zenoh.ZError) -> str:
    """Return the first line of Zenoh's error without the place in its own source."""
    return str(error).splitlines()[0].split(" at /")[0][:160]


def run_router(settings: BusSettings) -> None:
    """Be the router until SIGTERM or SIGINT.

    Raises:
        Refused: the endpoint is taken or open to the network, or the configuration does not fit.
    """
    # Waited for, not handled: an Event that a handler sets can deadlock, where the signal comes
    # while the main thread holds the event's lock.
    stop_signals = (signal.SIGTERM, signal.SIGINT)
    signal.pthread_sigmask(signal.SIG_BLOCK, stop_signals)
    config = parse_config(config_text(settings, router=True))
    check_exposure(config, settings)
    try:
        session = zenoh.open(config)
    except zenoh.ZError as error:
        raise Refused(
            f"the router cannot listen at {settings.endpoint}: is another one running?"
            f" ({_words(error)})"
        ) from error
    with session:
        signal.sigwait(stop_signals)


def check_exposure(config: zenoh.Config, settings: BusSettings) -> None:
    """Refuse to listen beyond this host without TLS and access control.

    Raises:
        Refused: an endpoint is open to the network, and ``bus.insecure`` is not set.
    """
    if settings.insecure:
        return
    controlled = json.loads(config.get_json("access_control/enabled")) is True
    for endpoint in _listening(config):
        protocol, _, address = endpoint.partition("/")
        if _is_loopback(address):
            continue
        if protocol not in ENCRYPTED or not controlled:
            raise Refused(
                f"the router will not listen at {endpoint}: whoever reaches it could command the"
                " robot. Listen on 127.0.0.1, make certificates and access rules with"
                " 'doro hosts', or accept it with bus.insecure = true"
            )


def _listening(config: zenoh.Config) -> list[str]:
    """Return all endpoints that a configuration listens at, whatever its form."""
    found = json.loads(config.get_json("listen/endpoints"))
    groups = found.values() if isinstance(found, dict) else [found]
    return [str(endpoint) for group in groups for endpoint in group]


def _is_loopback(address: str) -> bool:
    """Tell whether an address ``host:port`` reaches this host only."""
    host = address.partition("?")[0].partition("#")[0].rpartition(":")[0].strip("[]")
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False
