"""The map's cells by class, and the frame number across episodes. No Rerun here."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from doro_schemas.messages import GraphEntry, GridDelta, GridSnapshot

Cell = tuple[int, ...]
"""(graph id, ground a, ground b, height band)"""


SOLID_SHARE = 0.12
"""Cells seen in less than this share of the frames that could have seen them are not drawn."""


def solid(cells: NDArray[np.int32]) -> NDArray[np.bool_]:
    """Tell of each cell (n, 6) whether it was seen often enough to be drawn, bool (n,)."""
    frequency, observable = cells[:, 4], cells[:, 5]
    often: NDArray[np.bool_] = (frequency > 0) & (frequency >= SOLID_SHARE * observable)
    return often


class GridState:
    """What the deltas add up to: the solid cells of each class.

    ``cell_m`` and ``band_m`` are those of the latest message, 0 before the first.
    """

    def __init__(self) -> None:
        self.cell_m = 0.0
        self.band_m = 0.0
        self._names: dict[int, str] = {}
        self._cells: dict[str, dict[Cell, None]] = {}

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
        changed: dict[str, None] = {}
        shown = solid(message.cells).tolist()
        for cell, is_solid in zip(map(tuple, message.cells[:, :4].tolist()), shown, strict=True):
            name = self._names.get(cell[0])
            if name is None:
                continue
            cells = self._cells.setdefault(name, {})
            if is_solid and cell not in cells:
                cells[cell] = changed[name] = None
            elif not is_solid and cell in cells:
                del cells[cell]
                changed[name] = None
        return sorted(changed)

    def centers_m(self, name: str) -> NDArray[np.float32]:
        """Return centres of a class's cells, float32 (n, 3) in (ground a, ground b, up).

        A place where two graphs of the class were seen counts twice.
        """
        rows = list(self._cells.get(name, {}))
        indices: NDArray[Any] = np.asarray(rows, dtype=np.float32).reshape(-1, 4)[:, 1:]
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
