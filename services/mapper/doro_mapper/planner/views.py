"""Views that may be taken next: those the robot named, or the free floor that was seen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import msgspec
import numpy as np
from numpy.typing import NDArray

from doro_mapper.planner.settings import PlannerSettings
from doro_mapper.planner.space import Space, distances
from doro_mapper.views import THUMB_PX, Camera, Floats, camera_of
from doro_schemas.camera import World, bev_axes
from doro_schemas.messages import DepthFrame
from doro_schemas.viewpoint import Viewpoint

SAME_PLACE_M = 0.1
SAME_COSINE = 0.985
"""Directions within 10 degrees are one: no robot stops to the centimetre."""
DETOUR = 1.5
"""A place that no seen floor leads to is taken to be so much farther than the straight line."""
STRIDE_M = 0.6
"""Own proposals stand so far apart."""


@dataclass(frozen=True, slots=True)
class Look:
    """What the planner keeps of a frame: its camera and a depth thumbnail, about 10 kB."""

    camera: Camera
    thumb_m: NDArray[np.float32]
    world: World


def look_of(depth: DepthFrame) -> Look:
    """Return what the planner keeps of a frame."""
    width, height = depth.width_px, depth.height_px
    side = (np.arange(THUMB_PX) + 0.5) / THUMB_PX
    data = depth.data[np.ix_((side * height).astype(int), (side * width).astype(int))]
    small = msgspec.structs.replace(depth, width_px=THUMB_PX, height_px=THUMB_PX, data=data)
    camera = camera_of(depth.intrinsics, depth.pose, (width, height))
    return Look(camera, small.depth_m(), depth.pose.world)


@dataclass(slots=True)
class Candidates:
    """Views to choose from.

    Attributes:
        views: as the robot named them, angles filled in.
        position_m: (n, 3) map axes.
        rotation: (n, 3, 3) world-to-camera, map axes; rows are right, down, forward.
        taken: (n,) a frame came from there.
        area_gain: (n,) what each promised to show when last looked at; inf: never was.
        open_share: (n,) share of the things before it that nothing was in the way of then.
    """

    views: list[Viewpoint]
    position_m: Floats
    rotation: Floats
    taken: NDArray[np.bool_]
    area_gain: Floats
    open_share: Floats

    def __len__(self) -> int:
        return len(self.views)

    def take(self, cameras: Sequence[Camera]) -> None:
        """Strike out the views that frames came from."""
        if not cameras or not len(self):
            return
        places = np.array([camera.position_m for camera in cameras])
        ahead = np.array([camera.rotation[2] for camera in cameras])
        gap = np.linalg.norm(self.position_m[:, None] - places[None], axis=2)
        alike = self.rotation[:, 2] @ ahead.T > SAME_COSINE
        self.taken |= (alike & (gap < SAME_PLACE_M)).any(axis=1)

    def joined(self, other: Candidates) -> Candidates:
        """Return these and others behind them."""
        return Candidates(
            [*self.views, *other.views],
            np.concatenate([self.position_m, other.position_m]),
            np.concatenate([self.rotation, other.rotation]),
            np.concatenate([self.taken, other.taken]),
            np.concatenate([self.area_gain, other.area_gain]),
            np.concatenate([self.open_share, other.open_share]),
        )


def candidates_of(
    named: Sequence[Viewpoint], world: World, settings: PlannerSettings
) -> Candidates:
    """Return the views that a robot named, with every direction where it left one open."""
    views = [view for one in named for view in _directions(one, settings)]
    if len(views) > settings.max_views:
        chosen = np.linspace(0, len(views) - 1, settings.max_views).round().astype(int)
        views = [views[i] for i in chosen]
    axes = list(bev_axes(world))
    poses = [view.pose(world) for view in views]
    n = len(views)
    position = np.array([pose.position_m for pose in poses]).reshape(n, 3)[:, axes]
    rotation = np.array([pose.matrix()[axes].T for pose in poses]).reshape(n, 3, 3)
    never = np.full(n, np.inf)
    return Candidates(views, position, rotation, np.zeros(n, np.bool_), never, np.ones(n))


def _directions(view: Viewpoint, settings: PlannerSettings) -> list[Viewpoint]:
    yaws = [view.yaw_deg]
    if view.yaw_deg is None:
        yaws = [360.0 * k / settings.yaws for k in range(settings.yaws)]
    horizons = [view.horizon_deg] if view.horizon_deg is not None else settings.horizons_deg
    return [Viewpoint(view.position_m, yaw, horizon) for yaw in yaws for horizon in horizons]


class Proposals:
    """Views on the free floor that can be reached, in all directions, at the camera's height.

    Kept while the floor seen grows, as what each promised last is needed again. Bounded by
    ``max_views``: where it is full, no further places are proposed.
    """

    def __init__(self, settings: PlannerSettings, world: World) -> None:
        self._settings, self._world = settings, world
        self.candidates = candidates_of([], world, settings)
        self._first: dict[tuple[int, int, int], int] = {}
        self._each = settings.yaws * len(settings.horizons_deg)

    def update(
        self, space: Space, cameras: Sequence[Camera], way: NDArray[np.float32]
    ) -> NDArray[np.bool_]:
        """Take over the floor as seen now; return which of the candidates stand on it."""
        stride = max(1, round(STRIDE_M / space.edge_m))
        cells = np.argwhere(np.isfinite(way))
        # A raster that stands still while the map grows to any side.
        numbers = cells + np.rint(space.origin_m[:2] / space.edge_m).astype(np.int64)
        numbers = numbers[(numbers % stride == 0).all(axis=1)]
        height_m = float(cameras[-1].position_m[2])
        level = round(height_m / space.edge_m)
        keys = [(int(a), int(b), level) for a, b in numbers]
        room = self._settings.max_views // self._each - len(self._first)
        new = [key for key in keys if key not in self._first][: max(0, room)]
        if new:
            places = [(np.array(key[:2]) + 0.5) * space.edge_m for key in new]
            found = candidates_of(
                [self._viewpoint(a, b, height_m) for a, b in places], self._world, self._settings
            )
            found.take(cameras)
            for number, key in enumerate(new):
                self._first[key] = len(self.candidates) + number * self._each
            self.candidates = self.candidates.joined(found)
        allowed = np.zeros(len(self.candidates), np.bool_)
        for key in keys:
            if key in self._first:
                allowed[self._first[key] : self._first[key] + self._each] = True
        return allowed

    def _viewpoint(self, a: float, b: float, height_m: float) -> Viewpoint:
        position = [0.0, 0.0, 0.0]
        for axis, value in zip(bev_axes(self._world), (a, b, height_m), strict=True):
            position[axis] = round(float(value), 4)
        return Viewpoint(position)


def ways(space: Space, cameras: Sequence[Camera], settings: PlannerSettings) -> NDArray[np.float32]:
    """Return the way in metres (a, b) over the floor seen from the last camera; inf where none.

    Args:
        cameras: where the robot has been: it can stand there, though it saw no floor below it.
    """
    walkable = space.walkable(cameras[-1].position_m, settings.radius_m)
    places = np.array([camera.position_m for camera in cameras])
    cells = np.floor((places - space.origin_m) / space.edge_m).astype(int)[:, :2]
    cells = np.clip(cells, 0, np.array(walkable.shape) - 1)
    for a, b in np.unique(cells, axis=0):
        walkable[max(a - 1, 0) : a + 2, max(b - 1, 0) : b + 2] = True
    a, b = cells[-1]
    return distances(walkable, (int(a), int(b))) * np.float32(space.edge_m)


def way_to(space: Space, camera: Camera, way: NDArray[np.float32], places_m: Floats) -> Floats:
    """Return the way to each place (n,), metres."""
    straight = np.hypot(*(places_m[:, :2] - camera.position_m[:2]).T)
    cell = np.floor((places_m[:, :2] - space.origin_m[:2]) / space.edge_m).astype(int)
    inside = np.asarray(((cell >= 0) & (cell < way.shape)).all(axis=1))
    cell = np.where(inside[:, None], cell, 0)
    walked = np.where(inside, way[cell[:, 0], cell[:, 1]], np.inf)
    # The wave goes in steps along the axes: never shorter than straight, at most 1.4 of it.
    return np.where(np.isfinite(walked), np.maximum(straight, walked * 0.85), DETOUR * straight)
