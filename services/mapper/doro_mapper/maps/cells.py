"""The cells of the map, stored by graph and block: what lies together is kept together.

A surface fills a good part of the blocks that it goes through, so a block's cells stand side by
side in arrays and one look-up finds them all. A cell's number is ``row * CELLS`` + its place in
the block.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from doro_mapper.maps.blocks import BLOCK_BANDS, BLOCK_CELLS, Blocks
from doro_mapper.maps.digest import key_hashes

CELLS = BLOCK_CELLS * BLOCK_CELLS * BLOCK_BANDS
SIDES = np.array([[1], [BLOCK_CELLS], [BLOCK_CELLS], [BLOCK_BANDS]])
LOCAL = np.array([0, BLOCK_CELLS * BLOCK_BANDS, BLOCK_BANDS, 1])
FIRST_ROWS = 64
GROWTH = 1.25
LEAST_FILL = 8
"""There is no more room when rows of so many cells on average would make ``max_cells``."""

Ints = NDArray[np.int64]
VALUE = np.dtype("<u8")


MIDDLE = (1 << 46) + (1 << 28) + (1 << 10)
WEIGHTS = np.array([1 << 47, 1 << 29, 1 << 11, 1])


def packed(places: NDArray[np.int64]) -> Ints:
    """Return (graph, a, b, band), int64 (4, n), as one integer each, in the same order.

    Exact for 65,536 graphs, places within 2^17 of the origin and bands within 2^10.
    """
    return np.asarray(WEIGHTS @ places + MIDDLE)


def runs(ordered: Ints) -> Ints:
    """Return where the runs of equal values begin in ordered values, at least one."""
    new = np.empty(len(ordered), dtype=bool)
    new[0] = True
    np.not_equal(ordered[1:], ordered[:-1], out=new[1:])
    return np.flatnonzero(new)


def sizes(first: Ints, stop: int) -> Ints:
    """Return how long runs are that begin at ``first``, the last before ``stop``."""
    out = np.empty(len(first), np.int64)
    np.subtract(first[1:], first[:-1], out=out[:-1])
    out[-1] = stop - first[-1]
    return out


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
        value: uint64 by number: weight (float32) in the low half, frequency in the high half.
    """

    def __init__(self, blocks: Blocks, max_cells: int) -> None:
        self._blocks = blocks
        self._max_cells = max_cells
        self._rows: dict[int, int] = {}
        self.size = 0
        self.place = np.zeros((FIRST_ROWS, 4), np.int32)
        self.block = np.zeros(FIRST_ROWS, np.int32)
        self.value = np.zeros(FIRST_ROWS * CELLS, VALUE)
        self._sum = np.zeros(2, np.uint64)

    def clear(self) -> None:
        """Forget all cells."""
        self._rows, self.size = {}, 0
        self.value[:] = 0
        self._sum[:] = 0

    def numbers(self, places: Ints) -> Ints:
        """Return the numbers of cells (4, n) graph, a, b, band; -1 where there is no room."""
        blocks, inside = np.divmod(places, SIDES)
        keys = packed(blocks)
        order = np.argsort(keys)
        ordered = keys[order]
        first = runs(ordered)
        once = ordered[first].tolist()
        rows = np.array([self._rows.get(key, -1) for key in once], dtype=np.int64)
        for index in np.flatnonzero(rows < 0).tolist():
            at = order[first[index]]
            rows[index] = self._open(once[index], blocks[:, at].tolist())
        row = np.empty(len(keys), np.int64)
        row[order] = np.repeat(rows * CELLS, sizes(first, len(keys)))
        numbers = row + LOCAL @ inside
        return numbers if (rows >= 0).all() else np.where(row < 0, -1, numbers)

    def _open(self, key: int, place: list[int]) -> int:
        row = len(self._rows)
        if row >= max(1, self._max_cells // LEAST_FILL):
            return -1
        if row >= len(self.block):
            self._grow(int(row * GROWTH) + 1)
        self._rows[key] = row
        self.place[row] = place
        self.block[row] = self._blocks.number(place[1:])
        return row

    def _grow(self, rows: int) -> None:
        for name, width in (("place", 1), ("block", 1), ("value", CELLS)):
            old = getattr(self, name)
            bigger = np.zeros((rows * width, *old.shape[1:]), old.dtype)
            bigger[: len(old)] = old
            setattr(self, name, bigger)

    def fits(self, numbers: Ints) -> NDArray[np.bool_]:
        """Tell which cells have room, (n,): those that were hit before, and as many new ones."""
        left = self._max_cells - self.size
        if len(numbers) > left:
            fresh = (numbers >= 0) & (self.value[numbers] == 0)
            return np.asarray((numbers >= 0) & ~(fresh & (np.cumsum(fresh) > left)))
        return np.asarray(numbers >= 0)

    def add(self, keys: Ints, numbers: Ints, weight: NDArray[Any], often: Any) -> None:
        """Add to cells, each once.

        Args:
            keys: :func:`packed` of graph and place, for the digest.
            often: how often each was hit.
        """
        old = self.value[numbers]
        new = np.empty_like(old)
        old_often = frequency_of(old)
        np.add(weight_of(old), weight, out=weight_of(new), casting="same_kind")
        np.add(old_often, often, out=frequency_of(new), casting="same_kind")
        self.size += len(old) - int(np.count_nonzero(old_often))
        self.value[numbers] = new
        self._sum += (key_hashes(keys) * (new - old)).sum(axis=1, dtype=np.uint64)

    def digest(self) -> NDArray[np.uint64]:
        """Return two sums over all cells of hash times value: equal for equal cells.

        Each frame adds what it changed, so that asking costs nothing.
        """
        return self._sum

    def listed(self, graph_ids: NDArray[Any] | None = None) -> tuple[Ints, Ints]:
        """Return places (4, n) and numbers of the cells of graphs, or of all, sorted."""
        rows = np.arange(len(self._rows))
        if graph_ids is not None:
            rows = rows[np.isin(self.place[rows, 0], graph_ids)]
        hit = self.value[: len(self._rows) * CELLS].reshape(-1, CELLS)[rows] > 0
        at, local = np.nonzero(hit)
        places = self.place[rows[at]].astype(np.int64)
        ground, band = np.divmod(local, BLOCK_BANDS)
        places = places.T * SIDES
        places[1:] += np.stack([*np.divmod(ground, BLOCK_CELLS), band])
        order = np.argsort(packed(places))
        numbers = rows[at] * CELLS + local
        return places[:, order], numbers[order]


def weight_of(values: NDArray[np.uint64]) -> NDArray[np.float32]:
    """Return the sums of weights in values, a view."""
    return values.view(np.dtype("<f4"))[0::2]


def frequency_of(values: NDArray[np.uint64]) -> NDArray[np.int32]:
    """Return the frequencies in values, a view."""
    return values.view(np.dtype("<i4"))[1::2]
