"""Tracks near each other into things: merging by mutual explanation, and pruning.

MAPPER study, points 5 and 6, for one cluster of tracks at a time. Works on items, which stand
for one track or several merged ones; the tracks themselves stay as they are, so that what was
merged can come apart again.
"""

from __future__ import annotations

import numpy as np

from doro_mapper.existence import FURNITURE_M
from doro_mapper.finder import NEVER, names_agree
from doro_mapper.robust import robust_geometry
from doro_mapper.tracks.explained import Explanations
from doro_mapper.tracks.items import (
    CORNER_GAP_M,
    CORNER_GAP_SHARE,
    Item,
    Shape,
    agree,
    gaps_between,
    in_reach,
    item_of,
    one_above,
    one_place,
    reach_matrix,
    strength,
)
from doro_mapper.tracks.table import Ints, TrackTable
from doro_mapper.views import Bools, Floats, Views
from doro_mapper.votes import Votes, merged_look

MERGE_GATE = 0.8
MERGE_FAR_GATE = 2.0
TOGETHER_SHARE = 0.1
"""Tracks seen together in more of the smaller one's frames are different things."""
COMMON_VIEWS = 3
MIXED_GATE, MIXED_VIEWS, MIXED_SHARE = 1.0, 5, 0.3
"""Pieces of one thing that took a view or two of a neighbour's. Of the views that should have seen
both, two things are seen together in nearly all."""
MERGED_KEPT = 64
LABEL_HITS = 2
LABEL_VIEWS = 4
CORNER_HITS, CORNER_SHARE = 3, 0.1
CORNER_CUT = 0.5


class Cluster:
    """Items of one neighbourhood, being merged and pruned."""

    def __init__(
        self,
        rows: list[int],
        table: TrackTable,
        views: Views,
        votes: dict[int, Votes],
        cannot_link: bool = True,
    ) -> None:
        self._link = 1.0 if cannot_link else 0.0
        self._table = table
        self._views = views
        self._votes = votes
        self._explained = Explanations(table, views)
        self._unasked: tuple[list[int], list[int]] = [], []
        items = [item_of(row, table, votes[row]) for row in rows]
        self.items = sorted(items, key=lambda item: -item.hits)

    def merge(self) -> None:
        """Merge the closest items first, until nothing more may be merged."""
        items = self.items
        gaps, parts = gaps_between(items, items)
        seen = np.array([item.seen for item in items], dtype=np.float32)
        together: Floats = self._link * (seen @ seen.T).astype(np.float64)
        hits = np.array([item.hits for item in items])
        open_: Bools = _worth_asking(gaps, parts, together, np.minimum(hits[:, None], hits))
        merged_away = np.zeros(len(items), dtype=bool)
        while (pair := self._next_pair(gaps, together, open_)) is not None:
            i, j, measured = pair
            items[i] = self._joined(items[i], items[j], measured)
            hits[i] = items[i].hits
            near, part = gaps_between([items[i]], items)
            seen[i] = items[i].seen
            gaps[i] = gaps[:, i] = near[0]
            together[i] = together[:, i] = self._link * (seen @ seen[i])
            merged_away[j] = True
            least = np.minimum(hits[i], hits)
            asked = _worth_asking(near[0], part[0], together[i], least) & ~merged_away
            open_[i] = open_[:, i] = asked
            open_[j] = open_[:, j] = False
        self.items = [items[k] for k in np.flatnonzero(~merged_away)]

    def _next_pair(
        self, gaps: Floats, together: Floats, open_: Bools
    ) -> tuple[int, int, bool] | None:
        """Return the closest pair that may be merged, larger first, and whether its geometry is
        shared; close what may not be."""
        first, second = np.nonzero(np.triu(open_, 1))
        # Worked out together, once the first of them has to be known.
        asked = (gaps[first, second] >= MERGE_GATE) & (together[first, second] == 0)
        self._unasked = first[asked].tolist(), second[asked].tolist()
        for k in np.argsort(gaps[first, second], kind="stable").tolist():
            i, j = int(first[k]), int(second[k])
            if self.items[j].hits > self.items[i].hits:
                i, j = j, i
            pair = self.items[i], self.items[j]
            decision = self._may_merge(*pair, float(gaps[i, j]), int(together[i, j]))
            if decision is not None:
                return i, j, decision
            open_[i, j] = open_[j, i] = False
        return None

    def _by_hits(self, i: int, j: int) -> tuple[Item, Item]:
        """Return two items, the larger first."""
        a, b = self.items[i], self.items[j]
        return (b, a) if b.hits > a.hits else (a, b)

    def fuse_labels(self) -> None:
        """Merge things of different classes that are one thing with a flickering label.

        They fill the same place, so that what sees one should see the other, and no view of
        several saw both.
        """
        if len(self.items) < 2:
            return
        for i, j in np.argwhere(np.triu(one_place(self.items), 1)).tolist():
            larger, smaller = self.items[i], self.items[j]
            if larger is smaller or names_agree(larger.look[0], smaller.look[0]):
                continue
            if min(larger.hits, smaller.hits) < LABEL_HITS:
                continue
            either = int((larger.seen | smaller.seen).sum())
            both = self._link * float((larger.seen & smaller.seen).sum())
            if either >= LABEL_VIEWS and not both:
                joined = self._joined(larger, smaller, measured=True)
                self.items = [joined if item in (larger, smaller) else item for item in self.items]
        self.items = list({id(item): item for item in self.items}.values())

    def _may_merge(self, larger: Item, smaller: Item, gap: float, together: int) -> bool | None:
        """Return None for no; else whether the smaller one's geometry is taken over."""
        common = int(np.count_nonzero(larger.expected & smaller.expected))
        mixed = gap < MIXED_GATE and common >= MIXED_VIEWS and together <= MIXED_SHARE * common
        if together > TOGETHER_SHARE * min(larger.hits, smaller.hits) and not mixed:
            return None
        if gap < MERGE_GATE:
            return True
        if not agree(larger, smaller):
            return None
        never_both = common >= COMMON_VIEWS and together <= TOGETHER_SHARE * common
        if mixed or (gap < MERGE_FAR_GATE and never_both):
            return True
        return self._part_of(larger, smaller) if together == 0 else None

    def _part_of(self, larger: Item, smaller: Item) -> bool | None:
        """Tell the same of two things that were never seen together."""
        if one_above(larger, smaller) or self._cut_off(larger, smaller):
            return True
        if not in_reach(larger, smaller):
            return None
        if not self._explained.knows(larger, smaller):
            pairs = zip(*self._unasked, strict=True)
            self._explained.ask([self._by_hits(i, j) for i, j in pairs])
        return False if self._explained.explains(larger, smaller) else None

    def _cut_off(self, larger: Item, smaller: Item) -> bool:
        """Tell whether one is a corner of the other: next to it, seen seldom and cut off only."""
        if smaller.hits > max(CORNER_HITS, CORNER_SHARE * larger.hits):
            return False
        t = self._table
        cut = [t.kept_border[row, : t.kept[row]] for row in smaller.rows]
        if np.concatenate(cut).mean() < CORNER_CUT:
            return False
        gap = np.maximum(
            smaller.outer_low_m - larger.outer_high_m, larger.outer_low_m - smaller.outer_high_m
        )
        size = larger.outer_high_m - larger.outer_low_m
        apart = float(np.linalg.norm(np.maximum(gap, 0)))
        reach = max(CORNER_GAP_M, CORNER_GAP_SHARE * float(size.max()))
        return float(size.max()) >= FURNITURE_M and apart <= reach

    def _joined(self, larger: Item, smaller: Item, measured: bool) -> Item:
        """Return both items as one."""
        shaping = larger.rows[: larger.shaping]
        added = smaller.rows[: smaller.shaping] if measured else []
        rest = larger.rows[larger.shaping :] + smaller.rows[len(added) :]
        shape = self._shape([*shaping, *added]) if measured else larger.shape
        return Item(
            [*shaping, *added, *rest],
            len(shaping) + len(added),
            merged_look([self._votes[row] for row in larger.rows + smaller.rows]),
            larger.seen | smaller.seen,
            larger.expected | smaller.expected if measured else larger.expected,
            larger.hits + smaller.hits,
            *shape,
        )

    def _shape(self, rows: list[int]) -> Shape:
        """Return the geometry of several tracks together."""
        t = self._table
        kept = t.kept[rows].tolist()
        step = 1 + sum(kept) // MERGED_KEPT
        places = np.concatenate([np.arange(count) for count in kept])
        at = np.repeat(rows, kept)[::step], places[::step]
        found = robust_geometry(
            t.kept_place[at].astype(np.float64)[None],
            t.kept_weight[at].astype(np.float64)[None],
            t.kept_border[at][None],
            np.ones((1, len(at[0])), dtype=bool),
        )
        low, high = found.outer_low[0], found.outer_high[0]
        return found.center[0], found.low[0], found.high[0], low, high, found.spread_m2[0]

    def prune(self) -> list[tuple[Item, list[tuple[Item, Ints]]]]:
        """Reduce to the smallest explaining set, weakest first; return what went.

        An item of whose sightings most can be read as views of others of its graph that are
        unmatched in those frames goes; the slots become the others' hits.
        """
        gone: list[tuple[Item, list[tuple[Item, Ints]]]] = []
        if len(self.items) < 2:
            return gone
        reach = reach_matrix(self.items)
        place = {id(item): k for k, item in enumerate(self.items)}
        for item in sorted(self.items, key=strength):
            near = reach[:, place[id(item)]]
            others = [
                o for o in self.items if o is not item and near[place[id(o)]] and agree(o, item)
            ]
            if not others or item.hits < 2:
                continue
            readings = self._explained.readings(item, others)
            if readings is not None:
                self.items = [other for other in self.items if other is not item]
                gone.append((item, readings))
        return gone


def _worth_asking(gaps: Floats, parts: Bools, together: Floats, least_hits: Ints) -> Bools:
    """Tell for which pairs the rules of merging may say yes: what can be told all at once."""
    near = (gaps < MERGE_GATE) | (parts & ((gaps < MERGE_FAR_GATE) | (together == 0)))
    apart = (together <= TOGETHER_SHARE * least_hits) | (gaps < MIXED_GATE)
    return np.asarray(near & (gaps < NEVER / 2) & apart)
