"""Order: do shuffled views lead to the same instances?

Each recording is merged as recorded and in ``orders`` seeded shuffles. Compared are the counts
of every class that is in the map (all, not only the evaluated ones), and the distance of each
instance to the one of its class that is nearest in a one-to-one pairing.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray
from rich.table import Table

from doro_evaluation.chain import Language, Room, count_instances, load_room
from doro_evaluation.counting.report import Figures
from doro_evaluation.runs import Context, Recorded, in_processes
from doro_mapper.assignment import assign
from doro_schemas.messages import FrameGraphs, Instance

TOLERANCES_M = (0.05, 0.10, 0.25)


class OrderResult(msgspec.Struct, frozen=True):
    """A recording in other orders.

    Attributes:
        classes: (class, order) pairs; same_counts: those counted as in the recorded order.
        instances: of the recorded order, summed over orders; moved_m: their distances to
            their partners of the other orders, those without a partner left out.
    """

    recording: str
    classes: int
    same_counts: int
    instances: int
    moved_m: tuple[float, ...]


def compare_orders(
    recordings: Sequence[Recorded], context: Context, orders: int, workers: int = 2
) -> Iterator[OrderResult]:
    """Yield the result of each recording as it is done, in order of recordings."""
    calls = [(Path(item.path), context, orders) for item in recordings]
    yield from in_processes(_compare, calls, workers)


def compare_order(
    room: Room, graphs: Sequence[FrameGraphs], context: Context, orders: int
) -> OrderResult:
    """Return how instances of shuffled views differ from those of the recorded order."""
    recorded = count_instances(room, graphs, context.mapper).instances
    counts = Counter(item.graph.name for item in recorded)
    classes = same = 0
    moved: list[float] = []
    for number in range(orders):
        rng = np.random.default_rng([context.seed, number])
        order = [int(k) for k in rng.permutation(len(room.depths))]
        other = count_instances(room, graphs, context.mapper, order).instances
        others = Counter(item.graph.name for item in other)
        names = sorted(counts.keys() | others.keys())
        classes += len(names)
        same += sum(counts[name] == others[name] for name in names)
        moved += _moved(recorded, other)
    return OrderResult(room.name, classes, same, orders * len(recorded), tuple(moved))


def figures_of(results: Sequence[OrderResult]) -> Figures:
    """Return ``order/ours/gt/...``: share of equal counts, and of instances within tolerances."""
    moved = np.array([value for one in results for value in one.moved_m])
    total = sum(one.instances for one in results)
    figures: Figures = {
        "order/ours/gt/recordings": len(results),
        "order/ours/gt/class_counts": sum(one.classes for one in results),
        "order/ours/gt/same_counts": round(
            sum(one.same_counts for one in results) / max(1, sum(one.classes for one in results)), 5
        ),
    }
    for tolerance in TOLERANCES_M:
        share = float((moved <= tolerance).sum()) / max(1, total)
        figures[f"order/ours/gt/within_{tolerance:g}m"] = round(share, 5)
    if len(moved):
        for percent in (50, 99):
            value = round(float(np.percentile(moved, percent)), 5)
            figures[f"order/ours/gt/moved_p{percent}_m"] = value
    return figures


def table_of(results: Sequence[OrderResult]) -> Table:
    """Return the figures as a table."""
    table = Table("figure", "value", title="Shuffled orders against the recorded one")
    for name, value in figures_of(results).items():
        table.add_row(name.removeprefix("order/ours/gt/"), str(value))
    return table


def _compare(call: tuple[Path, Context, int]) -> OrderResult:
    path, context, orders = call
    room = load_room(path)
    graphs = Language(context.perception, context.nlu).graphs(room)
    return compare_order(room, graphs, context, orders)


def _moved(recorded: Sequence[Instance], other: Sequence[Instance]) -> list[float]:
    """Return the distances of pairs of a class, all that can be paired."""
    moved: list[float] = []
    for name in sorted({item.graph.name for item in recorded}):
        a = _positions(recorded, name)
        b = _positions(other, name)
        if len(b):
            distance = np.linalg.norm(a[:, None] - b[None], axis=2)
            moved += [float(distance[row, column]) for row, column in assign(distance)]
    return moved


def _positions(instances: Sequence[Instance], name: str) -> NDArray[np.float64]:
    chosen = [item.position_m for item in instances if item.graph.name == name]
    return np.array(chosen, np.float64).reshape(-1, 3)
