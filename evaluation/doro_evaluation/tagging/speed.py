"""Speed of the taggers beside bert-base, memory, readiness; whole graphs on hand-written text."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import msgspec
from rich.table import Table

from doro_evaluation.figures import Figure
from doro_evaluation.tagging.exactness import (
    FRESH,
    INSTRUCTIONS,
    Failure,
    graph_exactness,
    read_rows,
)
from doro_nlu.core import Nlu
from doro_nlu.settings import NluSettings
from doro_nlu.tagger import Tagger
from doro_nlu.train.speed import (
    Footprint,
    Times,
    beside_reference,
    footprint,
    reference_session,
    text_to_graph,
)

HAND_WRITTEN = {"hand_written": INSTRUCTIONS, "hand_written_fresh": FRESH}
US_PER_MS = 1000.0


class Speed(msgspec.Struct, frozen=True):
    """Times of a tagger, in turns with bert-base in fp32, and of what is made of it."""

    ours: Times
    reference: Times
    calls: dict[str, Times]
    process: Footprint

    @property
    def ratio(self) -> float:
        """How many times faster than bert-base, by the thread's own time."""
        return self.reference.cpu_p50_us / self.ours.cpu_p50_us


def measure_speed(
    taggers: Mapping[str, Tagger], bert_base: Path | None
) -> Iterator[tuple[str, Speed]]:
    """Yield the speed of each shipped tagger.

    Args:
        bert_base: a trained one; None: its shape with random weights, which runs as long.
    """
    reference = reference_session(bert_base)
    for name, tagger in taggers.items():
        ours, theirs = beside_reference(tagger, reference)
        yield name, Speed(ours, theirs, text_to_graph(tagger), footprint(name))


class Exact(msgspec.Struct, frozen=True):
    """Whole graphs of a tagger on a set of hand-written instructions."""

    tagger: str
    where: str
    right: int
    count: int
    failures: list[Failure]


def exact_graphs(taggers: Mapping[str, Tagger]) -> list[Exact]:
    """Return whole graphs right and the failures, by set and tagger."""
    found = []
    for where, path in HAND_WRITTEN.items():
        rows = read_rows(path)
        for name, tagger in taggers.items():
            right, failures = graph_exactness(Nlu(NluSettings(), tagger), rows)
            found.append(Exact(name, where, right, len(rows), failures))
    return found


def speed_figures(speeds: Mapping[str, Speed]) -> dict[str, Figure]:
    """Return ``speed/tagger/<tagger>/...``, times in milliseconds of the thread's own time."""
    figures: dict[str, Figure] = {}
    for name, speed in speeds.items():
        start = f"speed/tagger/{name}"
        figures[f"{start}/ratio_to_bert_base"] = round(speed.ratio, 1)
        for what, times in speed.calls.items():
            words = what.replace(" -> ", "_to_").replace(", ", "_").replace(" ", "_")
            figures[f"{start}/{words}_p50_ms"] = round(times.cpu_p50_us / US_PER_MS, 3)
            figures[f"{start}/{words}_wall_p50_ms"] = round(times.p50_us / US_PER_MS, 3)
        figures[f"{start}/memory_mb"] = round(speed.process.memory_mb, 1)
        figures[f"{start}/ready_s"] = round(speed.process.ready_s, 2)
        figures[f"{start}/ready_cpu_s"] = round(speed.process.cpu_s, 2)
    if "default" in speeds:
        figures["speed/tagger/ratio_to_bert_base"] = round(speeds["default"].ratio, 1)
    return figures


def exact_figures(found: Sequence[Exact]) -> dict[str, Figure]:
    """Return ``tagging/<tagger>/<set>/whole_graphs`` and how many instructions there are."""
    figures: dict[str, Figure] = {}
    for one in found:
        figures[f"tagging/{one.tagger}/{one.where}/whole_graphs"] = round(one.right / one.count, 4)
        figures[f"tagging/{one.tagger}/{one.where}/instructions"] = one.count
    return figures


def speed_table(speeds: Mapping[str, Speed]) -> Table:
    """Return the speeds: a row per call, p50 of the thread's own time and of the wall clock."""
    table = Table("one thread, p50: own time (wall), ms", *speeds, title="Speed")
    for what in next(iter(speeds.values())).calls:
        table.add_row(what, *(_cell(speed.calls[what]) for speed in speeds.values()))
    table.add_row("bert-base fp32, in turns", *(_cell(s.reference) for s in speeds.values()))
    table.add_row("times faster than it", *(f"{speed.ratio:.0f}" for speed in speeds.values()))
    table.add_section()
    table.add_row("memory, MB", *(f"{s.process.memory_mb:.0f}" for s in speeds.values()))
    table.add_row(
        "ready, s: own time (wall)",
        *(f"{s.process.cpu_s:.2f} ({s.process.ready_s:.2f})" for s in speeds.values()),
    )
    return table


def exact_lines(found: Sequence[Exact]) -> list[str]:
    """Return what was right as a whole graph, and every failure, for people."""
    lines = []
    for one in found:
        lines.append(f"{one.where}, {one.tagger}: {one.right} of {one.count} graphs wholly right")
        for failure in one.failures:
            lines += [f"  {failure.text}", f"    wanted {failure.expected}"]
            lines.append(f"    got    {failure.got}")
    return lines


def _cell(times: Times) -> str:
    return f"{times.cpu_p50_us / US_PER_MS:.2f} ({times.p50_us / US_PER_MS:.2f})"
