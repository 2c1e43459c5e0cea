"""The rays by which the planner predicts what a view would show."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from doro_mapper.planner.settings import PlannerSettings
from doro_mapper.planner.space import noticed
from doro_mapper.views import Camera, Floats
from doro_schemas.camera import Intrinsics

RAYS = 9
"""Rays per side of a predicted image."""
NEAREST_RAY_M = 0.4


@dataclass(frozen=True, slots=True)
class Fan:
    """The rays of a coarse image.

    Attributes:
        camera: intrinsics and size it was made for.
        rays: (r, 3) unit vectors, camera axes.
        reach: (s,) distances along each, in voxels.
        share: (r, s) how many voxels each sample stands for, times the chance to notice a small
            thing there. A ray stands for its solid angle, so a voxel that several rays cross
            is not counted several times over.
    """

    camera: tuple[Intrinsics, tuple[int, int]]
    rays: Floats
    reach: NDArray[np.float32]
    share: NDArray[np.float32]


def fan_of(camera: Camera, edge_m: float, options: PlannerSettings) -> Fan:
    """Return the rays of a camera through voxels of an edge."""
    lens, (width, height) = camera.intrinsics, camera.size_px
    side = (np.arange(RAYS) + 0.5) / RAYS
    v, u = np.meshgrid(side * height, side * width, indexing="ij")
    x, y = (u.ravel() - lens.cx) / lens.fx, (v.ravel() - lens.cy) / lens.fy
    slant = np.sqrt(1 + x**2 + y**2)
    reach_m = np.arange(NEAREST_RAY_M, options.sight_m, edge_m)
    chance = options.trust * noticed(options.small_m, reach_m, lens.fy, options.least_px)
    # The pixels a ray stands for, seen obliquely away from the axis.
    angle = (width / RAYS / lens.fx) * (height / RAYS / lens.fy) / slant**3
    share = angle[:, None] * (reach_m**2 * chance / edge_m**2)[None]
    return Fan(
        camera=(lens, camera.size_px),
        rays=np.stack([x, y, np.ones_like(x)], axis=1) / slant[:, None],
        reach=(reach_m / edge_m).astype(np.float32),
        share=share.astype(np.float32),
    )
