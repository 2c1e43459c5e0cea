"""Places where a copy may stand: drawn on supports, tested for room and for being seen."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from doro_sim_feeder.rooms.footprints import AGENT_RADIUS_M, Rect, largest_part
from doro_sim_feeder.rooms.instances import BACKGROUND, Instance
from doro_sim_feeder.rooms.parts import Part, bounds, yaw_matrix
from doro_sim_feeder.rooms.raycast import RayCaster
from doro_sim_feeder.rooms.scene import Scene

CAMERA_HEIGHT_M = 1.576
CANDIDATES = 2500
FLAT_M = 0.012
SOFT_M = 0.07  # what soft things may lean on: cushions are no planes
CLEARANCE_M = 0.03
SEEN_WITHIN_M = 2.6
CLOSE_M = (0.1, 0.3)
SURFACES = frozenset(
    """CounterTop DiningTable CoffeeTable SideTable Desk Dresser TVStand Shelf ShelvingUnit
    Sofa Bed ArmChair""".split()  # noqa: SIM905
)
SOFT = frozenset({"Pillow", "TeddyBear", "Cloth"})


@dataclass(frozen=True)
class Candidates:
    """Places to try: ground positions, yaw, supports' indices, and where rays fall from."""

    x: NDArray[np.float64]
    z: NDArray[np.float64]
    yaw_deg: NDArray[np.float64]
    support: NDArray[np.int64]
    from_m: NDArray[np.float64]


def draw_places(
    scene: Scene, on_floor: bool, rng: np.random.Generator, beside: Instance | None = None
) -> Candidates | None:
    """Return places drawn over all supports, or around a copy; None without any support."""
    wanted = frozenset({"Floor"}) if on_floor else SURFACES
    supports = [k for k, item in enumerate(scene.instances) if item.object_type in wanted]
    if not supports:
        return None
    chosen = rng.choice(np.asarray(supports), CANDIDATES)
    share = rng.random((CANDIDATES, 2))
    turn = rng.random(CANDIDATES) * 360
    if on_floor:
        turn = np.floor(turn / 90) * 90
    low = np.array([scene.instances[k].corners[0] for k in chosen])
    high = np.array([scene.instances[k].corners[1] for k in chosen])
    x = low[:, 0] + share[:, 0] * (high[:, 0] - low[:, 0])
    z = low[:, 2] + share[:, 1] * (high[:, 2] - low[:, 2])
    if beside is not None:
        around = share[:, 0] * 2 * np.pi
        own = max(beside.box().size_m[:2])  # large things stand as close as their size allows
        reach = np.maximum(CLOSE_M[0], own + 0.02) + share[:, 1] * (CLOSE_M[1] - CLOSE_M[0])
        center = beside.box().center_m
        x, z = center[0] + reach * np.cos(around), center[1] + reach * np.sin(around)
        names = [scene.instances[k].object_id for k in supports]
        if beside.receptacles and beside.receptacles[0] in names:
            index = supports[names.index(beside.receptacles[0])]
            chosen = np.full(CANDIDATES, index)
            high = np.tile(scene.instances[index].corners[1], (CANDIDATES, 1))
    return Candidates(x, z, turn, chosen, high[:, 1] + (2.4 if on_floor else 0.3))


def surface_heights(
    caster: RayCaster, places: Candidates, size_m: NDArray[np.floating[Any]], soft: bool
) -> NDArray[np.float64]:
    """Return the height of the surface below each place; NaN where it is not flat."""
    steps = np.linspace(-0.48, 0.48, 5)
    across, along = (grid.ravel() for grid in np.meshgrid(steps, steps))
    across, along = across * size_m[0], along * size_m[2]
    yaw = np.radians(places.yaw_deg)[:, None]
    x = places.x[:, None] + np.cos(yaw) * across + np.sin(yaw) * along
    z = places.z[:, None] - np.sin(yaw) * across + np.cos(yaw) * along
    y = np.broadcast_to(places.from_m[:, None], x.shape)
    origins = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    down = np.broadcast_to(np.array([0.0, -1.0, 0.0]), origins.shape)
    height = y - caster.cast(origins, down).distance.reshape(x.shape)
    height = np.where(np.isfinite(height), height, -1e3)
    flat = np.ptp(height, axis=1) <= (SOFT_M if soft else FLAT_M)
    return np.where(flat, height.max(axis=1), np.nan)


def turned_size_m(shape: tuple[Part, ...], yaw_deg: float) -> NDArray[np.float64]:
    """Return the extent of a shape's box after a turn, which encloses the turned shape."""
    low, high = bounds(shape)
    size: NDArray[np.float64] = np.abs(yaw_matrix(yaw_deg)) @ np.maximum(
        np.abs(low), np.abs(high)
    ).astype(np.float64)
    return np.array([2 * size[0], float(high[1]), 2 * size[2]])


def room_for(
    center: NDArray[np.float64], size_m: NDArray[np.float64], scene: Scene, made: list[Instance]
) -> bool:
    """Tell whether a box, standing at ``center``, keeps its distance from all boxes around."""
    low = center - size_m * [0.5, 0, 0.5]
    high = center + size_m * [0.5, 1, 0.5]
    for item in (*scene.instances, *made):
        if item.object_type in BACKGROUND:
            continue
        other_low, other_high = item.corners
        overlaps = (low - CLEARANCE_M < other_high) & (high + CLEARANCE_M > other_low)
        if overlaps.all() and other_high[1] > low[1] + FLAT_M and other_low[1] > low[1] - 0.02:
            return False
    return True


def seen_from(scene: Scene, caster: RayCaster, middle_m: NDArray[np.float64]) -> int:
    """Return from how many cells a point is in view and near enough to make out."""
    cells = scene.cells
    eyes = np.column_stack([cells[:, 0], np.full(len(cells), CAMERA_HEIGHT_M), cells[:, 1]])
    rays = middle_m - eyes
    near = np.linalg.norm(rays, axis=1) < SEEN_WITHIN_M
    return int((near & ~caster.occluded(eyes, rays, reach=0.97)).sum())


def still_reached(
    cells: NDArray[np.float64], size_m: NDArray[np.float64], center: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the cells that stay reachable with a box of this size on the floor."""
    blocked = Rect(
        center[0] - size_m[0] / 2,
        center[0] + size_m[0] / 2,
        center[2] - size_m[2] / 2,
        center[2] + size_m[2] / 2,
    )
    return largest_part(cells[blocked.distance_m(cells) >= AGENT_RADIUS_M])
