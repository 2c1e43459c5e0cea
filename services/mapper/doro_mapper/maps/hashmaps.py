"""The paper's two hash maps (Section IV-B), with DESIGN's key and counts.

First map: object graph id -> its cells. Second: (graph id, ground cell a, ground cell b,
height band) -> (sum of weights, frequency, observable). Keyed by the cell alone, as the
paper has it, different objects collide. ``observable`` is how often the cell's block was in view
and not occluded (:mod:`doro_mapper.maps.blocks`), so that a one-off false positive can be told from
a thing seldom in view.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from doro_mapper.maps.blocks import Blocks
from doro_mapper.maps.cells import (
    CELLS,
    Cells,
    Ints,
    frequency_of,
    order_of,
    packed,
    runs,
    sizes,
    weight_of,
)
from doro_mapper.shots import Shot
from doro_mapper.views import Floats, Views
from doro_schemas.graph import ObjectGraph, identity, without_relations
from doro_schemas.messages import GraphEntry

Samples = tuple[Floats, Floats, Ints]
"""Points (k, 3) metres, mask of each, and the detection that it belongs to."""
Cut = tuple[NDArray[np.int32], NDArray[np.float32]]
"""Cells int32 (n, 6) and weights float32 (n,) as GridDelta has them, sorted."""


@dataclass(frozen=True, slots=True)
class _Hits:
    """What one frame adds to the map, sorted by cell, each cell once.

    Attributes:
        places: (4, n) graph, ground cell a, b, band.
        weight, often: (n,) sum of the detections' weights, and how many detections.
    """

    places: Ints
    weight: Floats
    often: Ints


class HashMaps:
    """Both maps, stored as rows of arrays behind the dictionaries; at most ``max_cells`` cells.

    Attributes:
        graphs: by id.
        cells, blocks: the second map.
        last_mass: (detections,) what each detection of the last frame added.
    """

    def __init__(self, cell_m: float, band_m: float, max_cells: int) -> None:
        self._edges_m = np.array([cell_m, cell_m, band_m])
        self.graphs: list[ObjectGraph] = []
        self._ids: dict[str, int] = {}
        self.blocks = Blocks(self._edges_m)
        self.cells = Cells(self.blocks, max_cells)
        self.cells_dropped = 0
        self.last_mass: Floats = np.zeros(0)

    def __len__(self) -> int:
        return self.cells.size

    def graph_id(self, graph: ObjectGraph) -> tuple[int, bool]:
        """Return the id of a graph's class + self attributes, and whether it is new."""
        key = identity(graph)
        found = self._ids.get(key)
        if found is not None:
            return found, False
        number = len(self.graphs)
        self._ids[key] = number
        self.graphs.append(without_relations(graph))
        return number, True

    def merge(
        self, graph_ids: Sequence[int], samples: Samples, views: Views, serial: int
    ) -> tuple[Cut, NDArray[np.int32]]:
        """Add one frame's detections; return the cells that changed and the blocks in view.

        A cell takes the mean weight of a detection's samples in it (paper).

        Args:
            graph_ids: by detection.
            samples: in the detections' windows.
            views: all views, this frame's included.
            serial: this frame.
        """
        places, numbers = self._add(graph_ids, samples, sums=False)
        hit = np.unique(self.cells.block[numbers // CELLS]).astype(np.int64)
        seen = self.blocks.observe(hit, views, serial)
        return self._cut(places, numbers), self.blocks.published(seen)

    def rebuild(self, shots: Mapping[int, Shot], views: Views) -> Cut:
        """Build the second map again from the points kept of each view, as views are placed now.

        Returns:
            cells and weights as published, those that are no longer there with frequency 0.
        """
        before, _ = self.cells.listed()
        self.cells.clear()
        for serial in sorted(shots):
            one = shots[serial]
            self._add(one.graph_ids, one.placed(views.camera(serial)), sums=True)
        self.blocks.count_again(views)
        cells, weight = self.published()
        now = packed(cells[:, :4].T.astype(np.int64))
        gone = before[:, ~np.isin(packed(before), now)]
        empty = np.zeros((gone.shape[1], 6), np.int32)
        empty[:, :4] = gone.T
        return np.concatenate([cells, empty]), np.append(weight, np.zeros(len(empty), np.float32))

    def _add(
        self, graph_ids: Sequence[int], samples: Samples, *, sums: bool
    ) -> tuple[NDArray[Any], Ints]:
        """Add to each detection's cells the mean, or else the sum, of its weights in them.

        Returns:
            places (4, n) and numbers of the cells that changed, sorted by place.
        """
        self.last_mass = np.zeros(len(graph_ids))
        if not len(samples[0]):
            return np.zeros((4, 0), np.int64), np.zeros(0, np.int64)
        hits = self._hits(graph_ids, samples, sums=sums)
        places, weight, often = hits.places, hits.weight, hits.often
        numbers = self.cells.numbers(places)
        kept = self.cells.fits(numbers)
        if not kept.all():
            self.cells_dropped += int(often[~kept].sum())
            places, numbers, weight, often = (
                places[:, kept],
                numbers[kept],
                weight[kept],
                often[kept],
            )
        self.cells.add(packed(places), numbers, weight, often)
        return places, numbers

    def _hits(self, graph_ids: Sequence[int], samples: Samples, *, sums: bool) -> _Hits:
        """Return what the detections of a frame add to which cells.

        One integer per graph, cell and detection, relative to the frame's corner, is sorted.
        """
        points_m, weights, owner = samples
        n, graphs = len(graph_ids), sorted(set(graph_ids))
        rank = np.array([graphs.index(number) for number in graph_ids])
        places: Ints = np.floor(points_m.T / self._edges_m[:, None]).astype(np.int64)
        corner = places.min(axis=1)
        _, wide, tall = (places.max(axis=1) - corner + 1).tolist()
        reach = int(places[0].max() - corner[0] + 1)
        offset = rank * (reach * wide * tall * n) + np.arange(n)
        line = np.array([wide * tall, tall, 1]) * n
        local = line @ places + (offset - line @ corner)[owner]
        order, ordered = order_of(local)
        first = runs(ordered)
        mean = np.add.reduceat(weights[order], first)
        if not sums:
            mean /= sizes(first, len(ordered))
        cell, of = np.divmod(ordered[first], n)
        self.last_mass = np.bincount(of, mean, minlength=n).astype(np.float64)
        one = runs(cell)
        often = sizes(one, len(cell))
        if len(one) < len(cell):  # several detections of one graph in one cell
            mean, cell = np.add.reduceat(mean, one), cell[one]
        places = np.empty((4, len(cell)), np.int64)
        cell, places[3] = np.divmod(cell, tall)
        cell, places[2] = np.divmod(cell, wide)
        graph, places[1] = np.divmod(cell, reach)
        places[0] = np.array(graphs)[graph]
        places[1:] += corner[:, None]
        return _Hits(places, mean, often)

    def _cut(self, places: NDArray[Any], numbers: Ints) -> Cut:
        """Return cells as published; of places sorted already."""
        own = self.cells
        value = own.value[numbers]
        often = frequency_of(value)
        out = np.empty((len(numbers), 6), np.int32)
        out[:, :4] = places.T
        out[:, 4] = often
        out[:, 5] = np.maximum(often, self.blocks.count[own.block[numbers // CELLS]])
        return out, weight_of(value).copy()

    def entries(self, first: int = 0) -> list[GraphEntry]:
        """Return the graphs from id ``first`` on."""
        return [GraphEntry(first + i, graph) for i, graph in enumerate(self.graphs[first:])]

    def published(self, graph_ids: Sequence[int] | None = None) -> Cut:
        """Return all cells, or those of some graphs (first hash map)."""
        places, numbers = self.cells.listed(None if graph_ids is None else np.array(graph_ids))
        return self._cut(places, numbers)

    def stacked(self, graph_ids: Sequence[int]) -> tuple[NDArray[np.int32], Floats]:
        """Return the places (n, 3) of several graphs and their weights summed over the graphs."""
        cells, numbers = self.cells.listed(np.array(graph_ids))
        places, inverse = np.unique(cells[1:].T, axis=0, return_inverse=True)
        total = np.bincount(
            inverse.ravel(), weight_of(self.cells.value[numbers]), minlength=len(places)
        )
        return places.astype(np.int32), total.astype(np.float64)

    def digest(self) -> str:
        """Return the digest (16 bytes, hex) over graphs, cells and blocks; equal for equal maps."""
        state = hashlib.blake2b(digest_size=16)
        state.update(repr(self._edges_m.tolist()).encode())
        for number, graph in enumerate(self.graphs):
            state.update(f"{number} {identity(graph)}\n".encode())
        state.update(self.cells.digest().astype("<u8").tobytes())
        state.update(self.blocks.digest().astype("<u8").tobytes())
        return state.hexdigest()
