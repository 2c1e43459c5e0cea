"""What of the area has been seen, how often and from which sides."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from doro_mapper.views import NEAREST_M, Camera, Floats, raster_px, thumbnail

SIDES = 8
FIRST_SPAN = 64
OFFSET = 1 << 20
MAX_PATH = 1 << 14
"""Camera positions kept; when full, the older half is forgotten."""

Ints = NDArray[np.int64]


class Sheet:
    """A growing map of small integers over ground cells.

    Memory: the cells inside the bounds of what was set, at most twice as wide and as long.
    """

    def __init__(self, kind: type[np.unsignedinteger]) -> None:
        self._kind = kind
        self._origin = np.zeros(2, np.int64)
        self._values = np.zeros((0, 0), kind)

    def at(self, cells: Ints) -> tuple[Ints, Ints]:
        """Return the indices of cells (n, 2) into :attr:`values`, made larger if need be."""
        if len(cells):
            self._cover(cells.min(0), cells.max(0))
        local = cells - self._origin
        return local[:, 0], local[:, 1]

    @property
    def values(self) -> NDArray[np.unsignedinteger]:
        """All values, (a, b) from the origin."""
        return self._values

    def _cover(self, low: Ints, high: Ints) -> None:
        size = np.array(self._values.shape)
        end = self._origin + size
        if size.all() and (low >= self._origin).all() and (high < end).all():
            return
        if not size.all():
            self._origin, end = low.copy(), low.copy()
        start, stop = np.minimum(low, self._origin), np.maximum(high + 1, end)
        room = np.maximum((stop - start) // 2, FIRST_SPAN)
        start = np.where(low < self._origin, start - room, start)
        stop = np.where(high >= end, stop + room, stop)
        bigger = np.zeros(tuple(stop - start), self._kind)
        at = self._origin - start
        bigger[at[0] : at[0] + size[0], at[1] : at[1] + size[1]] = self._values
        self._origin, self._values = start, bigger

    def cells(self) -> Ints:
        """Return the cells whose value is not 0, (n, 2), sorted."""
        return np.asarray(np.argwhere(self._values) + self._origin)


class Coverage:
    """Ground cells under the surface points of depth thumbnails.

    Memory: 1 byte a ground cell and 4 a square within the bounds of what was seen.
    """

    def __init__(self, cell_m: float, square_m: float, max_depth_m: float) -> None:
        self._cell_m = cell_m
        self._square_m = square_m
        self._max_depth_m = max_depth_m
        self._floor = Sheet(np.uint8)
        self._often = Sheet(np.uint16)
        self._sides = Sheet(np.uint8)
        self._path = np.zeros((FIRST_SPAN, 2), np.float32)
        self._frames = 0

    def add(self, depth_m: NDArray[np.float32], camera: Camera) -> None:
        """Add one frame; points above the camera (walls, lamps) are no floor or surface."""
        points = self._points(depth_m, camera)
        self._remember(camera)
        if not len(points):
            return
        squares = np.floor(points[:, :2] / self._square_m).astype(np.int64)
        self._add_squares(squares, camera.position_m)
        low = points[points[:, 2] < camera.position_m[2]]
        if len(low):
            cells = np.floor(low[:, :2] / self._cell_m).astype(np.int64)
            at = self._floor.at(cells)
            self._floor.values[at] = 1

    def _remember(self, camera: Camera) -> None:
        if self._frames == MAX_PATH:
            self._path[: MAX_PATH // 2] = self._path[MAX_PATH // 2 :]
            self._frames = MAX_PATH // 2
        if self._frames >= len(self._path):
            self._path = np.concatenate([self._path, np.zeros_like(self._path)])
        self._path[self._frames] = camera.position_m[:2]
        self._frames += 1

    def _points(self, depth_m: NDArray[np.float32], camera: Camera) -> Floats:
        """Return surface points on every other row and column of the thumbnail, (n, 3)."""
        depth = thumbnail(depth_m)[::2, ::2].astype(np.float64)
        rows, columns = (pixels[::2] for pixels in raster_px(*depth_m.shape))
        lens = camera.intrinsics
        good = (depth > NEAREST_M) & (depth < self._max_depth_m)
        z = depth[good]
        x = np.broadcast_to((columns + 0.5 - lens.cx) / lens.fx, good.shape)[good] * z
        y = np.broadcast_to(((rows + 0.5 - lens.cy) / lens.fy)[:, None], good.shape)[good] * z
        points: Floats = np.stack([x, y, z], axis=1) @ camera.rotation + camera.position_m
        return points

    def _add_squares(self, squares: Ints, position_m: Floats) -> None:
        """Count the frame once for each square, and mark the side that it was seen from."""
        packed = np.unique(((squares[:, 0] + OFFSET) << 32) | (squares[:, 1] + OFFSET))
        squares = np.stack([(packed >> 32) - OFFSET, (packed & 0xFFFFFFFF) - OFFSET], axis=1)
        at = self._often.at(squares)
        count = self._often.values
        count[at] = np.minimum(count[at].astype(np.int64) + 1, 65_535)
        side_of = self._sides.at(squares)
        middle = (squares + 0.5) * self._square_m - position_m[:2]
        sector = np.arctan2(middle[:, 1], middle[:, 0]) * (SIDES / (2 * np.pi))
        bit = 1 << (np.floor(sector).astype(np.int64) % SIDES)
        self._sides.values[side_of] |= bit.astype(np.uint8)

    def unseen_share(self) -> float:
        """Return the share of squares inside the bounds of all points seen that no point fell in.

        1 before the first frame: nothing has been seen.
        """
        squares = self._often.cells()
        if not len(squares):
            return 1.0
        sides = squares.max(0) - squares.min(0) + 1
        return float(1.0 - len(squares) / (int(sides[0]) * int(sides[1])))

    def one_sided_share(self) -> float:
        """Return the share of the squares seen that were seen from one eighth of the circle only.

        What hides behind things in them has not been seen.
        """
        seen = self._sides.values[self._sides.values > 0]
        if not len(seen):
            return 1.0
        return float(np.mean((seen & (seen - np.uint8(1))) == 0))

    def squares(self) -> NDArray[np.int32]:
        """Return the squares seen, int32 (m, 4): a, b, frames, bits of the eighths it was seen
        from, lowest bit along +a, next ones towards +b; sorted."""
        cells = self._often.cells()
        frames = self._often.values[self._often.at(cells)] if len(cells) else np.zeros(0)
        sides = self._sides.values[self._sides.at(cells)] if len(cells) else np.zeros(0)
        return np.column_stack([cells, frames, sides]).astype(np.int32)

    def floor(self) -> NDArray[np.int32]:
        """Return the ground cells seen, int32 (m, 2), sorted."""
        return self._floor.cells().astype(np.int32)

    def path_m(self) -> NDArray[np.float32]:
        """Return the latest cameras' ground positions in order of merging, float32 (k, 2)."""
        return self._path[: self._frames].copy()
