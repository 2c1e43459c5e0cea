"""Finder "tracks": online association into object tracks, merged and pruned as they change.

In place of the paper's Algorithm 1 (MAPPER study, points 3 to 7).
"""

from __future__ import annotations

import numpy as np

from doro_mapper.assignment import assign
from doro_mapper.boxes import Boxes, covered, pair_distance
from doro_mapper.finder import (
    Found,
    Look,
    TrackSummary,
    attributes_agree,
    family,
    graph_factor,
    names_agree,
)
from doro_mapper.settings import MapperSettings
from doro_mapper.sightings import FrameSightings, Sighting
from doro_mapper.tracks.groups import Groups
from doro_mapper.tracks.items import Group
from doro_mapper.tracks.table import Ints, TrackTable, priority
from doro_mapper.views import SIGHT_M, Camera, Floats, Views
from doro_mapper.votes import Votes, merged_look

GATE = 1.0
REPROJECTED_SHARE = 0.5
REPROJECTED_RATIO = 4.0
REPROJECTED_HITS = 3
HOPELESS_SHARE = 0.1
HOPELESS_VIEWS = 12


class TrackFinder:
    """Object tracks, associated by family of classes.

    Every frame pays for the tracks that it touches; what was found is read, not searched.
    """

    def __init__(self, settings: MapperSettings, views: Views) -> None:
        self._settings = settings
        self._views = views
        self._table = TrackTable(views, observes="observability" not in settings.without)
        self._first_only = "voting" in settings.without
        self._votes: dict[int, Votes] = {}
        self._family: dict[int, str] = {}
        self._kin: dict[str, dict[int, None]] = {}
        self._groups = Groups(settings, views, self._table, self._votes)

    def add(self, frame: FrameSightings) -> None:
        """Associate one frame's sightings, one per track; update what depends on them."""
        table, serial = self._table, frame.serial
        slot = int(self._views.slots([serial])[0])
        table.open_slot(slot)
        if frame.sightings:
            owner, measured = self._associate(frame)
            table.hit(owner, slot, serial)
            for row, sighting in zip(owner.tolist(), frame.sightings, strict=True):
                if not (self._first_only and self._votes[row].names):
                    self._votes[row].add(sighting)
            which = np.flatnonzero(measured)
            key = priority(frame.camera, frame.frame)
            table.add(owner[which], which, frame.measured, frame.weights(), key)
            table.look(serial)
            for row in table.stale(owner).tolist():
                table.look_back(row)
        else:
            table.look(serial)
        self._retire()
        self._update()

    def _update(self) -> None:
        for row in self._groups.update():
            self._forget(row)

    def _associate(self, frame: FrameSightings) -> tuple[Ints, np.ndarray]:
        """Return by sighting its track's row, and whether it tells geometry."""
        sightings = frame.sightings
        matched = self._nearest(frame)
        reprojected = self._reproject(frame, matched)
        owner = np.zeros(len(sightings), dtype=np.int64)
        measured = np.ones(len(sightings), dtype=bool)
        for index, sighting in enumerate(sightings):
            if index in matched:
                owner[index] = matched[index]
            elif index in reprojected:
                owner[index] = reprojected[index]
                measured[index] = False
            else:
                owner[index] = row = self._table.new_row()
                self._votes[row] = Votes()
                self._family[row] = family(sighting.graph.name)
                self._kin.setdefault(self._family[row], {})[row] = None
        return owner, measured

    def _nearest(self, frame: FrameSightings) -> dict[int, int]:
        """Return the tracks nearest to the sightings, one to one, family by family."""
        own = [family(sighting.graph.name) for sighting in frame.sightings]
        kin = {name: sorted(self._kin.get(name, ())) for name in dict.fromkeys(own)}
        rows = np.array([row for name in own for row in kin[name]], dtype=np.int64)
        if not len(rows):
            return {}
        which = np.repeat(np.arange(len(own)), [len(kin[name]) for name in own])
        m = frame.measured
        measured = Boxes(m.center_m[which], m.low_m[which], m.high_m[which])
        costs = pair_distance(measured, self._table.boxes(rows), m.range_m[which])
        blocks: dict[str, list[tuple[int, int, float]]] = {}
        for k in np.flatnonzero(costs < GATE).tolist():
            index, row = int(which[k]), int(rows[k])
            graph = frame.sightings[index].graph
            look = graph.name, graph.attributes
            cost = float(costs[k]) * graph_factor(look, self._votes[row].look())
            if cost < GATE:
                blocks.setdefault(own[index], []).append((index, row, cost))
        out: dict[int, int] = {}
        for block in blocks.values():
            out.update(_solve(block))
        return out

    def _reproject(self, frame: FrameSightings, matched: dict[int, int]) -> dict[int, int]:
        """Return unmatched sightings that lie where an unmatched track projects to.

        They count as hits but tell no geometry: their depth fell on something else.
        """
        left = [i for i in range(len(frame.sightings)) if i not in matched]
        table = self._table
        if not left or not table.n:
            return {}
        taken = set(matched.values())
        names = dict.fromkeys(family(frame.sightings[i].graph.name) for i in left)
        kin = sorted(row for name in names for row in self._kin.get(name, ()) if row not in taken)
        rows = np.array(kin, dtype=np.int64)
        rows = rows[table.hits[rows] >= REPROJECTED_HITS]
        away = table.center_m[rows] - self._views.position_m(frame.serial)
        rows = rows[np.sqrt((away * away).sum(axis=1)) <= SIGHT_M]
        if not len(rows):
            return {}
        slots = self._views.slots([frame.serial] * len(rows))
        boxes, shows = self._views.project_boxes(table.low_m[rows], table.high_m[rows], slots)
        own = frame.measured.box_px[left]
        share, ratio = covered(own[:, None], boxes[None])
        fits = shows & (share >= REPROJECTED_SHARE) & (ratio < REPROJECTED_RATIO)
        gaps = np.linalg.norm(
            table.center_m[rows][None] - frame.measured.center_m[left][:, None], axis=2
        )
        out: dict[int, int] = {}
        for k, index in enumerate(left):
            options = sorted((float(gaps[k, j]), int(rows[j])) for j in np.flatnonzero(fits[k]))
            for _, row in options:
                if row not in out.values() and self._same(frame.sightings[index], row):
                    out[index] = row
                    break
        return out

    def _same(self, sighting: Sighting, row: int) -> bool:
        """Tell whether nothing in a sighting's graph contradicts the track's."""
        look: Look = self._votes[row].look()
        graph = sighting.graph
        return names_agree(graph.name, look[0]) and attributes_agree(graph.attributes, look[1])

    def _retire(self) -> None:
        """Forget tracks that views have looked for in vain, and the weakest beyond the bound.

        What is part of something, or was given an id, goes only beyond the bound.
        """
        table = self._table
        rows = table.rows
        hits, misses = table.hits[rows], table.misses[rows]
        hopeless = (hits < HOPELESS_SHARE * (hits + misses)) & (misses >= HOPELESS_VIEWS)
        dropped = [row for row in rows[hopeless].tolist() if self._groups.is_loose(row)]
        for row in dropped:
            self._drop(row)
        over = len(rows) - len(dropped) - self._settings.max_tracks
        if over > 0:
            rows = table.rows
            value = table.hits[rows] / (table.hits[rows] + table.misses[rows] + 2.0)
            for row in rows[np.lexsort((table.last_hit[rows], value))[:over]].tolist():
                self._drop(row)

    def _drop(self, row: int) -> None:
        self._groups.drop(row)
        self._forget(row)

    def _forget(self, row: int) -> None:
        self._table.drop(row)
        name = self._family.pop(row)
        del self._votes[row], self._kin[name][row]
        if not self._kin[name]:
            del self._kin[name]

    def find(self) -> list[Found]:
        """Return all instances; reads what the frames have left."""
        return self._groups.found()

    def lost(self) -> list[str]:
        """Return ids that were given to tracks forgotten since."""
        return self._groups.lost()

    def tracks(self) -> list[TrackSummary]:
        """Return what the tracks stand for, in order of their main tracks."""
        return [self._summary(group) for group in self._groups.things()]

    def _summary(self, group: Group) -> TrackSummary:
        table, item, row = self._table, group.item, group.main
        rows = [*item.rows, *group.absorbed]
        votes = [self._votes[one] for one in item.rows]
        name, attributes = votes[0].look() if len(votes) == 1 else merged_look(votes)
        alone = len(item.rows) == 1
        slots = np.flatnonzero(table.seen[rows].any(axis=0))
        hits, misses = self._groups.counted(group)
        return TrackSummary(
            key=(row, int(table.birth[row])),
            name=name,
            attributes=attributes,
            related=any(vote.stated for vote in votes),
            center_m=(table.center_m[row] if alone else item.center_m).copy(),
            low_m=(table.low_m[row] if alone else item.low_m).copy(),
            high_m=(table.high_m[row] if alone else item.high_m).copy(),
            hits=hits,
            misses=misses,
            spread_m=float(np.sqrt(np.trace(table.spread_m2[row] if alone else item.spread_m2))),
            serials=self._views.serials(slots),
        )

    def move(self, serial: int, old: Camera, new: Camera) -> None:
        """Take the measurements of a view from one camera to another."""
        self._table.move(serial, old, new)

    def moved(self) -> None:
        """Derive everything again from measurements whose cameras were corrected."""
        rows = self._table.rows
        if len(rows):
            self._table.refresh(rows)
            for row in rows.tolist():
                self._table.look_back(row)
            self._update()


def _solve(block: list[tuple[int, int, float]]) -> dict[int, int]:
    """Return the one-to-one choice of least cost among (sighting, row, cost)."""
    indices = sorted({index for index, _, _ in block})
    rows = sorted({row for _, row, _ in block})
    if len(indices) == len(rows) == len(block):
        return {index: row for index, row, _ in block}
    costs: Floats = np.zeros((len(indices), len(rows)))
    for index, row, cost in block:
        costs[indices.index(index), rows.index(row)] = cost - GATE
    return {indices[i]: rows[j] for i, j in assign(costs) if costs[i, j] < 0}
