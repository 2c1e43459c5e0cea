"""Which tracks make up which thing, kept up to date frame by frame; ids that stay.

A track's neighbourhood is looked at again when its geometry changed or its views grew by a
quarter since the last time: often at first, then ever less, whatever the length of the run.
"""

from __future__ import annotations

import numpy as np

from doro_mapper.boxes import distance
from doro_mapper.existence import has_gone
from doro_mapper.finder import Found, family
from doro_mapper.settings import MapperSettings
from doro_mapper.tracks.belief import Belief
from doro_mapper.tracks.folding import fold_group
from doro_mapper.tracks.items import MERGE_RANGE_M, PRUNE_REACH_M, Group, counted, item_of
from doro_mapper.tracks.merging import MERGE_FAR_GATE, Cluster
from doro_mapper.tracks.table import Ints, TrackTable
from doro_mapper.views import Bools, Floats, Views
from doro_mapper.votes import Votes, merged

GROWTH = 1.25
FOLD_HITS = 3
"""A thing with a track of so many views takes small pieces in for good."""
LABEL_GATE, LABEL_REACH = 0.5, 0.35
MOVED_M, MOVED_SHARE = 0.02, 0.05
MAX_LOST = 256
COUNTED = ("hits", "misses", "version", "run", "empty_run")
MAX_FORMER = 8
SMALL_M = 0.5
"""Larger things hide behind each other too much for misses alone to say that one has gone."""


class Groups:
    """The things that tracks stand for, and their ids."""

    def __init__(
        self,
        settings: MapperSettings,
        views: Views,
        table: TrackTable,
        votes: dict[int, Votes],
    ) -> None:
        self._settings = settings
        self._views = views
        self._table = table
        self._votes = votes
        self._near: Bools = np.zeros((0, 0), dtype=bool)
        self._placed_m: Floats = np.zeros((0, 4))
        self._head: list[str] = []
        self._judged_hits: Ints = np.zeros(0, dtype=np.int64)
        self._groups: dict[int, Group] = {}
        self._group_of: dict[int, int] = {}
        self._ids: dict[int, str] = {}
        self._counts: dict[str, int] = {}
        self._lost: dict[str, None] = {}
        self._cache: dict[int, Found] = {}
        self._former: dict[int, list[str]] = {}
        self._unfolded: dict[int, None] = {}
        self._belief = Belief(settings, views, table, votes, self._groups)

    def is_loose(self, row: int) -> bool:
        """Tell whether a row stands for itself alone and has no id."""
        group = self._groups.get(self._group_of.get(row, -1))
        alone = group is not None and len(group.item.rows) == 1 and not group.absorbed
        return alone and row not in self._ids

    def update(self) -> list[int]:
        """Take account of what the last frame changed; return rows that are part of others now.

        The caller drops these from the table.
        """
        self._grow()
        rows = self._table.rows
        changed = self._moved(rows)
        grown = rows[self._table.hits[rows] >= GROWTH * self._judged_hits[rows]]
        grown = grown[self._table.hits[grown] != self._judged_hits[grown]]
        if len(changed):
            self._place(changed, rows)
        pending = dict.fromkeys(np.union1d(changed, grown).tolist())
        while pending:
            cluster = self._cluster(next(iter(pending)))
            for row in cluster:
                pending.pop(row, None)
            self._judge(cluster)
        self._number()
        return self._fold()

    def _fold(self) -> list[int]:
        """Take small pieces into the main tracks of things that are well seen."""
        table, gone = self._table, []
        for main in sorted(self._unfolded):
            group = self._groups.get(main)
            if group is None or table.hits[main] < FOLD_HITS:
                continue
            if any(self._head[row] != self._head[main] for row in group.item.rows):
                continue  # a flickering label: the other name needs its track to be found by
            minor = fold_group(table, self._votes, group)
            self._inherit(main, minor)
            gone += minor
        self._unfolded.clear()
        return gone

    def _inherit(self, main: int, rows: list[int]) -> None:
        """Give a thing the ids of the tracks that went into it: the first, or as former ones."""
        for row in rows:
            self._group_of.pop(row, None)
            self._cache.pop(row, None)
            self._near[row] = self._near[:, row] = False
            self._placed_m[row] = np.inf
            self._judged_hits[row] = 0
            names = [self._ids.pop(row)] if row in self._ids else []
            names += self._former.pop(row, [])
            if names and main not in self._ids:
                self._ids[main] = names.pop(0)
            self._former.setdefault(main, []).extend(names)
            del self._former[main][MAX_FORMER:]

    def _grow(self) -> None:
        room = len(self._table.alive)
        if room > len(self._near):
            near = np.zeros((room, room), dtype=bool)
            near[: len(self._near), : len(self._near)] = self._near
            self._near = near
            more = room - len(self._placed_m)
            self._placed_m = np.concatenate([self._placed_m, np.full((more, 4), np.inf)])
            self._head += [""] * more
            self._judged_hits = np.concatenate([self._judged_hits, np.zeros(more, np.int64)])

    def _moved(self, rows: Ints) -> Ints:
        """Return the rows that are elsewhere, or larger or smaller, than when last placed."""
        size = self._table.size_m(rows)
        now = np.column_stack([self._table.center_m[rows], size])
        away = np.abs(now - self._placed_m[rows]).max(axis=1)
        return np.asarray(rows[away > MOVED_M + MOVED_SHARE * size])

    def _place(self, changed: Ints, rows: Ints) -> None:
        """Find the neighbours of tracks whose geometry changed."""
        table = self._table
        boxes, others = table.boxes(changed), table.boxes(rows)
        gaps = distance(boxes, others, np.full(len(changed), MERGE_RANGE_M))
        off = boxes.center_m[:, None] - others.center_m[None]
        apart = np.sqrt((off * off).sum(axis=2))
        size, other = table.size_m(changed), table.size_m(rows)
        self._placed_m[changed] = np.column_stack([boxes.center_m, size])
        reach = PRUNE_REACH_M + 2 * np.maximum(size[:, None], other[None])
        for row in changed.tolist():
            self._head[row] = family(self._votes[row].look()[0])
        codes: dict[str, int] = {}
        heads = np.array([codes.setdefault(self._head[row], len(codes)) for row in rows.tolist()])
        same = heads[np.searchsorted(rows, changed), None] == heads[None]
        near = same & ((gaps < MERGE_FAR_GATE) | (apart <= reach))
        near |= (gaps < LABEL_GATE) & (
            apart <= LABEL_REACH * np.minimum(size[:, None], other[None])
        )
        near &= changed[:, None] != rows[None]
        self._near[changed[:, None], rows] = near
        self._near[rows[:, None], changed] = near.T

    def _cluster(self, row: int) -> list[int]:
        """Return a row, its neighbours, theirs, and what is of one thing with any of them.

        Not all that is connected: a wall of cabinet doors would be one neighbourhood.
        """
        near = np.flatnonzero(self._near[row])
        found = dict.fromkeys([row, *near.tolist()])
        found.update(dict.fromkeys(np.flatnonzero(self._near[near].any(axis=0)).tolist()))
        for main in list(dict.fromkeys(self._group_of.get(one, -1) for one in found)):
            group = self._groups.get(main)
            if group is not None:
                found.update(dict.fromkeys([*group.item.rows, *group.absorbed]))
        return sorted(found)

    def _judge(self, rows: list[int]) -> None:
        """Merge and prune a cluster of tracks anew."""
        table = self._table
        self._judged_hits[rows] = table.hits[rows]
        for row in rows:
            self._groups.pop(self._group_of.pop(row, -1), None)
        if len(rows) == 1:
            self._keep(Group(item_of(rows[0], table, self._votes[rows[0]]), None, []))
            return
        cannot_link = "cannot_link" not in self._settings.without
        cluster = Cluster(rows, table, self._views, self._votes, cannot_link)
        cluster.merge()
        cluster.fuse_labels()
        gone = cluster.prune()
        groups = {id(item): Group(item, None, []) for item in cluster.items}
        for item, readings in gone:
            for other, slots in readings:
                group = groups.get(id(other))
                if group is not None:
                    read = np.zeros(table.seen.shape[1], dtype=bool)
                    read[slots] = True
                    group.read = read if group.read is None else group.read | read
            heirs = [groups[id(other)] for other, _ in readings if id(other) in groups]
            if heirs:
                heirs[0].absorbed += item.rows
                for row in item.rows:
                    self._group_of[row] = heirs[0].main
        for group in groups.values():
            self._keep(group)

    def _keep(self, group: Group) -> None:
        self._groups[group.main] = group
        if len(group.item.rows) > 1 or group.absorbed:
            self._unfolded[group.main] = None
        for row in group.item.rows:
            self._group_of[row] = group.main

    def drop(self, row: int) -> None:
        """Forget a track that is about to go; its group falls apart."""
        self._belief.drop(row)
        self._grow()  # a track may go in the frame that opened it
        self._near[row] = self._near[:, row] = False
        self._placed_m[row] = np.inf
        self._judged_hits[row] = 0
        group = self._groups.pop(self._group_of.pop(row, -1), None)
        names = [self._ids.pop(row)] if row in self._ids else []
        self._lost.update(dict.fromkeys([*names, *self._former.pop(row, [])]))
        for name in list(self._lost)[:-MAX_LOST]:
            del self._lost[name]
        if group is not None:
            for other in (*group.item.rows, *group.absorbed):
                self._group_of.pop(other, None)
                self._judged_hits[other] = 0
        self._cache.pop(row, None)

    def things(self) -> list[Group]:
        """Return all groups in order of their main tracks."""
        return [self._groups[main] for main in sorted(self._groups)]

    def counted(self, group: Group) -> tuple[int, int]:
        """Return (hits, misses) of a group as of now."""
        return counted(group, self._table)

    def _number(self) -> None:
        """Give ids to things that now count as instances, in order of their first track."""
        table = self._table
        self._belief.judge_singles()
        least = 1 if self._belief.singles_trusted else self._settings.min_hits
        able = (table.hits[: table.n] >= least).tolist()
        long = self._views.total >= self._settings.few_views
        for main in sorted(main for main in self._groups if main not in self._ids):
            group = self._groups[main]
            rows = group.item.rows
            seldom = long and len(rows) == 1 and group.read is None and not able[main]
            if seldom or any(row in self._ids for row in rows):
                continue
            if self._belief.enough(group, self.counted(group)):
                name = self._votes[main].look()[0].replace(" ", "-")
                self._counts[name] = self._counts.get(name, 0) + 1
                self._ids[main] = f"{name}-{self._counts[name]}"

    def lost(self) -> list[str]:
        """Return ids of tracks that were forgotten, the latest."""
        return list(self._lost)

    def found(self) -> list[Found]:
        """Return all instances, tentative and gone ones included, in order of their tracks."""
        t = self._table
        columns = {name: getattr(t, name)[: t.n].tolist() for name in COUNTED}
        return [self._found(group, columns) for group in self.things()]

    def _found(self, group: Group, columns: dict[str, list[int]]) -> Found:
        """Return one instance; ``columns`` of the table."""
        hit, missed, version, runs, empties = (columns[name] for name in COUNTED)
        rows = group.item.rows
        if len(rows) == 1 and group.read is None:
            hits, misses = hit[rows[0]], missed[rows[0]]
        else:
            hits, misses = self.counted(group)
        total, changes = sum(hit[row] for row in rows), sum(version[row] for row in rows)
        known = self._cache.get(group.main)
        if known is None or known.version != (hits, misses, total, changes, *rows):
            known = self._built(group, hits, misses, (hits, misses, total, changes, *rows))
            self._cache[group.main] = known
        known.tentative = not known.instance_id or not self._belief.enough(group, (hits, misses))
        run, empty = min(runs[row] for row in rows), min(empties[row] for row in rows)
        known.gone = has_gone(hits, misses, run if known.small else 0, run, empty)
        return known

    def _built(self, group: Group, hits: int, misses: int, version: tuple[int, ...]) -> Found:
        item, table = group.item, self._table
        rows = item.rows
        votes = self._votes[rows[0]] if len(rows) == 1 else merged(self._votes[r] for r in rows)
        if len(rows) == 1:
            item = item_of(rows[0], table, self._votes[rows[0]])
        names = [self._ids[row] for row in rows if row in self._ids]
        absorbed = [self._ids[row] for row in group.absorbed if row in self._ids]
        return Found(
            name=votes.look()[0],
            center_m=(item.center_m + (item.outer_low_m + item.outer_high_m) / 2) / 2,
            low_m=item.outer_low_m,
            high_m=item.outer_high_m,
            hits=hits,
            misses=misses,
            votes=votes,
            points_m=np.concatenate([table.probe_m[row] for row in rows[: item.shaping]]),
            covariance_m2=item.spread_m2,
            small=float(np.linalg.norm(item.outer_high_m - item.outer_low_m)) < SMALL_M,
            instance_id=names[0] if names else "",
            version=version,
            replaced=(*names[1:], *absorbed, *self._former.get(rows[0], [])),
        )
