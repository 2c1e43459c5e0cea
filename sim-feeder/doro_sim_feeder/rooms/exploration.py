"""Where the robot looks from: a seeded pseudo-random walk over the reachable cells."""

from __future__ import annotations

import msgspec
import numpy as np
from numpy.typing import NDArray

from doro_schemas.camera import Pose, pose_from_ai2thor
from doro_sim_feeder.rooms.placement import CAMERA_HEIGHT_M

YAW_STEP_DEG = 45
HORIZONS_DEG = (0, 30)


class View(msgspec.Struct, frozen=True):
    """One observation: the camera's position (x, y, z metres), yaw and horizon in degrees."""

    position_m: tuple[float, float, float]
    yaw_deg: int
    horizon_deg: int

    def pose(self) -> Pose:
        return pose_from_ai2thor(self.position_m, self.yaw_deg, self.horizon_deg)


def plan_views(cells: NDArray[np.float64], count: int | None, seed: int) -> list[View]:
    """Return one view per cell in walking order (paper, Section V: pseudo-random yaw).

    Args:
        cells: float64 (n, 2), x and z of the reachable cells.
        count: how many views; None or more than there are cells: every cell once.
    """
    rng = np.random.default_rng([seed, 1])
    order = rng.permutation(len(cells))
    chosen = cells[order[: len(cells) if count is None else count]]
    views = []
    for x, z in _walk(chosen):
        yaw_deg = YAW_STEP_DEG * int(rng.integers(360 // YAW_STEP_DEG))
        horizon_deg = HORIZONS_DEG[int(rng.integers(len(HORIZONS_DEG)))]
        views.append(View((float(x), CAMERA_HEIGHT_M, float(z)), yaw_deg, horizon_deg))
    return views


def _walk(cells: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the cells from the first on, each followed by the nearest one left."""
    left = list(range(1, len(cells)))
    path = [0] if len(cells) else []
    while left:
        distances = np.hypot(*(cells[left] - cells[path[-1]]).T)
        path.append(left.pop(int(distances.argmin())))
    return cells[path]
