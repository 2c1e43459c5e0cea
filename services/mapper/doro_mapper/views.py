"""Cameras of merged frames in map axes, and what they could see.

Map axes are (ground a, ground b, up), whatever the world: everything behind this module
is the same for AI2-THOR's world and ROS's (:func:`doro_schemas.camera.bev_axes`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from doro_schemas.camera import Intrinsics, Pose, bev_axes

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

THUMB_PX = 50
"""Side of the depth thumbnail kept per frame: 10 kB, and every 6th pixel of 300x300."""
SIGHT_M = 8.0
"""Nothing farther away counts as expected: detectors do not see it."""
NEAREST_M = 0.1


@dataclass(frozen=True, slots=True)
class Camera:
    """One frame's camera.

    Attributes:
        rotation: (3, 3) world-to-camera in map axes; rows are right, down, forward.
        position_m: (3,) map axes.
        intrinsics: pixels.
        size_px: (width, height).
    """

    rotation: Floats
    position_m: Floats
    intrinsics: Intrinsics
    size_px: tuple[int, int]


def camera_of(intrinsics: Intrinsics, pose: Pose, size_px: tuple[int, int]) -> Camera:
    """Return the camera of a depth frame in map axes."""
    axes = list(bev_axes(pose.world))
    position = np.asarray(pose.position_m, dtype=np.float64)[axes]
    return Camera(pose.matrix()[axes].T.copy(), position, intrinsics, size_px)


def thumbnail(depth_m: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the depth at the centres of a THUMB_PX x THUMB_PX raster, float32 metres."""
    rows, columns = (
        ((np.arange(THUMB_PX) + 0.5) * n / THUMB_PX).astype(int) for n in depth_m.shape
    )
    return depth_m[np.ix_(rows, columns)]


class Views:
    """Cameras and depth thumbnails of the latest ``capacity`` merged frames.

    A frame's serial is its number in order of merging; its slot is ``serial % capacity``.
    Memory: about 10.3 kB a view.
    """

    def __init__(self, capacity: int) -> None:
        self._capacity = capacity
        self.total = 0
        self._rotation = np.zeros((0, 3, 3))
        self._position = np.zeros((0, 3))
        self._lens = np.zeros((0, 4))
        self._size = np.zeros((0, 2))
        self._thumb = np.zeros((0, THUMB_PX, THUMB_PX), np.float32)

    def _grow(self, room: int) -> None:
        def grown(old: NDArray[Any]) -> NDArray[Any]:
            new = np.zeros((room, *old.shape[1:]), old.dtype)
            new[: len(old)] = old
            return new

        self._rotation = grown(self._rotation)
        self._position = grown(self._position)
        self._lens = grown(self._lens)
        self._size = grown(self._size)
        self._thumb = grown(self._thumb)

    @property
    def count(self) -> int:
        """Number of views kept."""
        return min(self.total, self._capacity)

    @property
    def oldest(self) -> int:
        """Serial of the oldest view kept."""
        return max(0, self.total - self._capacity)

    def slots(self, serials: list[int]) -> NDArray[np.int64]:
        """Return the slots of serials."""
        return np.asarray(serials, dtype=np.int64) % self._capacity

    def add(self, camera: Camera, depth_m: NDArray[np.float32]) -> int:
        """Keep a frame and return its serial."""
        serial = self.total
        slot = serial % self._capacity
        if slot >= len(self._position):
            self._grow(min(self._capacity, max(64, 2 * slot)))
        lens = camera.intrinsics
        self._rotation[slot] = camera.rotation
        self._position[slot] = camera.position_m
        self._lens[slot] = (lens.fx, lens.fy, lens.cx, lens.cy)
        self._size[slot] = camera.size_px
        self._thumb[slot] = thumbnail(depth_m)
        self.total += 1
        return serial

    def near(self, point_m: Floats, radius_m: float) -> NDArray[np.int64]:
        """Return slots of views within sight whose image a ball may touch."""
        n = self.count
        offset = point_m - self._position[:n]
        close = np.hypot(offset[:, 0], offset[:, 1]) < SIGHT_M
        local = np.einsum("fij,fj->fi", self._rotation[:n], offset)
        z = local[:, 2]
        # Half angles of the image, from its farther edges, with the ball's radius as slack.
        lens, size = self._lens[:n], self._size[:n]
        reach_u = np.maximum(lens[:, 2], size[:, 0] - lens[:, 2]) / lens[:, 0]
        reach_v = np.maximum(lens[:, 3], size[:, 1] - lens[:, 3]) / lens[:, 1]
        inside_u = np.abs(local[:, 0]) - radius_m <= reach_u * (z + radius_m)
        inside_v = np.abs(local[:, 1]) - radius_m <= reach_v * (z + radius_m)
        return np.flatnonzero(close & (z + radius_m > NEAREST_M) & inside_u & inside_v)

    def project(
        self, points_m: NDArray[Any], slots: NDArray[np.int64]
    ) -> tuple[Floats, Floats, Floats]:
        """Return (u_px, v_px, depth_m), each (views, points), of points (points, 3)."""
        offset = points_m[None] - self._position[slots][:, None]
        local = offset @ self._rotation[slots].transpose(0, 2, 1)
        z = local[..., 2]
        safe = np.maximum(z, NEAREST_M / 2)
        lens = self._lens[slots][:, :, None]
        return (
            local[..., 0] / safe * lens[:, 0] + lens[:, 2],
            local[..., 1] / safe * lens[:, 1] + lens[:, 3],
            z,
        )

    def visible(
        self, points_m: NDArray[Any], slots: NDArray[np.int64], slack_m: float
    ) -> tuple[Bools, Floats]:
        """Tell which points each view had in its image and not occluded; and their depth.

        Free space beyond counts as seen: the thing is not there. A hole tells nothing.

        Args:
            points_m: (points, 3) map axes.
            slots: the views.
            slack_m: how far behind the seen surface a point still counts as seen.

        Returns:
            bool (views, points), depth (views, points).
        """
        u, v, z = self.project(points_m, slots)
        size = self._size[slots][:, :, None]
        inside = (z > NEAREST_M) & (u >= 0) & (u < size[:, 0]) & (v >= 0) & (v < size[:, 1])
        column = np.clip(u / size[:, 0] * THUMB_PX, 0, THUMB_PX - 1).astype(np.int64)
        row = np.clip(v / size[:, 1] * THUMB_PX, 0, THUMB_PX - 1).astype(np.int64)
        seen = self._thumb[slots[:, None], row, column]
        return inside & (seen > 0) & (seen > z - slack_m), z

    def image_px(self, slots: NDArray[np.int64]) -> tuple[Floats, Floats]:
        """Return (fx * fy, width * height) of views: pixels per square metre at 1 m, and area."""
        lens, size = self._lens[slots], self._size[slots]
        return lens[:, 0] * lens[:, 1], size[:, 0] * size[:, 1]

    def project_box(
        self, low_m: Floats, high_m: Floats, slots: NDArray[np.int64]
    ) -> tuple[Floats, Bools]:
        """Return image boxes (views, 4) of a 3-D box, and whether each shows at all."""
        pick = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
        corners = np.where(pick == 0, low_m, high_m)
        u, v, z = self.project(corners, slots)
        size = self._size[slots]
        boxes = np.stack(
            [
                np.clip(u.min(1), 0, size[:, 0]),
                np.clip(v.min(1), 0, size[:, 1]),
                np.clip(u.max(1), 0, size[:, 0]),
                np.clip(v.max(1), 0, size[:, 1]),
            ],
            axis=1,
        )
        least = size.max(1) * 0.007
        wide = (boxes[:, 2] - boxes[:, 0] > least) & (boxes[:, 3] - boxes[:, 1] > least)
        return boxes, wide & (z.min(1) > NEAREST_M)

    def position_m(self, serial: int) -> Floats:
        """Return the camera's position of a view, (3,) map axes."""
        position: Floats = self._position[serial % self._capacity]
        return position
