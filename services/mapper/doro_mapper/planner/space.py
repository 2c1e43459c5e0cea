"""The space as the planner knows it: what is free, solid, unseen, and how well it was looked at.

Voxels in map axes, filled from the depth thumbnails of merged frames. Each keeps the probability
that a small thing in it went unnoticed so far: a surface seen from four metres counts as seen by
a bit only, because a cup is four pixels there and no detector finds it.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from doro_mapper.planner.settings import PlannerSettings
from doro_mapper.views import THUMB_PX, Camera, Floats

Singles = NDArray[np.float32]

NEAREST_M = 0.1
GROW_M = 2.0
BELOW_M, ABOVE_M = 2.4, 0.8
"""Heights kept, from the first camera: a room's floor to what hangs a little above the eye."""
SOLID_HIT, SOLID_MAX, FREE_MIN = 2, 6, -4
UNKNOWN_OPACITY = 0.3
HIDDEN_DECAY = 0.9
"""An unknown voxel that a view should have shown and did not is worth less by it."""
DECAYED = (HIDDEN_DECAY ** np.arange(256)).astype(np.float32)
FLOOR_QUANTILE = 0.02


def noticed(size_m: float, range_m: Floats, focal_px: float, least_px: float) -> Floats:
    """Return the probability that a detector finds a thing of a size at a range.

    ``exp(-(least_px / size in pixels)^2)``: .37 at ``least_px``, .94 at four times that.
    """
    out: Floats = np.exp(-((least_px * range_m / (focal_px * size_m)) ** 2))
    return out


class Space:
    """Voxels around the first camera, grown as the robot goes, up to ``reach_m`` to each side.

    Memory: 15 bytes a voxel; with 0.2 m and 20 m at most 10 MB.

    Attributes:
        value: by flat voxel number, things expected in it and not noticed yet; the last is 0
            and stands for all outside, so that number -1 needs no care.
        opacity: the chance that a ray ends there; 1 outside.
        floor_m: height of the floor, the lowest that was seen.
    """

    def __init__(self, settings: PlannerSettings) -> None:
        self._settings = settings
        self.edge_m = settings.voxel_m
        self.origin_m: Floats = np.zeros(3)
        self._low_m: Floats = np.zeros(3)
        self._high_m: Floats = np.zeros(3)
        self.floor_m = math.inf
        self._missed: Singles = np.zeros((0, 0, 0), np.float32)
        self._solid: NDArray[np.int8] = np.zeros((0, 0, 0), np.int8)
        self._known: NDArray[np.bool_] = np.zeros((0, 0, 0), np.bool_)
        self._hidden: NDArray[np.uint8] = np.zeros((0, 0, 0), np.uint8)
        self.value: Singles = np.zeros(1, np.float32)
        self.opacity: Singles = np.ones(1, np.float32)

    @property
    def shape(self) -> tuple[int, int, int]:
        """Numbers of voxels along the map axes."""
        a, b, c = self._missed.shape
        return a, b, c

    def add(self, camera: Camera, thumb_m: Singles) -> None:
        """Take one frame's depth thumbnail: surfaces, what is free before and hidden behind."""
        points, _ = _points(camera, thumb_m, self._settings.sight_m)
        sight = np.array([self._settings.sight_m, self._settings.sight_m, 0.0])
        self.make_room(camera.position_m, camera.position_m + np.array([-sight, sight]))
        low = points[points[:, 2] < camera.position_m[2] - 0.3]
        if len(low):
            self.floor_m = min(self.floor_m, float(np.quantile(low[:, 2], FLOOR_QUANTILE)))
        box = self._in_sight(camera)
        index, z, u, v = self._in_image(camera, box)
        row = np.clip(v / camera.size_px[1] * THUMB_PX, 0, THUMB_PX - 1).astype(np.int64)
        column = np.clip(u / camera.size_px[0] * THUMB_PX, 0, THUMB_PX - 1).astype(np.int64)
        seen = thumb_m[row, column]
        good = seen > 0
        index, z, seen = index[good], z[good], seen[good]
        margin = 0.5 * math.sqrt(3) * self.edge_m
        solid, known = self._solid.reshape(-1), self._known.reshape(-1)
        free = index[z < seen - margin]
        solid[free] = np.maximum(solid[free] - 1, FREE_MIN)
        behind = index[z > seen + margin]
        hidden = self._hidden.reshape(-1)
        hidden[behind] = np.minimum(hidden[behind], 254) + 1
        hit = self.index(points)
        hit = hit[hit >= 0]
        solid[hit] = np.minimum(solid[hit] + SOLID_HIT + 1, SOLID_MAX)
        at_surface = np.abs(z - seen) <= margin
        looked = np.unique(np.concatenate([index[at_surface], hit]))
        known[free] = True
        known[looked] = True
        range_m = np.linalg.norm(self.centers_m(looked) - camera.position_m, axis=1)
        chance = noticed(
            self._settings.small_m, range_m, camera.intrinsics.fy, self._settings.least_px
        )
        self._missed.reshape(-1)[looked] *= (1 - self._settings.trust * chance).astype(np.float32)
        self._weigh(box)

    def index(self, points_m: Floats) -> NDArray[np.int32]:
        """Return flat voxel numbers of points (..., 3); -1 outside."""
        return self.flat(((points_m - self.origin_m) / self.edge_m).astype(np.float32))

    def flat(self, cells: Singles) -> NDArray[np.int32]:
        """Return flat voxel numbers of points (..., 3) in voxels from the corner; -1 outside."""
        a, b, c = self.shape
        # Negative ones wrap round and are too large like all others outside.
        whole = np.floor(cells).astype(np.int32).view(np.uint32)
        i, j, k = whole[..., 0], whole[..., 1], whole[..., 2]
        inside = (i < a) & (j < b) & (k < c)
        number = ((i * np.uint32(b) + j) * np.uint32(c) + k).view(np.int32)
        return np.where(inside, number, np.int32(-1))

    def centers_m(self, index: NDArray[np.int64]) -> Floats:
        """Return the centres (n, 3) of voxels."""
        _, b, c = self.shape
        cell = np.stack([index // (b * c), index // c % b, index % c], axis=-1)
        return np.asarray(self.origin_m + (cell + 0.5) * self.edge_m)

    def _weigh(self, box: tuple[slice, slice]) -> None:
        """Renew value and opacity where a frame may have changed something."""
        options = self._settings
        solid, known = self._solid[box] > 0, self._known[box]
        above = np.zeros_like(solid)
        above[:, :, :-1] = solid[:, :, 1:]
        surface = np.where(above, options.per_side_voxel, options.per_top_voxel) * self._missed[box]
        unknown = options.per_unknown_voxel * DECAYED[self._hidden[box]]
        value = np.where(solid, surface, np.where(known, 0.0, unknown))
        self.value[:-1].reshape(self.shape)[box] = value
        opacity = np.where(solid, 1.0, np.where(known, 0.0, UNKNOWN_OPACITY))
        self.opacity[:-1].reshape(self.shape)[box] = opacity

    def clear(self, from_m: Floats, to_m: Floats, stop_m: Floats, steps: int) -> Floats:
        """Return the chance (n, m) that nothing lies between cameras (n, 3) and points (m, 3).

        Args:
            stop_m: (m,) how far before each point to stop, for the thing itself.
        """
        offset = to_m[None] - from_m[:, None]
        length = np.maximum(np.linalg.norm(offset, axis=2), 1e-6)
        part = np.maximum(0.0, 1 - stop_m[None] / length)
        share = (np.arange(steps) + 0.5) / steps
        along = from_m[:, None, None] + offset[:, :, None] * (part[..., None] * share)[..., None]
        open_share = 1 - self.opacity[self.index(along)]
        out: Floats = open_share.min(axis=2).astype(np.float64)
        return out

    def walkable(self, camera_m: Floats, radius_m: float) -> NDArray[np.bool_]:
        """Return the columns (a, b) where a robot may stand: floor seen, free up to the camera."""
        height = self.origin_m[2] + (np.arange(self.shape[2]) + 0.5) * self.edge_m
        body = (height > self.floor_m + 0.75 * self.edge_m) & (height < camera_m[2])
        ground = np.abs(height - self.floor_m) <= 0.75 * self.edge_m
        free = np.asarray((self._known & (self._solid <= 0))[:, :, body].all(axis=2))
        floor = np.asarray((self._solid > 0)[:, :, ground].any(axis=2))
        blocked: NDArray[np.bool_] = np.asarray((self._solid > 0)[:, :, body].any(axis=2))
        for _ in range(math.floor(radius_m / self.edge_m + 0.5)):
            blocked = _spread(blocked)
        return np.asarray(free & floor & ~blocked)

    def make_room(self, camera_m: Floats, points_m: Floats) -> None:
        """Let the voxels reach to points (n, 3), as far as ``reach_m`` allows."""
        edge, reach = self.edge_m, self._settings.reach_m
        if not self._missed.size:
            base = np.floor(camera_m / edge) * edge
            self._low_m = base - np.array([reach, reach, BELOW_M])
            self._high_m = base + np.array([reach, reach, ABOVE_M])
            self.origin_m = np.array([*base[:2], self._low_m[2]])
            self._resize(np.zeros(3, int), np.array([1, 1, round((BELOW_M + ABOVE_M) / edge)]))
        low = np.clip(points_m.min(axis=0), self._low_m, self._high_m)
        high = np.clip(points_m.max(axis=0), self._low_m, self._high_m)
        end = self.origin_m + np.array(self.shape) * edge
        step = round(GROW_M / edge)
        before = np.ceil(np.maximum(self.origin_m - low, 0) / edge / step).astype(int) * step
        after = np.ceil(np.maximum(high + edge - end, 0) / edge / step).astype(int) * step
        before[2] = after[2] = 0
        if before.any() or after.any():
            self.origin_m = self.origin_m - before * edge
            self._resize(before, np.array(self.shape) + before + after)

    def _resize(self, at: NDArray[np.int64], shape: NDArray[np.int64]) -> None:
        old = tuple(slice(start, start + n) for start, n in zip(at, self.shape, strict=True))
        size = tuple(int(n) for n in shape)
        missed, solid = np.ones(size, np.float32), np.zeros(size, np.int8)
        known, hidden = np.zeros(size, np.bool_), np.zeros(size, np.uint8)
        missed[old], solid[old] = self._missed, self._solid
        known[old], hidden[old] = self._known, self._hidden
        self._missed, self._solid, self._known, self._hidden = missed, solid, known, hidden
        unknown = np.full(missed.size + 1, self._settings.per_unknown_voxel, np.float32)
        opacity = np.full(missed.size + 1, UNKNOWN_OPACITY, np.float32)
        unknown[-1], opacity[-1] = 0.0, 1.0
        if self.value.size > 1:
            was = tuple(int(n) for n in (old[k].stop - old[k].start for k in range(3)))
            unknown[:-1].reshape(size)[old] = self.value[:-1].reshape(was)
            opacity[:-1].reshape(size)[old] = self.opacity[:-1].reshape(was)
        self.value, self.opacity = unknown, opacity

    def _in_sight(self, camera: Camera) -> tuple[slice, slice]:
        """Return the columns that a frame can change: the ground below its pyramid of sight."""
        lens, (width, height) = camera.intrinsics, camera.size_px
        u, v = np.array([0, width, 0, width]), np.array([0, 0, height, height])
        local = np.stack([(u - lens.cx) / lens.fx, (v - lens.cy) / lens.fy, np.ones(4)], axis=1)
        corners = np.concatenate(
            [local * self._settings.sight_m @ camera.rotation, np.zeros((1, 3))]
        )
        offset = camera.position_m - self.origin_m
        first = np.floor((corners.min(axis=0) + offset) / self.edge_m - 1).astype(int)
        last = np.ceil((corners.max(axis=0) + offset) / self.edge_m + 1).astype(int)
        a, b, _ = self.shape
        rows = slice(min(max(first[0], 0), a), min(max(last[0], 0), a))
        return rows, slice(min(max(first[1], 0), b), min(max(last[1], 0), b))

    def _in_image(
        self, camera: Camera, box: tuple[slice, slice]
    ) -> tuple[NDArray[np.int64], Floats, Floats, Floats]:
        """Return (flat index, depth, u_px, v_px) of the voxels whose centre is in the image."""
        starts, counts = (box[0].start, box[1].start, 0), (*_sizes(box), self.shape[2])
        offset = [
            self.origin_m[k] + (start + np.arange(n) + 0.5) * self.edge_m - camera.position_m[k]
            for k, (start, n) in enumerate(zip(starts, counts, strict=True))
        ]
        turn = camera.rotation
        x, y, z = (
            turn[k, 0] * offset[0][:, None, None]
            + turn[k, 1] * offset[1][None, :, None]
            + turn[k, 2] * offset[2][None, None, :]
            for k in range(3)
        )
        cell = np.nonzero((z > NEAREST_M) & (z < self._settings.sight_m))
        lens = camera.intrinsics
        depth = z[cell]
        u = x[cell] / depth * lens.fx + lens.cx
        v = y[cell] / depth * lens.fy + lens.cy
        inside = (u >= 0) & (u < camera.size_px[0]) & (v >= 0) & (v < camera.size_px[1])
        a, b, c = (part[inside] for part in cell)
        _, wide, tall = self.shape
        flat = ((a + starts[0]) * wide + b + starts[1]) * tall + c
        return flat, depth[inside], u[inside], v[inside]


def _sizes(box: tuple[slice, slice]) -> tuple[int, int]:
    return box[0].stop - box[0].start, box[1].stop - box[1].start


def _points(camera: Camera, thumb_m: Singles, most_m: float) -> tuple[Floats, Floats]:
    """Return the thumbnail's surface points (n, 3) in map axes, and their depth."""
    width, height = camera.size_px
    lens = camera.intrinsics
    side = (np.arange(THUMB_PX) + 0.5) / THUMB_PX
    v, u = np.meshgrid(np.floor(side * height) + 0.5, np.floor(side * width) + 0.5, indexing="ij")
    good = (thumb_m > NEAREST_M) & (thumb_m < most_m)
    z = thumb_m[good].astype(np.float64)
    local = np.stack([(u[good] - lens.cx) / lens.fx * z, (v[good] - lens.cy) / lens.fy * z, z], 1)
    return local @ camera.rotation + camera.position_m, z


def _spread(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return a mask grown by one to its four sides."""
    out = mask.copy()
    out[1:] |= mask[:-1]
    out[:-1] |= mask[1:]
    out[:, 1:] |= mask[:, :-1]
    out[:, :-1] |= mask[:, 1:]
    return out


def distances(
    walkable: NDArray[np.bool_], start: tuple[int, int], most: int = 400
) -> NDArray[np.float32]:
    """Return the steps (a, b) to each walkable cell from a start, by a wave; inf where none.

    Straight steps count 1, so the way is up to 1.4 times too long across; good enough to weigh.
    """
    out = np.full(walkable.shape, np.inf, np.float32)
    reached = np.zeros_like(walkable)
    reached[start] = True
    out[start] = 0.0
    for step in range(1, most):
        wave = _spread(reached) & (walkable | reached)
        new = wave & ~reached
        if not new.any():
            break
        out[new] = step
        reached = wave
    return out
