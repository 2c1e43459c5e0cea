"""Which views of one thing can be read as views of another: where the other projects to."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from doro_mapper.boxes import covered
from doro_mapper.existence import FURNITURE_M
from doro_mapper.tracks.items import Item
from doro_mapper.tracks.table import Ints, TrackTable
from doro_mapper.views import Bools, Floats, Views

EXPLAIN_COVER = 0.5
EXPLAIN_RATIO = 4.0
EXPLAINED_SHARE = 0.6
PRUNE_SHARE = 0.7
PRUNE_COVER = 0.5
PRUNE_RATIO = 3.0
PART_COVER, PART_RATIO = 0.6, 8.0
"""Of furniture often a part alone has been measured, a chair's back over a table: it lies well
inside of the boxes of the whole."""


class Explanations:
    """Answers about the items of one neighbourhood; each pair is projected once."""

    def __init__(self, table: TrackTable, views: Views) -> None:
        self._table = table
        self._views = views
        self._known: dict[tuple[int, int], bool] = {}
        self._kept: list[Item] = []

    def ask(self, pairs: Sequence[tuple[Item, Item]]) -> None:
        """Work out several pairs (larger, smaller) at once for :meth:`explains`."""
        fresh = [pair for pair in pairs if (id(pair[0]), id(pair[1])) not in self._known]
        samples = [self._sample(smaller) for _, smaller in fresh]
        count = np.array([len(slots) for slots, _ in samples])
        if not count.any():
            return
        which = np.repeat(np.arange(len(fresh)), count)
        low = np.array([larger.low_m for larger, _ in fresh])
        high = np.array([larger.high_m for larger, _ in fresh])
        slots = np.concatenate([slots for slots, _ in samples])
        own = np.concatenate([boxes for _, boxes in samples])
        cover, ratio, shows = self._projected(own, low[which], high[which], slots)
        fits = shows & (cover >= EXPLAIN_COVER) & (ratio < EXPLAIN_RATIO)
        share = np.bincount(which, fits, minlength=len(fresh)) / np.maximum(count, 1)
        for (larger, smaller), part in zip(fresh, share.tolist(), strict=True):
            self._known[id(larger), id(smaller)] = part >= EXPLAINED_SHARE
            self._kept += [larger, smaller]  # an id means something as long as the item lives

    def knows(self, larger: Item, smaller: Item) -> bool:
        """Tell whether :meth:`explains` was worked out already."""
        return (id(larger), id(smaller)) in self._known

    def explains(self, larger: Item, smaller: Item) -> bool:
        """Tell whether most views of the smaller one lie where the larger one projects to."""
        key = id(larger), id(smaller)
        if key not in self._known:
            self.ask([(larger, smaller)])
        return self._known.get(key, False)

    def readings(self, item: Item, others: list[Item]) -> list[tuple[Item, Ints]] | None:
        """Return which slots are views of which other item, where that explains the item.

        Only views in which the other was not seen itself can be views of it; those are taken.
        """
        slots, own = self._sample(item)
        if not len(slots):
            return None
        free = ~np.array([other.seen[slots] for other in others]).T
        if free.any(axis=1).mean() < PRUNE_SHARE:
            return None
        view, which = np.nonzero(free)
        low = np.array([other.low_m for other in others])
        high = np.array([other.high_m for other in others])
        cover, ratio, shows = self._projected(own[view], low[which], high[which], slots[view])
        fits: Bools = np.zeros(free.shape, dtype=bool)
        alike = (cover >= PRUNE_COVER) & (ratio < PRUNE_RATIO)
        if item.longest_m >= FURNITURE_M:
            alike |= (cover >= PART_COVER) & (ratio > 1) & (ratio < PART_RATIO)
        fits[free] = shows & alike
        read = fits.any(axis=1)
        if read.mean() < PRUNE_SHARE:
            return None
        covers = np.full(free.shape, -1.0)
        covers[free] = cover
        best = np.where(fits, covers, -1.0).argmax(axis=1)
        out = []
        for number, other in enumerate(others):
            taken = slots[read & (best == number)]
            if len(taken):
                other.seen = other.seen.copy()
                other.seen[taken] = True
                out.append((other, taken))
        return out

    def _sample(self, item: Item) -> tuple[Ints, Floats]:
        """Return (slots, boxes) of the views kept that gave an item geometry."""
        t = self._table
        serials = np.concatenate([t.kept_serial[row, : t.kept[row]] for row in item.rows])
        boxes = np.concatenate([t.kept_box[row, : t.kept[row]] for row in item.rows])
        there = serials >= self._views.oldest
        return self._views.slots(serials[there]), boxes[there].astype(np.float64)

    def _projected(
        self, own: Floats, low_m: Floats, high_m: Floats, slots: Ints
    ) -> tuple[Floats, Floats, Bools]:
        """Return (cover, ratio, shows), each (n,), of image boxes by where 3-D boxes project to."""
        boxes, shows = self._views.project_boxes(low_m, high_m, slots)
        cover, ratio = covered(own, boxes)
        return cover, ratio, shows
