"""The embedded router, and opening a session."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable

import zenoh

from doro_schemas.bus.config import BusSettings, config_text
from doro_schemas.errors import Refused


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
        Refused: the endpoint is taken, or the configuration does not fit.
    """
    # Waited for, not handled: an Event that a handler sets can deadlock, where the signal comes
    # while the main thread holds the event's lock.
    stop_signals = (signal.SIGTERM, signal.SIGINT)
    signal.pthread_sigmask(signal.SIG_BLOCK, stop_signals)
    try:
        session = zenoh.open(parse_config(config_text(settings, router=True)))
    except zenoh.ZError as error:
        raise Refused(
            f"the router cannot listen at {settings.endpoint}: is another one running?"
            f" ({_words(error)})"
        ) from error
    with session:
        signal.sigwait(stop_signals)
