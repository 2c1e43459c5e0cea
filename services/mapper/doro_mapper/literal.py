"""Finder "paper_literal": Section IV-B and Algorithm 1 exactly as the paper prints them.

For comparison. What is odd stays: Algorithm 1 looks up ``RI[index + 1]`` by the region's number
where its rank is meant; a seed is never marked as merged, so it can be merged later; scores are
the labels, so that two regions of equal score are one instance; scores are normalised over the
whole map, so that a fixed gamma suppresses the more the more instances there are; the mask's
normaliser favours small boxes. Two things cannot run as printed and are read kindly: the
projection lacks the factor d (``K^-1 [u v d]``), and maps are kept by object graph.
``literal_index = "rank"`` reads the look-up as it was meant.
"""

from __future__ import annotations

import numpy as np

from doro_mapper.finder import Found, TrackSummary
from doro_mapper.settings import MapperSettings
from doro_mapper.sightings import FrameSightings, Sighting
from doro_mapper.views import Camera, Floats
from doro_mapper.votes import Votes
from doro_schemas.graph import identity

Region = tuple[int, int]
Cell = tuple[int, int]


class GraphMap:
    """The occupancy map of one object graph: cell -> weight, weighted height, frequency."""

    def __init__(self, sighting: Sighting) -> None:
        self.cells: dict[Cell, list[float]] = {}
        self.votes = Votes()
        self.name = sighting.graph.name
        self.first = sighting.serial
        self.hits = 0

    def add(self, cells: list[Cell], weights: list[float], heights_m: list[float]) -> None:
        """Add one detection: the mean weight of the points in each cell."""
        for cell, weight, height in zip(cells, weights, heights_m, strict=True):
            known = self.cells.setdefault(cell, [0.0, 0.0, 0.0])
            known[0] += weight
            known[1] += weight * height
            known[2] += 1


class LiteralFinder:
    """The paper's grid. Memory: all cells that ever had a point, 300 bytes each."""

    def __init__(self, settings: MapperSettings) -> None:
        self._settings = settings
        self._maps: dict[str, GraphMap] = {}

    def add(self, frame: FrameSightings) -> None:
        """Add the frame's soft-masked points to the maps of their graphs."""
        m, cell_m, sigma = frame.measured, self._settings.cell_m, self._settings.sigma
        for k, sighting in enumerate(frame.sightings):
            own = m.sample_of == k
            points, weights = m.sample_points_m[own], m.sample_weights[own]
            width, height = m.box_px[k, 2:] - m.box_px[k, :2]
            weights = weights / (2 * sigma * width * sigma * height)
            cells = np.floor(points[:, :2] / cell_m).astype(np.int64)
            unique, inverse = np.unique(cells, axis=0, return_inverse=True)
            inverse = inverse.ravel()
            count = np.bincount(inverse)
            mean = np.bincount(inverse, weights) / count
            up = np.bincount(inverse, points[:, 2]) / count
            key = identity(sighting.graph)
            known = self._maps.setdefault(key, GraphMap(sighting))
            known.votes.add(sighting)
            known.hits += 1
            places = [(a, b) for a, b in unique.tolist()]
            known.add(places, mean.tolist(), up.tolist())

    def lost(self) -> list[str]:
        """No ids are given here."""
        return []

    def tracks(self) -> list[TrackSummary]:
        """There are no tracks."""
        return []

    def move(self, serial: int, old: Camera, new: Camera) -> None:
        """The paper's maps keep no frames: nothing can be taken back."""

    def moved(self) -> None:
        """Nothing is derived."""

    def find(self) -> list[Found]:
        """Return the instances: merged regions of each graph, max-pooled over a class's graphs."""
        classes: dict[str, list[GraphMap]] = {}
        for key in sorted(self._maps):
            classes.setdefault(self._maps[key].name, []).append(self._maps[key])
        return [found for name in sorted(classes) for found in self._of_class(classes[name])]

    def _of_class(self, maps: list[GraphMap]) -> list[Found]:
        pooled: dict[Region, tuple[float, GraphMap]] = {}
        for graph_map in maps:
            for region, score in self.scores(graph_map).items():
                if score > pooled.get(region, (0.0,))[0]:
                    pooled[region] = (score, graph_map)
        labels: dict[float, list[Region]] = {}
        for region in sorted(pooled):
            labels.setdefault(pooled[region][0], []).append(region)
        return [
            self._found([(region, pooled[region][1]) for region in regions])
            for _, regions in sorted(labels.items(), key=lambda item: -item[0])
        ]

    def scores(self, graph_map: GraphMap) -> dict[Region, float]:
        """Return the merged scores of a graph's regions that are above 0."""
        side = max(1, round(self._settings.region_m / self._settings.cell_m))
        sums: dict[Region, float] = {}
        for (a, b), (weight, _, _) in graph_map.cells.items():
            region = (a // side, b // side)
            sums[region] = sums.get(region, 0.0) + weight
        corner = np.array(list(sums)).min(axis=0)
        size = np.array(list(sums)).max(axis=0) - corner + 1
        dense = np.zeros(tuple(size))
        for (a, b), weight in sums.items():
            dense[a - corner[0], b - corner[1]] = weight
        by_rank = self._settings.literal_index == "rank"
        merged = algorithm_1(dense / dense.sum(), self._settings.gamma, by_rank=by_rank)
        at = np.argwhere(merged > 0)
        return {
            (int(a + corner[0]), int(b + corner[1])): float(merged[a, b]) for a, b in at.tolist()
        }

    def _found(self, regions: list[tuple[Region, GraphMap]]) -> Found:
        """Return an instance: the weighted middle of the cells in its regions.

        Regions of equal score are one instance, even those of different graphs.
        """
        settings = self._settings
        side = max(1, round(settings.region_m / settings.cell_m))
        graph_map = regions[0][1]
        own: list[tuple[float, ...]] = [
            (a, b, weight, up)
            for region, known in regions
            for (a, b), (weight, up, _) in sorted(known.cells.items())
            if (a // side, b // side) == region
        ]
        if not own:
            # As printed, a region without a cell may be given a score: its middle is all there is.
            own = [((a + 0.5) * side, (b + 0.5) * side, 1.0, 0.0) for (a, b), _ in regions]
        table = np.array(own)
        weight = table[:, 2] / table[:, 2].sum()
        ground = (table[:, :2] + 0.5) * settings.cell_m
        height = table[:, 3] / np.maximum(table[:, 2], 1e-12)
        points = np.column_stack([ground, height])
        center: Floats = weight @ points
        return Found(
            name=graph_map.name,
            center_m=center,
            low_m=points.min(axis=0),
            high_m=points.max(axis=0),
            hits=graph_map.hits,
            misses=0,
            votes=graph_map.votes,
            points_m=points.astype(np.float32),
            first=graph_map.first,
        )


def algorithm_1(scores: Floats, gamma: float, *, by_rank: bool = False) -> Floats:
    """Return the merged region scores (paper, Algorithm 1: greedy non-maximal region merging).

    Args:
        scores: (a, b) normalised occupancy O; a region's index is its place in row-major order.
        gamma: scores below it are noise.
        by_rank: take ``RI[index + 1]`` as the next in rank, not the entry after the index.
    """
    shape = scores.shape
    o = scores.ravel().copy()
    ranked = np.argsort(-o, kind="stable").tolist()
    merged: dict[int, None] = {}

    def neighbours(i: int, j: int) -> bool:
        (a, b), (c, d) = divmod(i, shape[1]), divmod(j, shape[1])
        return i != j and abs(a - c) <= 1 and abs(b - d) <= 1

    for rank, index in enumerate(ranked):
        if index in merged:
            continue
        if o[index] < gamma:
            o[index] = 0.0
            continue
        after = (rank if by_rank else index) + 1
        best = ranked[after] if after < len(ranked) else -1
        if best >= 0 and neighbours(index, best):
            o[best] = o[index]
            merged[best] = None
            continue
        for j in merged:
            if neighbours(j, index):
                o[index] = o[j]
                break
    return o.reshape(shape)
