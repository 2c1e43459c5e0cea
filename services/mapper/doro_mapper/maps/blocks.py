"""How often places were in view: counted by block of cells, not cell by cell.

A block is BLOCK_CELLS x BLOCK_CELLS ground cells and BLOCK_BANDS bands (25 cm x 25 cm x 20 cm).
Only blocks that hold cells are counted: some hundred a room, so that every frame can look at all
of them. A cell was observable as often as its block's middle was, and at least as often as
it was hit.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from doro_mapper.maps.digest import key_hashes
from doro_mapper.views import Floats, Views

BLOCK_CELLS = 5
BLOCK_BANDS = 2
SLACK_M = 0.20
"""A block's middle behind the seen surface by less than this counts as seen: half its diagonal."""
MOST_BACK = 128
"""Views looked back at for a new block."""
INITIAL_ROOM = 256
PLACE_BITS = 20
"""A block's place as one integer, in the order of places within 2^19 blocks of the origin."""

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
        self._key = np.zeros(INITIAL_ROOM, np.int64)
        self._fresh = 0

    def __len__(self) -> int:
        return len(self._number)

    def number(self, place: list[int]) -> int:
        """Return the number of a block, opening a new one."""
        key = place[0], place[1], place[2]
        number = self._number.setdefault(key, len(self._number))
        if number >= len(self.count):
            for name in ("place", "count", "_center_m", "_key"):
                old = getattr(self, name)
                setattr(self, name, np.concatenate([old, np.zeros_like(old)]))
        if number == len(self._number) - 1:
            self.place[number] = place
            self._center_m[number] = (self.place[number] + 0.5) * self._edges_m
            a, b, up = place
            self._key[number] = (a << 2 * PLACE_BITS) + (b << PLACE_BITS) + up
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
        visible = views.sees(self._center_m[:n], slot, SLACK_M)
        visible[hit] = True
        self.count[:n] += visible
        return np.flatnonzero(visible)

    def _look_back(self, new: Ints, views: Views, slot: int) -> None:
        """Count for new blocks the earlier views kept; of many every so many, which stands for
        those that follow it."""
        centers = self._center_m[new]
        middle = (centers.min(0) + centers.max(0)) / 2
        radius = float(np.linalg.norm(centers - middle, axis=1).max())
        slots = views.near(middle, radius)
        slots = slots[slots != slot]
        if len(slots):
            step = -(-len(slots) // MOST_BACK)
            seen, _ = views.visible(centers, slots[::step], SLACK_M)
            self.count[new] = seen.sum(axis=0) * step

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
        numbers = numbers[np.argsort(self._key[numbers])]
        out = np.empty((len(numbers), 4), np.int32)
        out[:, :3], out[:, 3] = self.place[numbers], self.count[numbers]
        return out

    def digest(self) -> NDArray[np.uint64]:
        """Return two sums of hash times count over all blocks, whatever their order."""
        n = len(self)
        count = self.count[:n].astype(np.uint64)
        return np.asarray((key_hashes(self._key[:n]) * count).sum(axis=1))
