"""What of the area has been seen, how often and from which sides."""

from __future__ import annotations

import functools

import numpy as np
from numpy.typing import NDArray

from doro_mapper.views import NEAREST_M, Camera, Floats, raster_px
from doro_schemas.camera import Intrinsics

SIDES = 8
FIRST_SPAN = 64
OFFSET = 1 << 20
FOLDED, FRAME_BITS = 8, 4
"""Frames that are counted together: nobody looks at them before the map is asked for."""
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


@functools.lru_cache(maxsize=16)
def _rays(lens: Intrinsics, size_px: tuple[int, int]) -> Floats:
    """Return the rays (3, n) through every other row and column of the thumbnail, depth 1."""
    rows, columns = (pixels[::2] + 0.5 for pixels in raster_px(size_px[1], size_px[0]))
    v, u = np.meshgrid((rows - lens.cy) / lens.fy, (columns - lens.cx) / lens.fx, indexing="ij")
    return np.stack([u.ravel(), v.ravel(), np.ones(u.size)])


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
        self._waiting: list[tuple[NDArray[np.float32], Camera]] = []

    def add(self, thumb_m: NDArray[np.float32], camera: Camera) -> None:
        """Add one frame by its depth thumbnail: every other row and column of it."""
        self._waiting.append((thumb_m[::2, ::2].copy(), camera))
        self._remember(camera)
        if len(self._waiting) >= FOLDED:
            self._fold()

    def _fold(self) -> None:
        """Count the frames that wait.

        Points above the camera (walls, lamps) are no floor or surface.
        """
        if not self._waiting:
            return
        eyes = np.array([camera.position_m for _, camera in self._waiting])
        points, frame = self._points(eyes)
        self._waiting.clear()
        if not len(frame):
            return
        squares = np.floor(points[:2] / self._square_m).astype(np.int64)
        self._add_squares(squares, frame, eyes)
        low = points[2] < eyes[frame, 2]
        cells = np.floor(points[:2, low] / self._cell_m).astype(np.int64)
        at = self._floor.at(cells.T)  # may make the sheet larger: before its values are taken
        self._floor.values[at] = 1

    def _remember(self, camera: Camera) -> None:
        if self._frames == MAX_PATH:
            self._path[: MAX_PATH // 2] = self._path[MAX_PATH // 2 :]
            self._frames = MAX_PATH // 2
        if self._frames >= len(self._path):
            self._path = np.concatenate([self._path, np.zeros_like(self._path)])
        self._path[self._frames] = camera.position_m[:2]
        self._frames += 1

    def _points(self, eyes: Floats) -> tuple[Floats, Ints]:
        """Return the surface points (3, n) of the frames that wait, and the frame of each."""
        depth = np.array([thumb for thumb, _ in self._waiting]).astype(np.float64)
        rays = np.array([_rays(camera.intrinsics, camera.size_px) for _, camera in self._waiting])
        turns = np.array([camera.rotation.T for _, camera in self._waiting])
        z = depth.reshape(len(depth), 1, -1)
        points = turns @ (rays * z) + eyes[:, :, None]
        good = (z[:, 0] > NEAREST_M) & (z[:, 0] < self._max_depth_m)
        return np.moveaxis(points, 1, 0)[:, good], np.nonzero(good)[0]

    def _add_squares(self, squares: Ints, frame: Ints, eyes: Floats) -> None:
        """Count each frame once for each square, and mark the side that it was seen from."""
        number = ((squares[0] + OFFSET) << 32) | ((squares[1] + OFFSET) << FRAME_BITS) | frame
        number = np.unique(number)
        frame, square = number & ((1 << FRAME_BITS) - 1), number >> FRAME_BITS
        places = np.stack([square >> (32 - FRAME_BITS), square & (2 * OFFSET - 1)], axis=1) - OFFSET
        once = np.flatnonzero(np.diff(square, prepend=-1))
        at = self._often.at(places[once])
        often = self._often.values[at] + np.diff(once, append=len(square))
        self._often.values[at] = np.minimum(often, 65_535)
        middle = (places + 0.5) * self._square_m - eyes[frame, :2]
        sector = np.arctan2(middle[:, 1], middle[:, 0]) * (SIDES / (2 * np.pi))
        bit = (1 << (np.floor(sector).astype(np.int64) % SIDES)).astype(np.uint8)
        at = self._sides.at(places[once])
        self._sides.values[at] |= np.bitwise_or.reduceat(bit, once)

    def unseen_share(self) -> float:
        """Return the share of squares inside the bounds of all points seen that no point fell in.

        1 before the first frame: nothing has been seen.
        """
        self._fold()
        squares = self._often.cells()
        if not len(squares):
            return 1.0
        sides = squares.max(0) - squares.min(0) + 1
        return float(1.0 - len(squares) / (int(sides[0]) * int(sides[1])))

    def one_sided_share(self) -> float:
        """Return the share of the squares seen that were seen from one eighth of the circle only.

        What hides behind things in them has not been seen.
        """
        self._fold()
        seen = self._sides.values[self._sides.values > 0]
        if not len(seen):
            return 1.0
        return float(np.mean((seen & (seen - np.uint8(1))) == 0))

    def squares(self) -> NDArray[np.int32]:
        """Return the squares seen, int32 (m, 4): a, b, frames, bits of the eighths it was seen
        from, lowest bit along +a, next ones towards +b; sorted."""
        self._fold()
        cells = self._often.cells()
        frames = self._often.values[self._often.at(cells)] if len(cells) else np.zeros(0)
        sides = self._sides.values[self._sides.at(cells)] if len(cells) else np.zeros(0)
        return np.column_stack([cells, frames, sides]).astype(np.int32)

    def floor(self) -> NDArray[np.int32]:
        """Return the ground cells seen, int32 (m, 2), sorted."""
        self._fold()
        return self._floor.cells().astype(np.int32)

    def path_m(self) -> NDArray[np.float32]:
        """Return the latest cameras' ground positions in order of merging, float32 (k, 2)."""
        return self._path[: self._frames].copy()
