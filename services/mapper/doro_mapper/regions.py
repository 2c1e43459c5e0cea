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

from doro_mapper.finder import Found, Sighting, extent, family
from doro_mapper.hashmaps import HashMaps
from doro_mapper.merging import enough
from doro_mapper.settings import MapperSettings
from doro_mapper.track import Track
from doro_mapper.views import Floats, Views

Cell = tuple[int, int, int]
REGION_OF_WIDTH = 0.25
"""Smoothing over a region: sigma as a share of the typical width of the class's boxes."""
SADDLE = 0.4
"""Regions are one when the path between them falls by less than this share of the lower."""
FLOOR_SHARE = 0.02
CONFLICT_SHARE = 0.1
REACH_SIGMAS = 2.5
MAX_SIGMA_CELLS = 12.0


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
        self._families: dict[str, list[Sighting]] = {}

    def add(self, serial: int, sightings: list[Sighting]) -> None:
        """Take the sightings of one frame; the hash maps hold them already."""
        oldest = self._views.oldest
        for key, known in self._families.items():
            if known and known[0].serial < oldest:
                self._families[key] = [s for s in known if s.serial >= oldest]
        for sighting in sightings:
            self._families.setdefault(family(sighting.graph.name), []).append(sighting)
        del serial

    def find(self) -> list[Found]:
        """Return all instances: regions with enough evidence."""
        out = []
        for key, sightings in sorted(self._families.items()):
            for members in self._regions(key, sightings):
                found = self._found(members)
                if found is not None:
                    out.append(found)
        return out

    def _regions(self, key: str, sightings: list[Sighting]) -> list[list[Sighting]]:
        """Return the sightings of each region."""
        ids = [i for i, graph in enumerate(self._maps.graphs) if family(graph.name) == key]
        places, weights = self._maps.stacked(ids)
        if not len(places) or not sightings:
            return []
        origin = places.min(0) - 2
        dense = np.zeros(tuple(places.max(0) - origin + 3))
        dense[tuple((places - origin).T)] = weights
        width_m = float(np.median([min(s.place.size_m) for s in sightings]))
        score = smoothed(
            dense, np.minimum(REGION_OF_WIDTH * width_m / self._edges_m, MAX_SIGMA_CELLS)
        )
        cores = [self._core(s, origin, score) for s in sightings]
        labels = label_regions(score, cores, [s.serial for s in sightings])
        groups: dict[int, list[Sighting]] = {}
        for sighting, core in zip(sightings, cores, strict=True):
            if core in labels:
                groups.setdefault(labels[core], []).append(sighting)
        return list(groups.values())

    def _core(self, sighting: Sighting, origin: Floats, score: Floats) -> Cell:
        """Return the cell of a detection's points with the highest score."""
        cells = np.floor(sighting.place.points_m / self._edges_m).astype(np.int64) - origin
        cells = np.clip(cells, 1, np.array(score.shape) - 2)
        best = cells[int(np.argmax(score[tuple(cells.T)]))]
        return int(best[0]), int(best[1]), int(best[2])

    def _found(self, members: list[Sighting]) -> Found | None:
        track = Track()
        for sighting in members:
            track.add(sighting)
        seen = track.seen(self._views)
        hits = int(seen.sum())
        misses = int((track.expected(self._views) & ~seen).sum())
        if not enough(hits, misses, self._views, self._settings):
            return None
        low, high = extent([sighting.place for sighting in members])
        return Found(
            name=track.name,
            center_m=(track.center_m + (low + high) / 2) / 2,
            low_m=low,
            high_m=high,
            sightings=members,
            weights=track.weights,
            misses=misses,
            points_m=track.points_m(),
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
