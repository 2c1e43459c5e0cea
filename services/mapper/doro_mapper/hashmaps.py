"""The paper's two hash maps (Section IV-B), with DESIGN's key and counts.

First map: object graph id -> its cells. Second: (graph id, ground cell a, ground cell b,
height band) -> (sum of weights, frequency, observable). Keyed by the cell alone, as the
paper has it, different objects collide. ``observable`` is how often the cell's block was in view
and not occluded (:mod:`doro_mapper.blocks`), so that a one-off false positive can be told from
a thing seldom in view.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from doro_mapper.blocks import Blocks
from doro_mapper.digest import row_hashes
from doro_mapper.shots import Shot
from doro_mapper.views import Floats, Views
from doro_schemas.graph import ObjectGraph, identity, without_relations
from doro_schemas.messages import GraphEntry

INITIAL_ROOM = 1024
HASH_BATCH = 2048
"""Changed cells that are hashed together: asking for the digest costs no more than these."""

Ints = NDArray[np.int64]


def packed(graph_ids: Ints, places: NDArray[Any]) -> Ints:
    """Return (graph, cell a, cell b, band) as one integer each.

    Exact for 65,536 graphs, cells within 2^17 of the origin and bands within 2^10.
    """
    a, b, band = (places[:, k].astype(np.int64) for k in range(3))
    ground = ((a + (1 << 17)) << 18) + b + (1 << 17)
    return np.asarray((graph_ids << 47) + (ground << 11) + band + (1 << 10))


def _grown(array: NDArray[Any], need: int) -> NDArray[Any]:
    """Return ``array`` with room for ``need`` rows, doubled where it must grow."""
    if need <= len(array):
        return array
    bigger = np.zeros((max(need, 2 * len(array)), *array.shape[1:]), array.dtype)
    bigger[: len(array)] = array
    return bigger


Samples = tuple[Floats, Floats, Ints]
"""Points (k, 3) metres, mask of each, and the detection that it belongs to."""


class HashMaps:
    """Both maps, stored as rows of arrays behind the dictionaries.

    Memory: about 150 bytes a cell, at most ``max_cells`` cells.
    """

    def __init__(self, cell_m: float, band_m: float, max_cells: int) -> None:
        self._edges_m = np.array([cell_m, cell_m, band_m])
        self._max_cells = max_cells
        self.graphs: list[ObjectGraph] = []
        self._ids: dict[str, int] = {}
        self._rows: dict[int, int] = {}
        self._cells_of: list[list[int]] = []
        self._size = 0
        self._keys = np.zeros((INITIAL_ROOM, 4), np.int32)
        self._weight = np.zeros(INITIAL_ROOM)
        self._frequency = np.zeros(INITIAL_ROOM, np.int32)
        self._block_of = np.zeros(INITIAL_ROOM, np.int32)
        self.blocks = Blocks(self._edges_m)
        self._sum = np.zeros(2, np.uint64)
        self._hashed = np.zeros((INITIAL_ROOM, 2), np.uint64)
        self._unhashed: list[Ints] = []
        self._waiting = 0
        self.cells_dropped = 0
        self.last_mass: Floats = np.zeros(0)

    def __len__(self) -> int:
        return self._size

    def graph_id(self, graph: ObjectGraph) -> tuple[int, bool]:
        """Return the id of a graph's class + self attributes, and whether it is new."""
        key = identity(graph)
        found = self._ids.get(key)
        if found is not None:
            return found, False
        number = len(self.graphs)
        self._ids[key] = number
        self.graphs.append(without_relations(graph))
        self._cells_of.append([])
        return number, True

    def merge(
        self, graph_ids: Sequence[int], samples: Samples, views: Views, serial: int
    ) -> tuple[Ints, Ints]:
        """Add one frame's detections; return (rows, blocks) that changed, ascending.

        A cell takes the mean weight of a detection's samples in it (paper).

        Args:
            graph_ids: by detection.
            samples: in the detections' windows.
            views: all views, this frame's included.
            serial: this frame.
        """
        rows = self._add(graph_ids, samples, sums=False)
        hit_blocks = np.unique(self._block_of[rows]).astype(np.int64)
        seen = self.blocks.observe(hit_blocks, views, serial)
        return rows, seen

    def rebuild(
        self, shots: Mapping[int, Shot], views: Views
    ) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
        """Build the second map again from the points kept of each view, as views are placed now.

        Returns:
            cells and weights as published, those that are no longer there with frequency 0.
        """
        before = self._keys[: self._size].copy()
        self._rows = {}
        self._cells_of = [[] for _ in self.graphs]
        self._size = 0
        self._weight[:] = self._frequency[:] = 0
        self._hashed[:] = 0
        self._sum[:] = 0
        self._unhashed, self._waiting = [], 0
        for serial in sorted(shots):
            one = shots[serial]
            self._add(one.graph_ids, one.placed(views.camera(serial)), sums=True)
        self.blocks.count_again(views)
        cells, weight = self.published()
        now = {tuple(key) for key in self._keys[: self._size].tolist()}
        gone = [key for key in before.tolist() if tuple(key) not in now]
        empty = np.zeros((len(gone), 6), np.int32)
        empty[:, :4] = np.array(gone, np.int32).reshape(-1, 4)
        return np.concatenate([cells, empty]), np.append(weight, np.zeros(len(gone), np.float32))

    def _add(self, graph_ids: Sequence[int], samples: Samples, *, sums: bool) -> Ints:
        """Add to each detection's cells the mean, or else the sum, of its weights in them."""
        self.last_mass = np.zeros(len(graph_ids))
        points_m, weights, owner = samples
        if not len(points_m):
            return np.zeros(0, np.int64)
        places: Ints = np.floor(points_m / self._edges_m).astype(np.int64)
        # Within a frame: one integer per detection and cell, relative to the frame's corner.
        corner = places.min(0)
        size = places.max(0) - corner + 1
        local = (places - corner) @ np.array([size[1] * size[2], size[2], 1])
        local = local + owner * int(size.prod())
        order = np.argsort(local, kind="stable")
        ordered = local[order]
        first = np.flatnonzero(np.concatenate([[True], ordered[1:] != ordered[:-1]]))
        mean = np.add.reduceat(weights[order], first)
        if not sums:
            mean /= np.diff(np.append(first, len(ordered)))
        one = order[first]
        mass = np.bincount(owner[one], mean, minlength=len(graph_ids))
        self.last_mass = mass.astype(np.float64)
        rows = self._found(graph_ids, owner[one], places[one])
        kept = rows >= 0
        self.cells_dropped += int((~kept).sum())
        rows, mean = rows[kept], mean[kept]
        np.add.at(self._weight, rows, mean)
        np.add.at(self._frequency, rows, 1)
        rows = np.unique(rows)
        self._unhashed.append(rows)
        self._waiting += len(rows)
        if self._waiting > HASH_BATCH:
            self._hash()
        return rows

    def _found(self, graph_ids: Sequence[int], owner: Ints, places: Ints) -> Ints:
        """Return the rows of cells, new ones included; -1 where there is no room."""
        graphs = np.asarray(graph_ids, dtype=np.int64)[owner]
        keys = packed(graphs, places).tolist()
        known = self._rows
        rows = np.array([known.get(key, -1) for key in keys], dtype=np.int64)
        fresh: list[int] = []
        for index in np.flatnonzero(rows < 0).tolist():
            row = known.get(keys[index], -1)  # opened by an earlier detection of this frame
            if row < 0 and self._size + len(fresh) < self._max_cells:
                known[keys[index]] = row = self._size + len(fresh)
                fresh.append(index)
            rows[index] = row
        if fresh:
            self._open(graphs[fresh], places[fresh])
        return rows

    def _open(self, graph_ids: Ints, places: Ints) -> None:
        """Fill in the rows of new cells."""
        first, self._size = self._size, self._size + len(places)
        for row, number in enumerate(graph_ids.tolist(), first):
            self._cells_of[number].append(row)
        for name in ("_keys", "_weight", "_frequency", "_block_of", "_hashed"):
            setattr(self, name, _grown(getattr(self, name), self._size))
        self._keys[first : self._size, 0] = graph_ids
        self._keys[first : self._size, 1:] = places
        self._block_of[first : self._size] = self.blocks.of(places)

    def entries(self, first: int = 0) -> list[GraphEntry]:
        """Return the graphs from id ``first`` on."""
        return [GraphEntry(first + i, graph) for i, graph in enumerate(self.graphs[first:])]

    def published(self, rows: Ints | None = None) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
        """Return (cells int32 (n, 6), weights float32 (n,)) as GridDelta has them, sorted."""
        if rows is None:
            rows = np.arange(self._size, dtype=np.int64)
        keys = self._keys[rows]
        order = np.lexsort(keys.T[::-1])
        rows, keys = rows[order], keys[order]
        often = np.maximum(self._frequency[rows], self.blocks.count[self._block_of[rows]])
        cells = np.concatenate([keys, self._frequency[rows, None], often[:, None]], axis=1)
        return cells.astype(np.int32), self._weight[rows].astype(np.float32)

    def rows_of(self, graph_ids: Sequence[int]) -> Ints:
        """Return the rows of several graphs (first hash map)."""
        rows = [row for number in graph_ids for row in self._cells_of[number]]
        return np.array(rows, dtype=np.int64)

    def stacked(self, graph_ids: Sequence[int]) -> tuple[NDArray[np.int32], Floats]:
        """Return the places (n, 3) of several graphs and their weights summed over the graphs."""
        rows = self.rows_of(graph_ids)
        if not len(rows):
            return np.zeros((0, 3), np.int32), np.zeros(0)
        places, inverse = np.unique(self._keys[rows, 1:], axis=0, return_inverse=True)
        total = np.bincount(inverse.ravel(), self._weight[rows]).astype(np.float64)
        return places, total

    def digest(self) -> str:
        """Return the digest (16 bytes, hex) over graphs, cells and blocks; equal for equal maps.

        Sums of hashes of single cells, so that only cells changed since are hashed again.
        """
        self._hash()
        state = hashlib.blake2b(digest_size=16)
        state.update(repr(self._edges_m.tolist()).encode())
        for number, graph in enumerate(self.graphs):
            state.update(f"{number} {identity(graph)}\n".encode())
        state.update(self._sum.astype("<u8").tobytes())
        state.update(self.blocks.digest().astype("<u8").tobytes())
        return state.hexdigest()

    def _hash(self) -> None:
        """Bring the sum of hashes up to date."""
        if not self._unhashed:
            return
        rows = np.unique(np.concatenate(self._unhashed))
        self._unhashed, self._waiting = [], 0
        counts = np.column_stack([self._keys[rows], self._frequency[rows]])
        fresh = row_hashes(counts, self._weight[rows])
        self._sum += fresh.sum(axis=0, dtype=np.uint64)
        self._sum -= self._hashed[rows].sum(axis=0, dtype=np.uint64)
        self._hashed[rows] = fresh
