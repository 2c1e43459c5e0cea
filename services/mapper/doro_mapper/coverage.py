"""What of the area has been seen: for "unseen_share", and the floor plan of pictures."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from doro_mapper.views import THUMB_PX, Camera, thumbnail
from doro_schemas.camera import Pose, backproject, bev_axes

OFFSET = 1 << 20
"""Makes ground cell numbers positive, so that two of them pack into one integer."""


def _packed(a: NDArray[np.int64], b: NDArray[np.int64]) -> list[int]:
    return [int(x) for x in np.unique(((a + OFFSET) << 32) | (b + OFFSET))]


class Coverage:
    """Ground cells under the surface points of depth thumbnails.

    Memory: 100 bytes per ground cell seen.
    """

    def __init__(self, cell_m: float, square_m: float, max_depth_m: float) -> None:
        self._cell_m = cell_m
        self._square_m = square_m
        self._max_depth_m = max_depth_m
        self._floor: set[int] = set()
        self._squares: set[int] = set()
        self._path: list[tuple[float, float]] = []

    def add(self, depth_m: NDArray[np.float32], camera: Camera, pose: Pose) -> None:
        """Add one frame; points above the camera (walls, lamps) are no floor or surface."""
        depth = thumbnail(depth_m).astype(np.float64)
        height, width = depth_m.shape
        rows = (np.arange(THUMB_PX) + 0.5) * height / THUMB_PX
        columns = (np.arange(THUMB_PX) + 0.5) * width / THUMB_PX
        # A thumbnail's pixel is the whole pixel at that place: its centre is at +0.5.
        v, u = np.meshgrid(np.floor(rows) + 0.5, np.floor(columns) + 0.5, indexing="ij")
        good = (depth > 0) & (depth < self._max_depth_m)
        points = backproject(u[good], v[good], depth[good], camera.intrinsics, pose)
        points = points[:, list(bev_axes(pose.world))]
        self._path.append((float(camera.position_m[0]), float(camera.position_m[1])))
        squares = np.floor(points[:, :2] / self._square_m).astype(np.int64)
        self._squares.update(_packed(squares[:, 0], squares[:, 1]))
        low = points[points[:, 2] < camera.position_m[2]]
        cells = np.floor(low[:, :2] / self._cell_m).astype(np.int64)
        self._floor.update(_packed(cells[:, 0], cells[:, 1]))

    def unseen_share(self) -> float:
        """Return the share of squares inside the bounds of all points seen that no point fell in.

        1 before the first frame: nothing has been seen.
        """
        squares = _unpacked(self._squares)
        if not len(squares):
            return 1.0
        sides = squares.max(0) - squares.min(0) + 1
        return float(1.0 - len(squares) / (int(sides[0]) * int(sides[1])))

    def floor(self) -> NDArray[np.int32]:
        """Return the ground cells seen, int32 (m, 2), sorted."""
        return _unpacked(self._floor).astype(np.int32)

    def path_m(self) -> NDArray[np.float32]:
        """Return the cameras' ground positions in order of merging, float32 (k, 2)."""
        return np.array(self._path, dtype=np.float32).reshape(-1, 2)


def _unpacked(cells: set[int]) -> NDArray[np.int64]:
    packed = np.array(sorted(cells), dtype=np.int64)
    return np.stack([(packed >> 32) - OFFSET, (packed & 0xFFFFFFFF) - OFFSET], axis=1)
