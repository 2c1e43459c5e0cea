"""Ground geometry of a room: its rectangle, counters that are no rectangles, free cells."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from doro_sim_feeder.rooms.layout import LayoutObject, RoomLayout

CELL_M = 0.25
AGENT_RADIUS_M = 0.2
AGENT_HEIGHT_M = 1.7
STEP_OVER_M = 0.12
CARVE_M = 0.05
COUNTER_DEPTH_M = 0.72
NARROW_M = 0.95
WALL_REACH_M = 0.35
HULL_M = 0.5
ON_WALLS = frozenset(
    {"Window", "Curtains", "Blinds", "Mirror", "Painting", "Poster", "LightSwitch", "Towel"}
)


@dataclass(frozen=True)
class Rect:
    """A rectangle on the ground, metres."""

    x_low: float
    x_high: float
    z_low: float
    z_high: float

    def distance_m(self, cells: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the distance of ground points (n, 2) to the rectangle; 0 inside."""
        x, z = cells[:, 0], cells[:, 1]
        dx = np.maximum(np.maximum(self.x_low - x, x - self.x_high), 0)
        dz = np.maximum(np.maximum(self.z_low - z, z - self.z_high), 0)
        return np.hypot(dx, dz)


def rect_of(item: LayoutObject) -> Rect:
    return Rect(item.low_m[0], item.high_m[0], item.low_m[2], item.high_m[2])


def content_rects(layout: RoomLayout) -> list[Rect]:
    """Return the footprints of all that stands or hangs in the room, the floor left out."""
    return [rect_of(item) for item in layout.objects if item.object_type != "Floor"]


def room_rect(layout: RoomLayout) -> Rect:
    """Return the room's rectangle: what encloses all that stands or hangs in it.

    The floor's own box does not count: in iTHOR it reaches metres beyond the walls.
    """
    rects = content_rects(layout)
    return Rect(
        min(rect.x_low for rect in rects),
        max(rect.x_high for rect in rects),
        min(rect.z_low for rect in rects),
        max(rect.z_high for rect in rects),
    )


def enclosed(cells: NDArray[np.float64], rects: list[Rect]) -> NDArray[np.bool_]:
    """Tell which ground points (n, 2) are within ``HULL_M`` of the rectilinear hull.

    A point lies outside of the hull if one of the four quadrants at it is empty. Rooms are no
    rectangles; a corner in which nothing stands or hangs is taken to lie behind a wall.
    """
    low = np.array([(rect.x_low, rect.z_low) for rect in rects]) - HULL_M
    high = np.array([(rect.x_high, rect.z_high) for rect in rects]) + HULL_M
    below = [low[:, axis] <= cells[:, axis, None] for axis in (0, 1)]
    above = [high[:, axis] >= cells[:, axis, None] for axis in (0, 1)]
    inside = np.ones(len(cells), bool)
    for side_x in (below[0], above[0]):
        for side_z in (below[1], above[1]):
            inside &= (side_x & side_z).any(axis=1)
    return inside


def counter_rects(layout: RoomLayout, counter: LayoutObject, room: Rect) -> list[Rect]:
    """Return the rectangles that a counter covers.

    iTHOR gives one box for a counter that runs around corners. Kept of a wide box is what
    lies along a wall that it touches, over cabinets and drawers, or near things that stand
    on it; sinks are cut out of every counter.
    """
    rect = rect_of(counter)
    nx = max(1, round((rect.x_high - rect.x_low) / CARVE_M))
    nz = max(1, round((rect.z_high - rect.z_low) / CARVE_M))
    dx, dz = (rect.x_high - rect.x_low) / nx, (rect.z_high - rect.z_low) / nz
    x = rect.x_low + (np.arange(nx) + 0.5) * dx
    z = rect.z_low + (np.arange(nz) + 0.5) * dz
    cells = np.stack(np.meshgrid(x, z, indexing="ij"), axis=-1).reshape(-1, 2)
    keep = np.ones(len(cells), bool)
    if min(rect.x_high - rect.x_low, rect.z_high - rect.z_low) > NARROW_M:
        keep = _along_walls(cells, rect, room) | _over_evidence(cells, layout, counter)
    for basin in layout.of_type("SinkBasin"):
        keep &= rect_of(basin).distance_m(cells) > 0
    return [
        Rect(
            rect.x_low + i0 * dx,
            rect.x_low + i1 * dx,
            rect.z_low + j0 * dz,
            rect.z_low + j1 * dz,
        )
        for i0, i1, j0, j1 in _rectangles(keep.reshape(nx, nz))
    ]


def _along_walls(cells: NDArray[np.float64], rect: Rect, room: Rect) -> NDArray[np.bool_]:
    near = np.zeros(len(cells), bool)
    if rect.x_low - room.x_low < WALL_REACH_M:
        near |= cells[:, 0] < rect.x_low + COUNTER_DEPTH_M
    if room.x_high - rect.x_high < WALL_REACH_M:
        near |= cells[:, 0] > rect.x_high - COUNTER_DEPTH_M
    if rect.z_low - room.z_low < WALL_REACH_M:
        near |= cells[:, 1] < rect.z_low + COUNTER_DEPTH_M
    if room.z_high - rect.z_high < WALL_REACH_M:
        near |= cells[:, 1] > rect.z_high - COUNTER_DEPTH_M
    return near


def _over_evidence(
    cells: NDArray[np.float64], layout: RoomLayout, counter: LayoutObject
) -> NDArray[np.bool_]:
    near = np.zeros(len(cells), bool)
    for item in layout.objects:
        below = item.object_type in ("Cabinet", "Drawer") and item.low_m[1] < counter.low_m[1]
        margin_m = 0.05 if below else 0.15
        if below or counter.object_id in item.receptacles:
            near |= rect_of(item).distance_m(cells) < margin_m
    return near


def _rectangles(mask: NDArray[np.bool_]) -> list[tuple[int, int, int, int]]:
    """Return rectangles (i0, i1, j0, j1), upper ends exclusive, that tile the mask."""
    left = mask.copy()
    found = []
    while left.any():
        i0, j0 = (int(value) for value in np.argwhere(left)[0])
        j1 = j0
        while j1 < left.shape[1] and left[i0, j1]:
            j1 += 1
        i1 = i0
        while i1 < left.shape[0] and left[i1, j0:j1].all():
            i1 += 1
        left[i0:i1, j0:j1] = False
        found.append((i0, i1, j0, j1))
    return found


def reachable_cells(
    room: Rect, obstacles: list[Rect], contents: list[Rect] | None = None
) -> NDArray[np.float64]:
    """Return the cells where the agent can stand, float64 (n, 2) of x and z, sorted.

    The 0.25 m grid of the room, less what lies within the agent's radius of a wall or an
    obstacle; of the rest the largest connected component (4 neighbours).

    Args:
        contents: footprints of all that is in the room; cells outside of their hull
            (:func:`enclosed`) are left out. None: the whole rectangle counts.
    """
    x = np.arange(np.ceil(room.x_low / CELL_M), np.floor(room.x_high / CELL_M) + 1) * CELL_M
    z = np.arange(np.ceil(room.z_low / CELL_M), np.floor(room.z_high / CELL_M) + 1) * CELL_M
    cells = np.stack(np.meshgrid(x, z, indexing="ij"), axis=-1).reshape(-1, 2)
    free = (cells[:, 0] - room.x_low >= AGENT_RADIUS_M) & (
        room.x_high - cells[:, 0] >= AGENT_RADIUS_M
    )
    free &= (cells[:, 1] - room.z_low >= AGENT_RADIUS_M) & (
        room.z_high - cells[:, 1] >= AGENT_RADIUS_M
    )
    for obstacle in obstacles:
        free &= obstacle.distance_m(cells) >= AGENT_RADIUS_M
    if contents:
        free &= enclosed(cells, contents)
    component = _largest_component(free.reshape(len(x), len(z)))
    return cells[component.ravel()]


def largest_part(cells: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the largest connected part (4 neighbours) of cells on the grid, sorted as given."""
    if not len(cells):
        return cells
    index = np.rint(cells / CELL_M).astype(np.int64)
    index -= index.min(axis=0)
    grid = np.zeros(tuple(index.max(axis=0) + 1), bool)
    grid[index[:, 0], index[:, 1]] = True
    return cells[_largest_component(grid)[index[:, 0], index[:, 1]]]


def _largest_component(free: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return the largest component; of equal ones the one that comes first in the grid."""
    _, label, stats, _ = cv2.connectedComponentsWithStats(free.astype(np.uint8), connectivity=4)
    areas = stats[1:, cv2.CC_STAT_AREA]
    if not len(areas):
        return free
    result: NDArray[np.bool_] = label == 1 + int(areas.argmax())
    return result
