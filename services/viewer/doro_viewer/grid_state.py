"""The map's cells by class, and the frame number across episodes. No Rerun here."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from doro_schemas.messages import GraphEntry, GridDelta, GridSnapshot

Cell = tuple[int, int, int]


class GridState:
    """What the deltas add up to: occupied cells of each class.

    ``cell_m`` and ``band_m`` are those of the latest message, 0 before the first.
    """

    def __init__(self) -> None:
        self.cell_m = 0.0
        self.band_m = 0.0
        self._names: dict[int, str] = {}
        self._cells: dict[str, dict[tuple[int, Cell], int]] = {}

    def clear(self) -> list[str]:
        """Forget everything; return the classes that were there, sorted."""
        gone = sorted(self._cells)
        self._names.clear()
        self._cells.clear()
        return gone

    def apply(self, delta: GridDelta) -> list[str]:
        """Take a delta's absolute values; return the classes that changed, sorted.

        Cells of a graph that was never announced are left out: the viewer came late, and
        the core asks for a snapshot.
        """
        return self._take(delta, delta.new_graphs)

    def replace(self, snapshot: GridSnapshot) -> list[str]:
        """Take a snapshot instead of all before it; return all classes concerned, sorted."""
        gone = self.clear()
        return sorted({*gone, *self._take(snapshot, snapshot.graphs)})

    def _take(self, message: GridDelta | GridSnapshot, graphs: list[GraphEntry]) -> list[str]:
        self.cell_m, self.band_m = message.cell_m, message.band_m
        self._names.update({entry.graph_id: entry.graph.name for entry in graphs})
        touched: dict[str, None] = {}
        for graph_id, a, b, band, frequency, _ in message.cells.tolist():
            name = self._names.get(graph_id)
            if name is None:
                continue
            touched[name] = None
            cells = self._cells.setdefault(name, {})
            if frequency > 0:
                cells[graph_id, (a, b, band)] = frequency
            else:
                cells.pop((graph_id, (a, b, band)), None)
        return sorted(touched)

    def centers_m(self, name: str) -> NDArray[np.float32]:
        """Return centres of a class's cells, float32 (n, 3) in (ground a, ground b, up)."""
        cells = sorted({cell for _, cell in self._cells.get(name, {})})
        indices: NDArray[Any] = np.asarray(cells, dtype=np.float32).reshape(-1, 3)
        scale = np.array([self.cell_m, self.cell_m, self.band_m], dtype=np.float32)
        centers: NDArray[np.float32] = (indices + np.float32(0.5)) * scale
        return centers


class FrameClock:
    """One running frame number over all episodes: the timeline ``frame``.

    The first episode keeps its own numbers; each later one goes on after the one before.
    """

    def __init__(self) -> None:
        self.latest = 0
        self._episode = ""
        self._offsets: dict[str, int] = {"": 0}
        self._seen = False

    def start(self, episode: str) -> None:
        """Begin an episode; one that was there before is played again."""
        if self._seen:
            self.latest += 1
        self._seen = False
        self._episode = episode
        self._offsets[episode] = self._offsets[""] = self.latest

    def place(self, episode: str, frame: int) -> int:
        """Return a frame's running number and remember it as the latest."""
        if episode not in self._offsets:
            self.start(episode)
        position = self._offsets[episode] + max(frame, 0)
        self.latest = max(self.latest, position)
        self._seen = True
        return position
