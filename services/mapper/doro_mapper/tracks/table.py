"""All object tracks of an area as arrays: one row a track, so that a frame touches all at once.

Each track keeps a bounded sample of its measurements: the KEPT with the lowest hash of camera and
frame. The sample is uniform over the views, does not depend on their order, and changes ever
less often as views become more; so does everything that is derived from it.
"""

from __future__ import annotations

import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from doro_mapper.boxes import Boxes
from doro_mapper.projection import KEPT_POINTS, Measured
from doro_mapper.robust import robust_geometry
from doro_mapper.sight import EXPECT_SHARE, large_enough, should_see
from doro_mapper.views import NEAREST_M, SIGHT_M, Bools, Camera, Floats, Views, moved_points

KEPT = 40
WITH_POINTS = 8
FIRST_ROOM = 32
EMPTY_SHARE = 0.6
MOVED_M = 0.03
GROWN = 0.15
FIBONACCI = frozenset((2, 3, 5, 8, 13, 21, 34, 55, 89, 144, 233))
"""Numbers of hits at which the frames where a track was to be expected are looked at again."""

Ints = NDArray[np.int64]


def priority(camera: str, frame: int) -> float:
    """Return the frame's place in the uniform sample, 0..1; depends on nothing else."""
    return zlib.crc32(f"{camera}/{frame}".encode()) / 2**32


class TrackTable:
    """Rows of tracks; ``n`` are in use, those not ``alive`` wait to be used again.

    Attributes:
        center_m, low_m, high_m: (rows, 3) robust geometry; ``version`` counts its changes.
        outer_low_m, outer_high_m: (rows, 3) extent, median over views that show it whole.
        hits, misses: frames that saw it; frames that should have and did not.
        seen, expected: (rows, slots) the same by view kept.
        birth: running number of the track.
        run: expected and missed since the last hit; ``empty_run``: those of them that looked
            through the place where it was.
        kept: (rows,) measurements kept, of ``measured`` in all.

    Memory: 12 kB a row with 2000 views.
    """

    def __init__(self, views: Views, observes: bool = True) -> None:
        self._views, self._observes = views, observes
        self.n = 0
        self._free: list[int] = []
        self._born = 0
        self._shapes: dict[str, tuple[tuple[int, ...], Any]] = {
            "alive": ((), np.bool_),
            "center_m": ((3,), np.float64),
            "low_m": ((3,), np.float64),
            "high_m": ((3,), np.float64),
            "outer_low_m": ((3,), np.float64),
            "outer_high_m": ((3,), np.float64),
            "spread_m2": ((3, 3), np.float64),
            "version": ((), np.int64),
            "hits": ((), np.int64),
            "misses": ((), np.int64),
            "old_misses": ((), np.int64),
            "run": ((), np.int64),
            "empty_run": ((), np.int64),
            "last_hit": ((), np.int64),
            "birth": ((), np.int64),
            "measured": ((), np.int64),
            "kept": ((), np.int64),
            "area_m2": ((), np.float64),
            "checked_center_m": ((3,), np.float64),
            "checked_size_m": ((), np.float64),
            "probe_m": ((KEPT_POINTS, 3), np.float32),
            "kept_priority": ((KEPT,), np.float64),
            "kept_place": ((KEPT, 15), np.float32),
            "kept_weight": ((KEPT,), np.float32),
            "kept_area": ((KEPT,), np.float32),
            "kept_border": ((KEPT,), np.bool_),
            "kept_serial": ((KEPT,), np.int64),
            "kept_box": ((KEPT, 4), np.float32),
            "kept_points": ((WITH_POINTS, KEPT_POINTS, 3), np.float32),
        }
        self.alive: Bools
        self.center_m: Floats
        self.low_m: Floats
        self.high_m: Floats
        self.outer_low_m: Floats
        self.outer_high_m: Floats
        self.spread_m2: Floats
        self.version: Ints
        self.hits: Ints
        self.misses: Ints
        self.old_misses: Ints
        self.run: Ints
        self.empty_run: Ints
        self.last_hit: Ints
        self.birth: Ints
        self.measured: Ints
        self.kept: Ints
        self.area_m2: Floats
        self.checked_center_m: Floats
        self.checked_size_m: Floats
        self.probe_m: NDArray[np.float32]
        self.kept_priority: Floats
        self.kept_place: NDArray[np.float32]
        self.kept_weight: NDArray[np.float32]
        self.kept_area: NDArray[np.float32]
        self.kept_border: Bools
        self.kept_serial: Ints
        self.kept_box: NDArray[np.float32]
        self.kept_points: NDArray[np.float32]
        for name, (shape, kind) in self._shapes.items():
            setattr(self, name, np.zeros((FIRST_ROOM, *shape), kind))
        self.seen: Bools = np.zeros((FIRST_ROOM, 64), dtype=bool)
        self.expected: Bools = np.zeros((FIRST_ROOM, 64), dtype=bool)

    @property
    def rows(self) -> Ints:
        """Rows of living tracks, ascending."""
        return np.flatnonzero(self.alive[: self.n])

    def boxes(self, rows: Any) -> Boxes:
        """Return the geometry of rows."""
        return Boxes(self.center_m[rows], self.low_m[rows], self.high_m[rows])

    def new_row(self) -> int:
        """Return the row of a new, empty track."""
        row = self._free.pop() if self._free else self.n
        self.n = max(self.n, row + 1)
        if row >= len(self.alive):
            for name in (*self._shapes, "seen", "expected"):
                old = getattr(self, name)
                setattr(self, name, np.concatenate([old, np.zeros_like(old)]))
        version = int(self.version[row])
        for name in (*self._shapes, "seen", "expected"):
            getattr(self, name)[row] = 0
        self.version[row] = version + 1
        self._born += 1
        self.birth[row] = self._born
        self.alive[row] = True
        self.kept_priority[row] = np.inf
        return row

    def drop(self, row: int) -> None:
        """Forget a track."""
        self.alive[row] = False
        self._free.append(row)
        self._free.sort(reverse=True)

    def open_slot(self, slot: int) -> None:
        """Make room for a view's column; one used before is folded into the counts."""
        if slot >= self.seen.shape[1]:
            for name in ("seen", "expected"):
                old = getattr(self, name)
                setattr(self, name, np.concatenate([old, np.zeros_like(old)], axis=1))
        missed = self.expected[:, slot] & ~self.seen[:, slot]
        self.old_misses += missed
        self.seen[:, slot] = self.expected[:, slot] = False

    def hit(self, rows: Ints, slot: int, serial: int) -> None:
        """Count a view that saw tracks."""
        self.seen[rows, slot] = True
        self.hits[rows] += 1
        self.run[rows] = self.empty_run[rows] = 0
        self.last_hit[rows] = serial

    def add(self, rows: Ints, which: Ints, measured: Measured, weight: Floats, key: float) -> Ints:
        """Sample measurements ``which`` of a frame into tracks; return the rows that changed."""
        self.measured[rows] += 1
        slot = np.where(self.kept[rows] < KEPT, self.kept[rows], self.kept_priority[rows].argmax(1))
        serial = self._views.total - 1
        taken = key < self.kept_priority[rows, slot]
        rows, slot, which = rows[taken], slot[taken], which[taken]
        self.kept[rows] = np.minimum(self.kept[rows] + 1, KEPT)
        self.kept_priority[rows, slot] = key
        m = measured
        parts = (m.center_m, m.low_m, m.high_m, m.outer_low_m, m.outer_high_m)
        self.kept_place[rows, slot] = np.concatenate([part[which] for part in parts], axis=1)
        self.kept_weight[rows, slot] = weight[which]
        self.kept_area[rows, slot] = m.size_m[which].prod(axis=1)
        self.kept_border[rows, slot] = m.at_border[which]
        self.kept_serial[rows, slot] = serial
        self.kept_box[rows, slot] = m.box_px[which]
        shown = slot < WITH_POINTS
        self.kept_points[rows[shown], slot[shown]] = m.points_m[which[shown]]
        self.refresh(rows)
        return rows

    def move(self, serial: int, old: Camera, new: Camera) -> None:
        """Take what a view measured from one camera to another.

        Boxes keep their size: what a correction turns is small against them.
        """
        rows, slots = np.nonzero(self.kept_serial == serial)
        here = self.alive[rows] & (slots < self.kept[rows])
        rows, slots = rows[here], slots[here]
        place = self.kept_place[rows, slots].astype(np.float64)
        center = place[:, :3]
        shift = moved_points(center, old, new) - center
        self.kept_place[rows, slots] = place + np.tile(shift, 5)
        shown = slots < WITH_POINTS
        rows, slots = rows[shown], slots[shown]
        points = self.kept_points[rows, slots].astype(np.float64)
        self.kept_points[rows, slots] = moved_points(points, old, new)

    def refresh(self, rows: Ints) -> None:
        """Derive geometry, typical area and probe points of rows from what they keep."""
        if not len(rows):
            return
        use = int(self.kept[rows].max())
        valid = np.arange(use) < self.kept[rows][:, None]
        found = robust_geometry(
            self.kept_place[rows, :use].astype(np.float64),
            self.kept_weight[rows, :use].astype(np.float64),
            self.kept_border[rows, :use],
            valid,
        )
        self.center_m[rows], self.low_m[rows], self.high_m[rows] = (
            found.center,
            found.low,
            found.high,
        )
        self.outer_low_m[rows], self.outer_high_m[rows] = found.outer_low, found.outer_high
        self.spread_m2[rows] = found.spread_m2
        area = np.where(valid, self.kept_area[rows, :use], np.inf)
        area.sort(axis=1)
        self.area_m2[rows] = area[np.arange(len(rows)), (self.kept[rows] - 1) // 2]
        point = np.arange(KEPT_POINTS)
        source = point % np.minimum(self.kept[rows], WITH_POINTS)[:, None]
        self.probe_m[rows] = self.kept_points[rows[:, None], source, point]
        self.version[rows] += 1

    def look(self, serial: int) -> None:
        """Take account of a view: which tracks it should have seen; after its hits."""
        if not self._observes:
            return
        slot = int(self._views.slots([serial])[0])
        rows, through = self._expect(self._near(slot), slot)
        self.expected[rows, slot] = True
        unseen = ~self.seen[rows, slot]
        missed = rows[unseen]
        self.misses[missed] += 1
        self.run[missed] += 1
        self.empty_run[rows[unseen & through]] += 1

    def _near(self, slot: int) -> Ints:
        """Return the rows within sight of a view of whose points enough lie before it."""
        rows = self.rows
        rotation, position_m = self._views.pose(slot)
        away = self.center_m[rows, :2] - position_m[:2]
        rows = rows[np.hypot(away[:, 0], away[:, 1]) < SIGHT_M]
        ahead = (self.probe_m[rows] - position_m) @ rotation[2] > NEAREST_M
        enough = np.count_nonzero(ahead, axis=1) >= EXPECT_SHARE * KEPT_POINTS
        return np.asarray(rows[enough])

    def _expect(self, rows: Ints, slot: int) -> tuple[Ints, Bools]:
        """Return which of rows a view should see, and whether it sees through their places."""
        slack = np.maximum(0.06, 0.35 * self.size_m(rows))
        visible, empty, depth = self._views.look_at(self.probe_m[rows], slot, slack)
        share = np.count_nonzero(visible, axis=1) / KEPT_POINTS
        shown = np.flatnonzero(share >= EXPECT_SHARE)
        rows, share = rows[shown], share[shown]
        middle = np.sort(depth[shown], axis=1)[:, KEPT_POINTS // 2]
        per_m2, image = self._views.image_px(np.array([slot]))
        enough = large_enough(self.area_m2[rows], share, middle, per_m2 / image)
        through = np.count_nonzero(empty[shown], axis=1) >= EMPTY_SHARE * KEPT_POINTS
        return rows[enough], through[enough]

    def size_m(self, rows: Ints) -> Floats:
        """Return the diagonals of the rows' boxes."""
        side = np.maximum(self.high_m[rows] - self.low_m[rows], 0.02)
        size: Floats = np.sqrt((side * side).sum(axis=1))
        return size

    def stale(self, rows: Ints) -> Ints:
        """Return the rows whose history must be looked at again: they moved or grew since."""
        hits = self.hits[rows].tolist()
        new = np.array([count == 1 for count in hits], dtype=bool)
        asked = np.array([count in FIBONACCI for count in hits], dtype=bool)
        if not (new | asked).any():
            return rows[:0]
        size = self.size_m(rows)
        moved = np.linalg.norm(self.center_m[rows] - self.checked_center_m[rows], axis=1)
        off = (moved > MOVED_M + 0.1 * size) | (
            np.abs(size - self.checked_size_m[rows]) > GROWN * size
        )
        return np.asarray(rows[(off & asked) | new])

    def look_back(self, row: int) -> None:
        """Look at all views kept again: which of them should have seen this track."""
        size = float(self.size_m(np.array([row]))[0])
        self.checked_center_m[row] = self.center_m[row]
        self.checked_size_m[row] = size
        self.expected[row] = False
        if not self._observes:
            return
        slots = should_see(
            self._views, self.center_m[row], size, float(self.area_m2[row]), self.probe_m[row]
        )
        self.expected[row, slots] = True
        missed = self.expected[row] & ~self.seen[row]
        self.misses[row] = self.old_misses[row] + int(missed.sum())
