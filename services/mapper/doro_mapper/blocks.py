"""How often places were in view: counted by block of cells, not cell by cell.

A block is BLOCK_CELLS x BLOCK_CELLS ground cells and BLOCK_BANDS bands (25 cm x 25 cm x 20 cm).
Only blocks that hold cells are counted: some hundred a room, so that every frame can look at all
of them. A cell was observable as often as its block's middle was, and at least as often as
it was hit.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from doro_mapper.digest import key_hashes
from doro_mapper.views import SIGHT_M, Floats, Views

BLOCK_CELLS = 5
BLOCK_BANDS = 2
SLACK_M = 0.20
"""A block's middle behind the seen surface by less than this counts as seen: half its diagonal."""
INITIAL_ROOM = 256

Ints = NDArray[np.int64]


class Blocks:
    """Blocks in order of their opening. Memory: about 150 bytes a block.

    Attributes:
        place: int32 (n, 3) block a, block b, block up: cell numbers divided, rounded down.
        count: int32 (rows,) frames that had the block in view.
    """

    def __init__(self, edges_m: Floats) -> None:
        self._divisor = np.array([BLOCK_CELLS, BLOCK_CELLS, BLOCK_BANDS])
        self._edges_m = edges_m * self._divisor
        self._number: dict[tuple[int, int, int], int] = {}
        self.place = np.zeros((INITIAL_ROOM, 3), np.int32)
        self.count = np.zeros(INITIAL_ROOM, np.int32)
        self._center_m = np.zeros((INITIAL_ROOM, 3))
        self._fresh = 0

    def __len__(self) -> int:
        return len(self._number)

    def number(self, place: list[int]) -> int:
        """Return the number of a block, opening a new one."""
        key = place[0], place[1], place[2]
        number = self._number.setdefault(key, len(self._number))
        if number >= len(self.count):
            for name in ("place", "count", "_center_m"):
                old = getattr(self, name)
                setattr(self, name, np.concatenate([old, np.zeros_like(old)]))
        if number == len(self._number) - 1:
            self.place[number] = place
            self._center_m[number] = (self.place[number] + 0.5) * self._edges_m
        return number

    def observe(self, hit: Ints, views: Views, serial: int) -> Ints:
        """Count a view; return the blocks it had in view. What was hit was seen.

        For blocks that are new, the views before count as well.
        """
        n, slot = len(self), int(views.slots([serial])[0])
        new = np.arange(self._fresh, n)
        self._fresh = n
        if len(new):
            self._look_back(new, views, slot)
        away = self._center_m[:n, :2] - views.position_m(serial)[:2]
        near = np.flatnonzero((away * away).sum(axis=1) < SIGHT_M**2)
        visible, _, _ = views.look_at(self._center_m[near, None], slot, np.full(len(near), SLACK_M))
        mask = np.zeros(n, dtype=bool)
        mask[near[visible[:, 0]]] = mask[hit] = True
        self.count[:n] += mask
        return np.flatnonzero(mask)

    def _look_back(self, new: Ints, views: Views, slot: int) -> None:
        """Count for new blocks the earlier views kept."""
        centers = self._center_m[new]
        middle = (centers.min(0) + centers.max(0)) / 2
        radius = float(np.linalg.norm(centers - middle, axis=1).max())
        slots = views.near(middle, radius)
        slots = slots[slots != slot]
        if len(slots):
            seen, _ = views.visible(centers, slots, SLACK_M)
            self.count[new] = seen.sum(axis=0)

    def count_again(self, views: Views) -> None:
        """Count all blocks in all views kept."""
        n = len(self)
        self.count[:n] = 0
        slack = np.full(n, SLACK_M)
        for serial in range(views.oldest, views.total):
            slot = int(views.slots([serial])[0])
            visible, _, _ = views.look_at(self._center_m[:n, None], slot, slack)
            self.count[:n] += visible[:, 0]

    def published(self, numbers: Ints | None = None) -> NDArray[np.int32]:
        """Return int32 (n, 4) of blocks, or of all: place and count, sorted by place."""
        if numbers is None:
            numbers = np.arange(len(self))
        rows = np.column_stack([self.place[numbers], self.count[numbers]])
        order = np.lexsort((rows[:, 2], rows[:, 1], rows[:, 0]))
        return np.asarray(rows[order], dtype=np.int32)

    def digest(self) -> NDArray[np.uint64]:
        """Return two sums of hash times count over all blocks, whatever their order."""
        n = len(self)
        keys = self.place[:n].astype(np.int64) @ np.array([1 << 42, 1 << 21, 1])
        return np.asarray((key_hashes(keys) * self.count[:n].astype(np.uint64)).sum(axis=1))
