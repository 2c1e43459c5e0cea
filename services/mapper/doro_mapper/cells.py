"""The cells of the map, stored by graph and block: what lies together is kept together.

A surface fills a good part of the blocks that it goes through, so a block's cells stand side by
side in arrays and one look-up finds them all. A cell's number is ``row * CELLS`` + its place in
the block.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from doro_mapper.blocks import BLOCK_BANDS, BLOCK_CELLS, Blocks
from doro_mapper.digest import key_hashes

CELLS = BLOCK_CELLS * BLOCK_CELLS * BLOCK_BANDS
SIDES = np.array([BLOCK_CELLS, BLOCK_CELLS, BLOCK_BANDS])
FIRST_ROWS = 64
GROWTH = 1.25
LEAST_FILL = 8
"""There is no more room when rows of so many cells on average would make ``max_cells``."""

Ints = NDArray[np.int64]


def packed(graph_ids: Ints, a: Ints, b: Ints, band: Ints) -> Ints:
    """Return (graph, a, b, band) as one integer each, in the same order.

    Exact for 65,536 graphs, places within 2^17 of the origin and bands within 2^10.
    """
    ground = (((graph_ids << 18) + (a + (1 << 17))) << 18) + (b + (1 << 17))
    return np.asarray((ground << 11) + (band + (1 << 10)))


def runs(ordered: Ints) -> Ints:
    """Return where the runs of equal values begin in ordered values, at least one."""
    new = np.empty(len(ordered), dtype=bool)
    new[0] = True
    np.not_equal(ordered[1:], ordered[:-1], out=new[1:])
    return np.flatnonzero(new)


def order_of(keys: Ints) -> tuple[Ints, Ints]:
    """Return (order, ordered keys) of integers >= 0; equal ones stay in order.

    The index goes into the low bits where there is room: numpy sorts plain integers fastest.
    """
    bits = len(keys).bit_length()
    if int(keys.max(initial=0)).bit_length() + bits > 63:
        order = np.argsort(keys, kind="stable")
        return order, keys[order]
    both = np.sort((keys << bits) | np.arange(len(keys)))
    return both & ((1 << bits) - 1), both >> bits


class Cells:
    """Weight and frequency of all cells, and the digest over them.

    Memory: 400 bytes a row, of which a fifth to a quarter is hit: about 45 bytes a cell.

    Attributes:
        size: cells that were hit, at most ``max_cells``.
        place: int32 (rows, 4) graph, block a, block b, block up.
        block: int32 (rows,) the block's number.
        weight, frequency: float32 and int32 by number; 0 where nothing was.
    """

    def __init__(self, blocks: Blocks, max_cells: int) -> None:
        self._blocks = blocks
        self._max_cells = max_cells
        self._rows: dict[int, int] = {}
        self.size = 0
        self.place = np.zeros((FIRST_ROWS, 4), np.int32)
        self.block = np.zeros(FIRST_ROWS, np.int32)
        self.weight = np.zeros(FIRST_ROWS * CELLS, np.float32)
        self.frequency = np.zeros(FIRST_ROWS * CELLS, np.int32)
        self._sum = np.zeros(2, np.uint64)

    def clear(self) -> None:
        """Forget all cells."""
        self._rows, self.size = {}, 0
        self.weight[:] = self.frequency[:] = 0
        self._sum[:] = 0

    def numbers(self, graph_ids: Ints, places: NDArray[Any]) -> Ints:
        """Return the numbers of cells (3, n); -1 where there is no room.

        Args:
            graph_ids: (n,) of cells sorted by graph.
        """
        blocks = places // SIDES[:, None]
        inside = places - blocks * SIDES[:, None]
        local = (inside[0] * BLOCK_CELLS + inside[1]) * BLOCK_BANDS + inside[2]
        keys = packed(graph_ids, *blocks)
        order = np.argsort(keys, kind="stable")
        ordered = keys[order]
        first = runs(ordered)
        once = ordered[first].tolist()
        rows = np.array([self._rows.get(key, -1) for key in once], dtype=np.int64)
        for index in np.flatnonzero(rows < 0).tolist():
            at = order[first[index]]
            rows[index] = self._open(once[index], int(graph_ids[at]), blocks[:, at].tolist())
        row = np.empty(len(keys), np.int64)
        row[order] = np.repeat(rows, np.diff(first, append=len(keys)))
        return np.asarray(np.where(row < 0, -1, row * CELLS + local))

    def _open(self, key: int, graph_id: int, block: list[int]) -> int:
        row = len(self._rows)
        if row >= max(1, self._max_cells // LEAST_FILL):
            return -1
        if row >= len(self.block):
            self._grow(int(row * GROWTH) + 1)
        self._rows[key] = row
        self.place[row] = graph_id, *block
        self.block[row] = self._blocks.number(block)
        return row

    def _grow(self, rows: int) -> None:
        for name, width in (("place", 1), ("block", 1), ("weight", CELLS), ("frequency", CELLS)):
            old = getattr(self, name)
            bigger = np.zeros((rows * width, *old.shape[1:]), old.dtype)
            bigger[: len(old)] = old
            setattr(self, name, bigger)

    def fits(self, numbers: Ints) -> NDArray[np.bool_]:
        """Tell which cells have room, (n,): those that were hit before, and as many new ones."""
        fresh = (numbers >= 0) & (self.frequency[numbers] == 0)
        left = self._max_cells - self.size
        if int(fresh.sum()) > left:
            return np.asarray((numbers >= 0) & ~(fresh & (np.cumsum(fresh) > left)))
        return np.asarray(numbers >= 0)

    def add(self, keys: Ints, numbers: Ints, weight: NDArray[Any], often: Any) -> None:
        """Add to cells, each once.

        Args:
            keys: :func:`packed` of graph and place, for the digest.
            often: how often each was hit.
        """
        old_weight, old_often = self.weight[numbers], self.frequency[numbers]
        new_weight = (old_weight + weight).astype(np.float32)
        new_often = old_often + often
        self.size += int((old_often == 0).sum())
        self.weight[numbers], self.frequency[numbers] = new_weight, new_often
        change = _value(new_weight, new_often) - _value(old_weight, old_often)
        self._sum += (key_hashes(keys) * change).sum(axis=1, dtype=np.uint64)

    def digest(self) -> NDArray[np.uint64]:
        """Return two sums over all cells of hash times value: equal for equal cells.

        Each frame adds what it changed, so that asking costs nothing.
        """
        return self._sum

    def listed(self, graph_ids: NDArray[Any] | None = None) -> tuple[NDArray[np.int32], Ints]:
        """Return places int32 (n, 4) and numbers of the cells of graphs, or of all, sorted."""
        rows = np.arange(len(self._rows))
        if graph_ids is not None:
            rows = rows[np.isin(self.place[rows, 0], graph_ids)]
        hit = self.frequency[: len(self._rows) * CELLS].reshape(-1, CELLS)[rows] > 0
        at, local = np.nonzero(hit)
        places = self.place[rows[at]].astype(np.int64)
        inside = np.unravel_index(local, tuple(SIDES.tolist()))
        places[:, 1:] = places[:, 1:] * SIDES + np.column_stack(inside)
        order = np.argsort(packed(*places.T), kind="stable")
        numbers = rows[at] * CELLS + local
        return places[order].astype(np.int32), numbers[order]


def _value(weight: NDArray[np.float32], often: NDArray[np.int32]) -> NDArray[np.uint64]:
    """Return weight and frequency in one integer each."""
    bits = weight.astype("<f4").view("<u4").astype(np.uint64)
    return np.asarray(bits | (often.astype(np.uint64) << np.uint64(32)))
