"""Records from the bus: whatever passes on the table's topics goes into a recording."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

from doro_schemas.bus import Bus, RawSample
from doro_schemas.errors import Refused
from doro_schemas.topics import TOPICS, Topic
from doro_sim_feeder.recording import Recorder

NOT_RECORDED = ("health", "alive")
IN_FLIGHT_S = 0.2
"""What was sent before the stop may still be under way: the recorder ends once it is quiet."""


def record_bus(
    bus: Bus,
    path: Path,
    topics: tuple[str, ...] = (),
    *,
    seconds: float | None = None,
    done: Callable[[], bool] = lambda: False,
) -> int:
    """Record until ``done()``, the time is over or the bus is stopped; return the count.

    Args:
        topics: names of the topics; all that are published by default.
        seconds: at most so long.

    Raises:
        Refused: an unknown topic, or a file that cannot be written.
    """
    with _recorder(path) as recorder:
        for topic in _chosen(topics):
            bus.subscribe_raw(topic, lambda sample: _add(recorder, sample))
        bus.declare_alive()
        bus.run_until(None if seconds is None else time.monotonic() + seconds, done)
        bus.drain(quiet_s=IN_FLIGHT_S)
    return recorder.count


def _recorder(path: Path) -> Recorder:
    try:
        return Recorder(path, {"source": "bus"})
    except OSError as error:
        raise Refused(f"recording {path} cannot be written: {error.strerror}") from error


def _chosen(names: tuple[str, ...]) -> list[Topic]:
    known = [
        topic
        for topic in TOPICS.values()
        if topic.kind == "pubsub" and topic.messages and topic.name not in NOT_RECORDED
    ]
    unknown = sorted(set(names) - {topic.name for topic in known})
    if unknown:
        raise Refused(
            f"no topic '{unknown[0]}' to record; known are"
            f" {', '.join(topic.name for topic in known)}"
        )
    return [topic for topic in known if not names or topic.name in names]


def _add(recorder: Recorder, sample: RawSample) -> None:
    recorder.add_raw(sample.key, sample.payload, sample.encoding, time.time_ns())
