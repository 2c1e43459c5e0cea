"""``python -m doro_nlu.train.speed``: time from text to graph, a sentence at a time, one thread."""

from __future__ import annotations

import time

from doro_nlu.core import Nlu
from doro_nlu.settings import NluSettings
from doro_schemas.messages import ParseRequest

SENTENCES = (
    "find the bed",
    "bring me the red cup",
    "take the plastic cup on the table",
    "can you bring me the red cup from the dining table",
    "go to the kitchen and get the white ceramic bowl next to the sink, then bring it to me",
)


def measure(repeats: int) -> tuple[float, float]:
    """Return the 50th and 99th percentile of text -> graph, microseconds; nothing is cached."""
    nlu = Nlu(NluSettings(cache_size=0))
    times_us = []
    for _ in range(repeats):
        for text in SENTENCES:
            started_ns = time.perf_counter_ns()
            nlu.parse(ParseRequest(text=text))
            times_us.append((time.perf_counter_ns() - started_ns) / 1000)
    times_us.sort()
    return times_us[len(times_us) // 2], times_us[len(times_us) * 99 // 100]


def main() -> None:
    """Print the figures."""
    p50_us, p99_us = measure(400)
    print(f"text -> graph: p50 {p50_us:.0f} us, p99 {p99_us:.0f} us")


if __name__ == "__main__":
    main()
