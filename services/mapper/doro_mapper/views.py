"""Cameras of merged frames in map axes, and what they could see.

Map axes are (ground a, ground b, up), whatever the world: everything behind this module
is the same for AI2-THOR's world and ROS's (:func:`doro_schemas.camera.bev_axes`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from doro_schemas.camera import Intrinsics, Pose, bev_axes

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

THUMB_PX = 50
"""Side of the depth thumbnail kept per frame: 5 kB, and every 6th pixel of 300x300."""
SIGHT_M = 8.0
"""Nothing farther away counts as expected: detectors do not see it."""
NEAREST_M = 0.1
FARTHEST_MM = 65_535
LEAST_SIDE_SHARE = 0.007


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


def moved_points(points_m: Floats, old: Camera, new: Camera) -> Floats:
    """Return points (..., 3) that ``old`` saw where ``new`` would have seen them."""
    local = (points_m - old.position_m) @ old.rotation.T
    moved: Floats = local @ new.rotation + new.position_m
    return moved


def thumbnail(depth_m: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the depth at the centres of a THUMB_PX x THUMB_PX raster, float32 metres."""
    rows, columns = raster_px(*depth_m.shape)
    return depth_m[rows[:, None], columns]


def raster_px(height_px: int, width_px: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return rows and columns of the thumbnail's pixels in the image."""
    middle = np.arange(THUMB_PX) + 0.5
    rows = (middle * height_px / THUMB_PX).astype(np.int64)
    return rows, (middle * width_px / THUMB_PX).astype(np.int64)


class Views:
    """Cameras and depth thumbnails of the latest ``capacity`` merged frames.

    A frame's serial is its number in order of merging; its slot is ``serial % capacity``.
    Memory: about 5.2 kB a view.
    """

    def __init__(self, capacity: int) -> None:
        self._capacity = capacity
        self.total = 0
        self._rotation = np.zeros((0, 3, 3))
        self._position = np.zeros((0, 3))
        self._lens = np.zeros((0, 4))
        self._size = np.zeros((0, 2))
        self._reach = np.zeros((0, 2))
        self._thumb_mm = np.zeros((0, THUMB_PX, THUMB_PX), np.uint16)

    def _grow(self, room: int) -> None:
        def grown(old: NDArray[Any]) -> NDArray[Any]:
            new = np.zeros((room, *old.shape[1:]), old.dtype)
            new[: len(old)] = old
            return new

        self._rotation = grown(self._rotation)
        self._position = grown(self._position)
        self._lens = grown(self._lens)
        self._size = grown(self._size)
        self._reach = grown(self._reach)
        self._thumb_mm = grown(self._thumb_mm)

    @property
    def count(self) -> int:
        """Number of views kept."""
        return min(self.total, self._capacity)

    @property
    def oldest(self) -> int:
        """Serial of the oldest view kept."""
        return max(0, self.total - self._capacity)

    def slots(self, serials: Sequence[int] | NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the slots of serials."""
        return np.asarray(serials, dtype=np.int64) % self._capacity

    def serials(self, slots: NDArray[np.int64]) -> list[int]:
        """Return the serials of the views in slots, ascending."""
        first = self.oldest
        return sorted(((slots - first) % self._capacity + first).tolist())

    def thumb_m(self, serial: int) -> NDArray[np.float32]:
        """Return a view's thumbnail, metres."""
        thumb = self._thumb_mm[serial % self._capacity]
        return np.asarray(thumb * np.float32(0.001))

    def add(self, camera: Camera, depth_m: NDArray[np.float32]) -> int:
        """Keep a frame, its depth as a thumbnail in millimetres; return its serial."""
        serial = self.total
        slot = serial % self._capacity
        if slot >= len(self._position):
            self._grow(min(self._capacity, max(64, 2 * slot)))
        lens = camera.intrinsics
        self.place(serial, camera)
        self._lens[slot] = (lens.fx, lens.fy, lens.cx, lens.cy)
        self._size[slot] = camera.size_px
        # Half angles of the image, from its farther edges.
        width, height = camera.size_px
        self._reach[slot] = (
            max(lens.cx, width - lens.cx) / lens.fx,
            max(lens.cy, height - lens.cy) / lens.fy,
        )
        self._thumb_mm[slot] = np.minimum(np.rint(thumbnail(depth_m) * 1000), FARTHEST_MM)
        self.total += 1
        return serial

    def place(self, serial: int, camera: Camera) -> None:
        """Set where a view was taken from."""
        self._rotation[serial % self._capacity] = camera.rotation
        self._position[serial % self._capacity] = camera.position_m

    def camera(self, serial: int) -> Camera:
        """Return a view's camera."""
        slot = serial % self._capacity
        lens = Intrinsics(*(float(value) for value in self._lens[slot]))
        width, height = (int(value) for value in self._size[slot])
        return Camera(
            self._rotation[slot].copy(), self._position[slot].copy(), lens, (width, height)
        )

    def pose(self, slot: int) -> tuple[Floats, Floats]:
        """Return the rotation and the position of the view in a slot."""
        return self._rotation[slot], self._position[slot]

    def near(self, point_m: Floats, radius_m: float) -> NDArray[np.int64]:
        """Return slots of views within sight whose image a ball may touch."""
        n = self.count
        offset = point_m - self._position[:n]
        close = np.hypot(offset[:, 0], offset[:, 1]) < SIGHT_M
        local = (self._rotation[:n] @ offset[:, :, None])[:, :, 0]
        z = local[:, 2]
        # The ball's radius is slack at the image's edges.
        inside = np.abs(local[:, :2]) - radius_m <= self._reach[:n] * (z + radius_m)[:, None]
        return np.flatnonzero(close & (z + radius_m > NEAREST_M) & inside[:, 0] & inside[:, 1])

    def project(
        self, points_m: NDArray[Any], slots: NDArray[np.int64]
    ) -> tuple[Floats, Floats, Floats]:
        """Return (u_px, v_px, depth_m), each (views, points), of points (points, 3)."""
        turn, eye = self._rotation[slots], self._position[slots]
        local = (turn.reshape(-1, 3) @ points_m.T).reshape(len(turn), 3, -1)
        local -= turn @ eye[:, :, None]
        z = local[:, 2]
        safe = np.maximum(z, NEAREST_M / 2)
        lens = self._lens[slots][:, :, None]
        u = local[:, 0] / safe * lens[:, 0] + lens[:, 2]
        v = local[:, 1] / safe * lens[:, 1] + lens[:, 3]
        return u, v, z

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
        width, height = self._size[slots].T[:, :, None]
        inside = (z > NEAREST_M) & (u >= 0) & (u < width) & (v >= 0) & (v < height)
        view, _ = np.nonzero(inside)
        per_px = THUMB_PX / self._size[slots]
        column = np.minimum(u[inside] * per_px[view, 0], THUMB_PX - 1).astype(np.int64)
        row = np.minimum(v[inside] * per_px[view, 1], THUMB_PX - 1).astype(np.int64)
        seen_mm = self._thumb_mm[slots[view], row, column]
        out = np.zeros(z.shape, dtype=bool)
        out[inside] = (seen_mm > 0) & (seen_mm > 1000 * (z[inside] - slack_m))
        return out, z

    def look_at(
        self, points_m: NDArray[Any], slot: int, slack_m: Floats
    ) -> tuple[Bools, Bools, Floats]:
        """Tell of one view which points it had in its image and not occluded, and through which
        it looked at something farther away; and their depth; each (n, k).

        Args:
            points_m: (n, k, 3) map axes.
            slack_m: (n,) how far from the seen surface a point still counts as on it.
        """
        offset = points_m.reshape(-1, 3) - self._position[slot]
        x, y, z = self._rotation[slot] @ offset.T
        safe = np.maximum(z, NEAREST_M / 2)
        fx, fy, cx, cy = self._lens[slot]
        width, height = self._size[slot]
        column = (x / safe * fx + cx) * (THUMB_PX / width)
        row = (y / safe * fy + cy) * (THUMB_PX / height)
        inside = (z > NEAREST_M) & (column >= 0) & (column < THUMB_PX)
        inside &= (row >= 0) & (row < THUMB_PX)
        at = row.astype(np.int64) * THUMB_PX + column.astype(np.int64)
        seen_m = self._thumb_mm[slot].ravel()[np.where(inside, at, 0)] * 0.001
        slack = np.repeat(slack_m, points_m.shape[1])
        visible = inside & (seen_m > 0) & (seen_m > z - slack)
        shape = points_m.shape[:2]
        through = inside & (seen_m > z + slack)
        return visible.reshape(shape), through.reshape(shape), z.reshape(shape)

    def sees(self, points_m: Floats, slot: int, slack_m: float) -> Bools:
        """Tell which of many points (n, 3) within sight one view had in its image and not
        occluded, (n,)."""
        offset = (points_m - self._position[slot]).T
        z = self._rotation[slot, 2] @ offset
        near = np.flatnonzero((z > NEAREST_M) & (offset[0] ** 2 + offset[1] ** 2 < SIGHT_M**2))
        x, y = self._rotation[slot, :2] @ offset[:, near]
        z = z[near]
        fx, fy, cx, cy = self._lens[slot]
        width, height = self._size[slot]
        column = (x / z * fx + cx) * (THUMB_PX / width)
        row = (y / z * fy + cy) * (THUMB_PX / height)
        inside = (column >= 0) & (column < THUMB_PX) & (row >= 0) & (row < THUMB_PX)
        near, z = near[inside], z[inside]
        at = row[inside].astype(np.int64) * THUMB_PX + column[inside].astype(np.int64)
        seen_m = self._thumb_mm[slot].ravel()[at] * 0.001
        out = np.zeros(len(points_m), dtype=bool)
        out[near[(seen_m > 0) & (seen_m > z - slack_m)]] = True
        return out

    def image_px(self, slots: NDArray[np.int64]) -> tuple[Floats, Floats]:
        """Return (fx * fy, width * height) of views: pixels per square metre at 1 m, and area."""
        lens, size = self._lens[slots], self._size[slots]
        return lens[:, 0] * lens[:, 1], size[:, 0] * size[:, 1]

    def project_boxes(
        self, low_m: Floats, high_m: Floats, slots: NDArray[np.int64]
    ) -> tuple[Floats, Bools]:
        """Return the image box of each 3-D box in its view, (n, 4), and whether it shows at all.

        Args:
            low_m, high_m: (n, 3).
            slots: (n,) of the views.
        """
        turn = np.ascontiguousarray(self._rotation[slots].transpose(2, 1, 0))
        eye = self._position[slots]
        ends = np.stack([(low_m - eye).T, (high_m - eye).T])
        # What each end of each side adds to a corner, (side, end, axis of the camera, n).
        a, b, c = (ends[:, side, None] * turn[side] for side in range(3))
        corners = (a[:, None, None] + b[None, :, None] + c[None, None]).reshape(8, 3, -1)
        z = corners[:, 2]
        ratio = corners[:, :2] / np.maximum(z, NEAREST_M / 2)[:, None]
        lens, size = self._lens[slots].T, self._size[slots].T
        first = np.minimum(np.maximum(ratio.min(0) * lens[:2] + lens[2:], 0), size)
        last = np.minimum(np.maximum(ratio.max(0) * lens[:2] + lens[2:], 0), size)
        least = np.maximum(size[0], size[1]) * LEAST_SIDE_SHARE
        shows = (last - first > least).all(axis=0) & (z.min(0) > NEAREST_M)
        return np.concatenate([first, last]).T, shows

    def position_m(self, serial: int) -> Floats:
        """Return the camera's position of a view, (3,) map axes."""
        position: Floats = self._position[serial % self._capacity]
        return position
