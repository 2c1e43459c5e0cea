"""Whether to believe what one view alone saw, by how often later views refuted such things."""

from __future__ import annotations

import numpy as np

from doro_mapper.tracks.items import Group
from doro_mapper.tracks.table import TrackTable

SPARED = 0.3
"""In the tuning rooms with copies, 55 of 239 false things of one view had no view against them."""
MOSTLY_TRUE = 0.8


def believed(refuted: int, unrefuted: int) -> bool:
    """Tell whether things that one view saw, and no other should have seen, are mostly there.

    How often the detector is wrong is measured by what a later view refuted: for each of these,
    ``SPARED`` more are in places that no other view looked at.
    """
    return SPARED * refuted <= (1 - MOSTLY_TRUE) * unrefuted


class Singles:
    """Counts the things of one view; ``trusted`` tells whether they are believed."""

    def __init__(self) -> None:
        self.trusted = False
        self._dropped = 0

    def drop(self, table: TrackTable, row: int) -> None:
        """Remember a track that is about to go."""
        self._dropped += bool(table.hits[row] == 1 and table.misses[row])

    def judge(self, table: TrackTable, groups: dict[int, Group]) -> None:
        """Count anew; a track that is part of something is none of them."""
        alone = []
        for row in np.flatnonzero(table.alive[: table.n] & (table.hits[: table.n] == 1)).tolist():
            group = groups.get(row)
            if group is not None and len(group.item.rows) == 1 and group.read is None:
                alone.append(row)
        refuted = int(np.count_nonzero(table.misses[alone]))
        self.trusted = believed(self._dropped + refuted, len(alone) - refuted)
