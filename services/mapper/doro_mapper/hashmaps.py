"""The paper's two hash maps (Section IV-B), with DESIGN's key and counts.

First map: object graph id -> its cells. Second: (graph id, ground cell a, ground cell b,
height band) -> (sum of weights, frequency, observable). Keyed by the cell alone, as the
paper has it, different objects collide. ``observable`` is how often the cell was in view
and not occluded, so that a one-off false positive can be told from a thing seldom in view.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from doro_mapper.projection import Samples
from doro_mapper.views import Floats, Views
from doro_schemas.graph import ObjectGraph, identity, without_relations
from doro_schemas.messages import GraphEntry

Key = tuple[int, int, int, int]
Place = tuple[int, int, int]
OBSERVED_SLACK_M = 0.10
"""A cell behind the seen surface by less than about its diagonal counts as seen."""
INITIAL_ROOM = 1024


def _grown(array: NDArray[Any], need: int) -> NDArray[Any]:
    """Return ``array`` with room for ``need`` rows, doubled where it must grow."""
    if need <= len(array):
        return array
    bigger = np.zeros((max(need, 2 * len(array)), *array.shape[1:]), array.dtype)
    bigger[: len(array)] = array
    return bigger


class HashMaps:
    """Both maps, stored as rows of arrays behind the dictionaries.

    Memory: about 200 bytes a cell, at most ``max_cells`` cells.
    """

    def __init__(self, cell_m: float, band_m: float, max_cells: int) -> None:
        self._edges_m = np.array([cell_m, cell_m, band_m])
        self._max_cells = max_cells
        self.graphs: list[ObjectGraph] = []
        self._ids: dict[str, int] = {}
        self.cells_of: dict[int, list[int]] = {}
        self._rows: dict[Key, int] = {}
        self._keys = np.zeros((INITIAL_ROOM, 4), np.int32)
        self._weight = np.zeros(INITIAL_ROOM)
        self._frequency = np.zeros(INITIAL_ROOM, np.int32)
        self._place_of = np.zeros(INITIAL_ROOM, np.int64)
        self._places: dict[Place, int] = {}
        self._center_m = np.zeros((INITIAL_ROOM, 3))
        self._observable = np.zeros(INITIAL_ROOM, np.int32)
        self.cells_dropped = 0

    def __len__(self) -> int:
        return len(self._rows)

    def graph_id(self, graph: ObjectGraph) -> tuple[int, bool]:
        """Return the id of a graph's class + self attributes, and whether it is new."""
        key = identity(graph)
        found = self._ids.get(key)
        if found is not None:
            return found, False
        number = len(self.graphs)
        self._ids[key] = number
        self.graphs.append(without_relations(graph))
        self.cells_of[number] = []
        return number, True

    def merge(
        self, detections: Sequence[tuple[int, Samples]], views: Views, serial: int
    ) -> NDArray[np.int64]:
        """Add one frame's detections; return the rows that changed, ascending.

        Args:
            detections: graph id and samples of each.
            views: all views, this frame's included.
            serial: this frame.
        """
        hit_rows: list[NDArray[np.int64]] = []
        for graph_id, samples in detections:
            first_new = len(self._places)
            hit_rows.append(self._add(graph_id, samples))
            self._observe_past(first_new, views, serial)
        hits = np.unique(np.concatenate(hit_rows)) if hit_rows else np.zeros(0, np.int64)
        seen = self._observe_now(hits, views, serial)
        return np.flatnonzero(seen[self._place_of[: len(self._rows)]])

    def _add(self, graph_id: int, samples: Samples) -> NDArray[np.int64]:
        """Add the mean weight of the samples in each cell (paper); return the cells' rows."""
        cells = np.floor(samples.points_m / self._edges_m).astype(np.int64)
        # One integer per cell sorts an order of magnitude faster than rows of three.
        origin = cells.min(0)
        size = cells.max(0) - origin + 1
        packed = ((cells - origin) @ np.array([size[1] * size[2], size[2], 1])).astype(np.int64)
        _, first, inverse = np.unique(packed, return_index=True, return_inverse=True)
        unique = cells[first]
        mean = np.bincount(inverse, samples.weights) / np.bincount(inverse)
        rows = []
        kept = []
        for index, (a, b, band) in enumerate(unique.tolist()):
            row = self._row(graph_id, (a, b, band))
            if row is not None:
                rows.append(row)
                kept.append(index)
        out = np.asarray(rows, dtype=np.int64)
        self._weight[out] += mean[kept]
        self._frequency[out] += 1
        return out

    def _row(self, graph_id: int, place: Place) -> int | None:
        key = (graph_id, *place)
        row = self._rows.get(key)
        if row is not None:
            return row
        row = len(self._rows)
        if row >= self._max_cells:
            self.cells_dropped += 1
            return None
        if row >= len(self._weight):
            for name in ("_keys", "_weight", "_frequency", "_place_of"):
                setattr(self, name, _grown(getattr(self, name), row + 1))
        self._rows[key] = row
        self._keys[row] = key
        self._place_of[row] = self._place(place)
        self.cells_of[graph_id].append(row)
        return row

    def _place(self, place: Place) -> int:
        index = self._places.setdefault(place, len(self._places))
        if index >= len(self._observable):
            for name in ("_center_m", "_observable"):
                setattr(self, name, _grown(getattr(self, name), index + 1))
        for axis in range(3):
            self._center_m[index, axis] = (place[axis] + 0.5) * self._edges_m[axis]
        return index

    def _observe_past(self, first_new: int, views: Views, serial: int) -> None:
        """Count for new places in which earlier views they were observable."""
        centers = self._center_m[first_new : len(self._places)]
        if not len(centers):
            return
        middle = (centers.min(0) + centers.max(0)) / 2
        radius = float(np.linalg.norm(centers - middle, axis=1).max())
        slots = views.near(middle, radius)
        slots = slots[slots != views.slots([serial])[0]]
        if len(slots):
            seen, _ = views.visible(centers, slots, OBSERVED_SLACK_M)
            self._observable[first_new : len(self._places)] = seen.sum(0)

    def _observe_now(self, hits: NDArray[np.int64], views: Views, serial: int) -> NDArray[np.bool_]:
        """Count this view for all places; return which it observed. What was hit was seen."""
        n = len(self._places)
        seen = np.zeros(n, dtype=bool)
        if n:
            visible, _ = views.visible(self._center_m[:n], views.slots([serial]), OBSERVED_SLACK_M)
            seen = visible[0]
            seen[self._place_of[hits]] = True
            self._observable[:n] += seen
        return seen

    def entries(self, first: int = 0) -> list[GraphEntry]:
        """Return the graphs from id ``first`` on."""
        return [GraphEntry(first + i, graph) for i, graph in enumerate(self.graphs[first:])]

    def published(
        self, rows: NDArray[np.int64] | None = None
    ) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
        """Return (cells int32 (n, 6), weights float32 (n,)) as GridDelta has them, sorted."""
        if rows is None:
            rows = np.arange(len(self._rows), dtype=np.int64)
        keys = self._keys[rows]
        order = np.lexsort(keys.T[::-1])
        rows, keys = rows[order], keys[order]
        counts = np.stack([self._frequency[rows], self._observable[self._place_of[rows]]], axis=1)
        cells = np.concatenate([keys, counts], axis=1).astype(np.int32)
        return cells, self._weight[rows].astype(np.float32)

    def rows_of(self, graph_ids: Sequence[int]) -> NDArray[np.int64]:
        """Return the rows of several graphs (first hash map)."""
        return np.array([row for i in graph_ids for row in self.cells_of[i]], dtype=np.int64)

    def stacked(self, graph_ids: Sequence[int]) -> tuple[NDArray[np.int32], Floats]:
        """Return the places (n, 3) of several graphs and their weights summed over the graphs."""
        rows = self.rows_of(graph_ids)
        if not len(rows):
            return np.zeros((0, 3), np.int32), np.zeros(0)
        places, inverse = np.unique(self._keys[rows, 1:], axis=0, return_inverse=True)
        total = np.bincount(inverse.ravel(), self._weight[rows]).astype(np.float64)
        return places, total

    def digest(self) -> str:
        """Return the blake2b digest (16 bytes, hex) over sorted graphs and cells."""
        cells, weights = self.published()
        state = hashlib.blake2b(digest_size=16)
        state.update(repr(self._edges_m.tolist()).encode())
        for number, graph in enumerate(self.graphs):
            state.update(f"{number} {identity(graph)}\n".encode())
        state.update(np.ascontiguousarray(cells, dtype="<i4").tobytes())
        state.update(np.ascontiguousarray(weights, dtype="<f4").tobytes())
        return state.hexdigest()
