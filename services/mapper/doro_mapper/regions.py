"""Finder "grid": the paper's regions over the hash maps, corrected.

Paper, Section IV-B and Algorithm 1, with DESIGN's corrections: regions are grown from the
highest score down and merged by label, not by score (equal scores do not fuse); two regions
become one only across a shallow saddle and when they were not seen together in a frame
(detections of one frame are different things); evidence is absolute, so that a region does
not lose weight as instances become more; and a region that views often missed is noise.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from doro_mapper.existence import enough
from doro_mapper.finder import Found, TrackSummary, family
from doro_mapper.maps.hashmaps import HashMaps
from doro_mapper.robust import robust_geometry
from doro_mapper.settings import MapperSettings
from doro_mapper.sight import should_see
from doro_mapper.sightings import FrameSightings, Sighting
from doro_mapper.views import Camera, Floats, Views, moved_points
from doro_mapper.votes import Votes

Cell = tuple[int, int, int]
REGION_OF_WIDTH = 0.25
"""Smoothing over a region: sigma as a share of the typical width of the class's boxes."""
SADDLE = 0.4
"""Regions are one when the path between them falls by less than this share of the lower."""
FLOOR_SHARE = 0.02
CONFLICT_SHARE = 0.1
REACH_SIGMAS = 2.5
MAX_SIGMA_CELLS = 12.0
MEMBERS = 64
POINT_VIEWS = 8


@dataclass(slots=True)
class Placed:
    """A sighting and where it is, map axes.

    Attributes:
        place_m: (15,) centre, low, high, outer low, outer high.
        points_m: (k, 3).
        size_m: width and height of the box.
    """

    sighting: Sighting
    place_m: Floats
    points_m: Floats
    size_m: Floats
    at_border: bool


@dataclass(slots=True)
class Region:
    """A labelled region: its peak score and the frames whose detections peak in it."""

    peak: float
    frames: list[int] = field(default_factory=list)


class RegionFinder:
    """Regions of the stacked maps of all graph ids of a family of classes."""

    def __init__(self, settings: MapperSettings, views: Views, maps: HashMaps) -> None:
        self._settings = settings
        self._views = views
        self._maps = maps
        self._edges_m = np.array([settings.cell_m, settings.cell_m, settings.band_m])
        self._families: dict[str, list[Placed]] = {}

    def add(self, frame: FrameSightings) -> None:
        """Take the sightings of one frame; the hash maps hold them already."""
        oldest, m = self._views.oldest, frame.measured
        for key, known in self._families.items():
            if known and known[0].sighting.serial < oldest:
                self._families[key] = [one for one in known if one.sighting.serial >= oldest]
        parts = (m.center_m, m.low_m, m.high_m, m.outer_low_m, m.outer_high_m)
        places = np.concatenate(parts, axis=1)
        for k, sighting in enumerate(frame.sightings):
            placed = Placed(
                sighting,
                places[k],
                m.points_m[k].astype(np.float64),
                m.size_m[k],
                bool(m.at_border[k]),
            )
            self._families.setdefault(family(sighting.graph.name), []).append(placed)

    def lost(self) -> list[str]:
        """No ids are given here."""
        return []

    def tracks(self) -> list[TrackSummary]:
        """There are no tracks."""
        return []

    def move(self, serial: int, old: Camera, new: Camera) -> None:
        """Take the measurements of a view from one camera to another."""
        for known in self._families.values():
            for one in known:
                if one.sighting.serial == serial:
                    shift = moved_points(one.place_m[:3], old, new) - one.place_m[:3]
                    one.place_m = one.place_m + np.tile(shift, 5)
                    one.points_m = moved_points(one.points_m, old, new)

    def moved(self) -> None:
        """Regions are derived when asked."""

    def find(self) -> list[Found]:
        """Return all instances: regions with enough evidence."""
        out = []
        for key, sightings in sorted(self._families.items()):
            for members in self._regions(key, sightings):
                found = self._found(members)
                if found is not None:
                    out.append(found)
        return out

    def _regions(self, key: str, sightings: list[Placed]) -> list[list[Placed]]:
        """Return the sightings of each region."""
        ids = [i for i, graph in enumerate(self._maps.graphs) if family(graph.name) == key]
        places, weights = self._maps.stacked(ids)
        if not len(places) or not sightings:
            return []
        origin = places.min(0) - 2
        dense = np.zeros(tuple(places.max(0) - origin + 3))
        dense[tuple((places - origin).T)] = weights
        width_m = float(np.median([one.size_m.min() for one in sightings]))
        score = smoothed(
            dense, np.minimum(REGION_OF_WIDTH * width_m / self._edges_m, MAX_SIGMA_CELLS)
        )
        cores = [self._core(one, origin, score) for one in sightings]
        labels = label_regions(score, cores, [one.sighting.serial for one in sightings])
        groups: dict[int, list[Placed]] = {}
        for sighting, core in zip(sightings, cores, strict=True):
            if core in labels:
                groups.setdefault(labels[core], []).append(sighting)
        return list(groups.values())

    def _core(self, one: Placed, origin: Floats, score: Floats) -> Cell:
        """Return the cell of a detection's points with the highest score."""
        cells = np.floor(one.points_m / self._edges_m).astype(np.int64) - origin
        cells = np.clip(cells, 1, np.array(score.shape) - 2)
        best = cells[int(np.argmax(score[tuple(cells.T)]))]
        return int(best[0]), int(best[1]), int(best[2])

    def _found(self, members: list[Placed]) -> Found | None:
        """Return the instance that a region's sightings make, if they do."""
        used = members[-MEMBERS:]
        shape = robust_geometry(
            np.array([[one.place_m for one in used]]),
            np.array([[one.sighting.weight for one in used]]),
            np.array([[one.at_border for one in used]]),
            np.ones((1, len(used)), dtype=bool),
        )
        picks = np.linspace(0, len(used) - 1, min(len(used), POINT_VIEWS)).astype(int)
        points = np.concatenate([used[i].points_m[::2] for i in picks]).astype(np.float32)
        size = float(np.linalg.norm(np.maximum(shape.high[0] - shape.low[0], 0.02)))
        area = float(np.median([one.size_m.prod() for one in used]))
        expected = should_see(self._views, shape.center[0], size, area, points)
        seen = self._views.slots(sorted({one.sighting.serial for one in members}))
        misses = len(np.setdiff1d(expected, seen))
        if not enough((len(seen), misses), self._views.total, self._settings):
            return None
        votes = Votes()
        for one in members:
            votes.add(one.sighting)
        outer = (shape.outer_low[0] + shape.outer_high[0]) / 2
        return Found(
            name=votes.look()[0],
            center_m=(shape.center[0] + outer) / 2,
            low_m=shape.outer_low[0],
            high_m=shape.outer_high[0],
            hits=len(seen),
            misses=misses,
            votes=votes,
            points_m=points,
            covariance_m2=shape.spread_m2[0],
            first=min(one.sighting.serial for one in members),
        )


def smoothed(dense: Floats, sigma_cells: Floats) -> Floats:
    """Return region scores: Gaussian means along each axis, zero outside."""
    out = dense
    for axis, sigma in enumerate(sigma_cells.tolist()):
        reach = int(np.ceil(REACH_SIGMAS * sigma))
        if sigma < 0.2 or reach < 1:
            continue
        taps = np.exp(-0.5 * (np.arange(-reach, reach + 1) / sigma) ** 2)
        padded = np.pad(out, [(reach, reach) if i == axis else (0, 0) for i in range(3)])
        size = out.shape[axis]
        total = np.zeros_like(out)
        for shift, tap in enumerate((taps / taps.sum()).tolist()):
            total += tap * np.take(padded, range(shift, shift + size), axis=axis)
        out = total
    return out


def label_regions(score: Floats, cores: list[Cell], frames: list[int]) -> dict[Cell, int]:
    """Return the region of each core cell.

    Cells are taken from the highest score down. A cell without labelled neighbours opens a
    region; one between regions joins them where saddle and cannot-link allow it.

    Args:
        score: (a, b, band) scores, at least one empty cell around.
        cores, frames: by detection, its core cell and its frame.
    """
    at: dict[Cell, list[int]] = {}
    for core, frame in zip(cores, frames, strict=True):
        at.setdefault(core, []).append(frame)
    cells = np.argwhere(score > FLOOR_SHARE * score.max())
    values = score[tuple(cells.T)]
    order = np.argsort(-values, kind="stable")
    label = np.full(score.shape, -1)
    parent: list[int] = []
    regions: list[Region] = []

    def root(number: int) -> int:
        while parent[number] != number:
            number = parent[number]
        return number

    for (a, b, c), value in zip(cells[order].tolist(), values[order].tolist(), strict=True):
        around = label[max(a - 1, 0) : a + 2, max(b - 1, 0) : b + 2, max(c - 1, 0) : c + 2]
        near = sorted(
            {root(int(x)) for x in around[around >= 0]}, key=lambda x: (-regions[x].peak, x)
        )
        if not near:
            near = [len(parent)]
            parent.append(near[0])
            regions.append(Region(value))
        for other in near[1:]:
            if _one(regions[near[0]], regions[other], value):
                parent[other] = near[0]
                regions[near[0]].frames += regions[other].frames
        label[a, b, c] = near[0]
        regions[near[0]].frames += at.get((a, b, c), [])
    return {core: root(int(label[core])) for core in sorted(at) if label[core] >= 0}


def _one(higher: Region, lower: Region, saddle: float) -> bool:
    """Tell whether two touching regions are one thing."""
    shallow = lower.peak - saddle < SADDLE * lower.peak
    together = len(set(higher.frames) & set(lower.frames))
    fewest = max(1, min(len(set(higher.frames)), len(set(lower.frames))))
    return shallow and together <= CONFLICT_SHARE * fewest
