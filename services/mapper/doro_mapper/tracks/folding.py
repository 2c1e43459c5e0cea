"""Making one track of several for good, so that a long run does not carry their pieces along.

What merging found again and again of a well seen thing is no longer looked at: its tracks are
folded into the one with most views. So the work of a frame goes with the things around, not with
the number of pieces that noise has broken off in all the time before.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from doro_mapper.tracks.items import Group, item_of
from doro_mapper.tracks.table import KEPT, WITH_POINTS, Ints, TrackTable
from doro_mapper.views import Bools
from doro_mapper.votes import Votes

PIECE_RATIO, READ_RATIO = 5, 10
"""How many times the views of a piece, or of a track that was told to be views of others, the main
track has before it takes it in for good: what looks like one thing early may be two."""
KEPT_FIELDS = (
    "kept_priority", "kept_place", "kept_weight", "kept_area", "kept_border", "kept_serial",
    "kept_box",
)  # fmt: skip


def fold_group(table: TrackTable, votes: dict[int, Votes], group: Group) -> list[int]:
    """Take the small pieces of a thing into its main track; return the rows that went.

    The group is changed to what is left; the caller drops the rows.
    """
    main, item = group.main, group.item
    gone: list[int] = []
    left, shaping = [main], 1
    for index, row in enumerate(item.rows[1:], start=1):
        if table.hits[row] * PIECE_RATIO <= table.hits[main]:
            fold(table, main, row, measured=index < item.shaping)
            votes[main].take(votes[row])
            gone.append(row)
        else:
            left.append(row)
            shaping += index < item.shaping
    if gone:
        table.refresh(np.array([main]))
        table.look_back(main)
    read = [row for row in group.absorbed if table.hits[row] * READ_RATIO <= table.hits[main]]
    if read and len(read) == len(group.absorbed) and group.read is not None:
        read_as(table, main, group.read)
        group.read = None
    group.absorbed = [row for row in group.absorbed if row not in read]
    if len(left) == 1:
        group.item = item_of(main, table, votes[main])
    elif gone:
        hits = int(table.seen[left].any(axis=0).sum())
        group.item = replace(item, rows=left, shaping=shaping, hits=hits)
    return [*gone, *read]


def fold(table: TrackTable, main: int, minor: int, *, measured: bool) -> None:
    """Take the views of one track into another; the caller drops it afterwards, and derives the
    other's geometry and misses again when all are in.

    Args:
        measured: take its sample of measurements as well.
    """
    older = sum(int(table.hits[row] - table.seen[row].sum()) for row in (main, minor))
    table.seen[main] |= table.seen[minor]
    table.hits[main] = older + int(table.seen[main].sum())
    table.last_hit[main] = max(table.last_hit[main], table.last_hit[minor])
    table.run[main] = min(table.run[main], table.run[minor])
    table.empty_run[main] = min(table.empty_run[main], table.empty_run[minor])
    if measured:
        table.measured[main] += table.measured[minor]
        _join_samples(table, main, minor)


def read_as(table: TrackTable, main: int, slots: Bools) -> None:
    """Count views (slots) as views of a track: they were told to be of it."""
    older = int(table.hits[main] - table.seen[main].sum())
    table.seen[main, : len(slots)] |= slots
    table.hits[main] = older + int(table.seen[main].sum())
    missed = table.expected[main] & ~table.seen[main]
    table.misses[main] = table.old_misses[main] + int(missed.sum())


def _join_samples(table: TrackTable, main: int, minor: int) -> None:
    """Keep of both samples those with the lowest hashes; those with points come first."""
    rows = np.repeat([main, minor], [table.kept[main], table.kept[minor]])
    slots = np.concatenate([np.arange(table.kept[main]), np.arange(table.kept[minor])])
    chosen = _choose(table.kept_priority[rows, slots], slots < WITH_POINTS)
    rows, slots = rows[chosen], slots[chosen]
    count = len(chosen)
    for name in KEPT_FIELDS:
        values = getattr(table, name)
        values[main, :count] = values[rows, slots]
    shown = min(count, WITH_POINTS)
    table.kept_points[main, :shown] = table.kept_points[rows[:shown], slots[:shown]]
    table.kept[main] = count


def _choose(priority: np.ndarray[tuple[int], np.dtype[np.float64]], points: Bools) -> Ints:
    """Return which entries to keep: first the best that have points, then the best others."""
    order = np.argsort(priority, kind="stable")
    first = order[points[order]][:WITH_POINTS]
    rest = order[~np.isin(order, first)][: KEPT - len(first)]
    return np.asarray(np.concatenate([first, rest]))
