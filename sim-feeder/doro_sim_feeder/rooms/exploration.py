"""Where the robot looks from, in one of several orders behind one interface.

An order takes the reachable cells and returns the views; ``ORDERS`` names them. ``random`` is
the paper's, ``sweep`` mows the room. The order that plans by what is still uncertain follows the
mapper's goals (:mod:`doro_sim_feeder.planned`): it needs a running map, so it plays a recording.
"""

from __future__ import annotations

from typing import Protocol

import msgspec
import numpy as np
from numpy.typing import NDArray

from doro_schemas.camera import Pose, pose_from_ai2thor
from doro_schemas.errors import Refused
from doro_sim_feeder.rooms.footprints import CELL_M
from doro_sim_feeder.rooms.placement import CAMERA_HEIGHT_M

YAW_STEP_DEG = 45
HORIZONS_DEG = (0, 30)
SWEEP_STRIDE = 3
SWEEP_YAWS_DEG = (0, 90, 180, 270)
SWEEP_HORIZON_DEG = 20


class View(msgspec.Struct, frozen=True):
    """One observation: the camera's position (x, y, z metres), yaw and horizon in degrees."""

    position_m: tuple[float, float, float]
    yaw_deg: int
    horizon_deg: int

    def pose(self) -> Pose:
        return pose_from_ai2thor(self.position_m, self.yaw_deg, self.horizon_deg)


class Order(Protocol):
    """Returns the views over reachable cells, float64 (n, 2) of x and z, for a seed."""

    def __call__(self, cells: NDArray[np.float64], count: int | None, seed: int) -> list[View]: ...


def plan_views(
    cells: NDArray[np.float64], count: int | None, seed: int, order: str = "random"
) -> list[View]:
    """Return the views of an exploration.

    Args:
        cells: float64 (n, 2), x and z of the reachable cells.
        count: how many views at most; None: all that the order has.
        order: a name of :data:`ORDERS`.

    Raises:
        Refused: there is no such order.
    """
    if order not in ORDERS:
        hint = "; goals are followed by 'doro play --order planned'" if order == "planned" else ""
        raise Refused(
            f"there is no order '{order}' of exploration: use {' or '.join(ORDERS)}{hint}"
        )
    return ORDERS[order](cells, count, seed)


def random_views(cells: NDArray[np.float64], count: int | None, seed: int) -> list[View]:
    """Return one view per cell in walking order (paper, Section V: pseudo-random yaw)."""
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


def sweep_views(cells: NDArray[np.float64], count: int | None, seed: int) -> list[View]:
    """Return four views from every third cell of every third row, row by row to and fro.

    The seed has no part in it. With ``count`` the views are thinned evenly.
    """
    del seed
    index = np.rint(cells / CELL_M).astype(np.int64)
    phase = index % SWEEP_STRIDE
    best: tuple[int, NDArray[np.int64]] = (-1, index[:0])
    for x in range(SWEEP_STRIDE):
        for z in range(SWEEP_STRIDE):
            chosen = index[(phase == (x, z)).all(axis=1)]
            best = max(best, (len(chosen), chosen), key=lambda pair: pair[0])
    views = []
    for number, row in enumerate(np.unique(best[1][:, 0])):
        along = np.sort(best[1][best[1][:, 0] == row, 1])
        for z in along if number % 2 == 0 else along[::-1]:
            position = (float(row) * CELL_M, CAMERA_HEIGHT_M, float(z) * CELL_M)
            views += [View(position, yaw_deg, SWEEP_HORIZON_DEG) for yaw_deg in SWEEP_YAWS_DEG]
    if count is None or count >= len(views):
        return views
    return [views[int(k)] for k in np.linspace(0, len(views) - 1, count).round()]


ORDERS: dict[str, Order] = {"random": random_views, "sweep": sweep_views}
