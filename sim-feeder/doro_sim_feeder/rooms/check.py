"""Checks of rendered rooms: geometry of the pictures, contact of what stands in them."""

from __future__ import annotations

from collections.abc import Iterator

import msgspec
import numpy as np
from numpy.typing import NDArray

from doro_schemas.camera import backproject
from doro_schemas.errors import Refused
from doro_sim_feeder.rooms.contact import contacts
from doro_sim_feeder.rooms.copies import CopySpec
from doro_sim_feeder.rooms.episode import RoomEpisode
from doro_sim_feeder.rooms.exploration import View
from doro_sim_feeder.rooms.footprints import ON_WALLS
from doro_sim_feeder.rooms.layout import FIRST_ROOM, load_layout, room_names

MIN_POINTS = 30
BOX_LIMIT_M = 0.01
FEWEST_CELLS = 15
CHECK_VIEWS = 8
PERCENTILE = 99.0


class RoomCheck(msgspec.Struct, frozen=True):
    """What came out for a room.

    Attributes:
        problem: why the room is refused; empty where it is fine.
        worst_box_m: largest distance, over all instances in all views, by which the 99th
            percentile of an instance's back-projected points leaves its rendered box.
        worst_instance: the instance that it belongs to.
        holes: pixels in which nothing was hit.
        copies: copies placed; missing: copies asked for without a place, by name and reason.
        loose: copies that float or penetrate by more than 1 cm.
        own_loose: the room's own small things that do (iTHOR puts some inside others).
        inner_wall: types of what hangs on inner walls, which are not in the data: left out.
    """

    room: str
    problem: str = ""
    cells: int = 0
    instances: int = 0
    measured: int = 0
    worst_box_m: float = 0.0
    worst_instance: str = ""
    holes: int = 0
    copies: int = 0
    missing: tuple[str, ...] = ()
    loose: tuple[str, ...] = ()
    own_things: int = 0
    own_loose: tuple[str, ...] = ()
    inner_wall: tuple[str, ...] = ()


def all_rooms() -> list[str]:
    """Return all 120 iTHOR rooms: kitchens, living rooms, bedrooms, bathrooms."""
    return [name for kind in FIRST_ROOM for name in room_names(kind)]


def check_rooms(
    rooms: list[str], *, views: int = CHECK_VIEWS, copies: CopySpec | None = None, seed: int = 0
) -> Iterator[RoomCheck]:
    """Yield the check of each room; one that cannot be rendered has its reason."""
    for room in rooms:
        try:
            yield check_room(room, views=views, copies=copies, seed=seed)
        except Refused as refused:
            yield RoomCheck(room, problem=refused.reason)


def check_room(
    room: str, *, views: int = CHECK_VIEWS, copies: CopySpec | None = None, seed: int = 0
) -> RoomCheck:
    """Render some views of a room and measure.

    Raises:
        Refused: the room cannot be rendered at all.
    """
    episode = RoomEpisode(room, seed=seed, copies=copies, color=False, allow_missing=True)
    step = max(1, len(episode.views) // max(1, views))
    measured, worst, holes = 0, (0.0, ""), 0
    for view in episode.views[::step][:views]:
        found, empty = outside_boxes(episode, view)
        measured += len(found)
        holes += empty
        worst = max([worst, *((distance, name) for name, distance in found.items())])
    instances = episode.scene.instances
    of_copies = contacts(instances)
    own = [c for c in contacts(instances, only_copies=False) if "|copy" not in c.object_id]
    result = RoomCheck(
        room=room,
        cells=len(episode.scene.cells),
        instances=len(instances),
        measured=measured,
        worst_box_m=round(worst[0], 5),
        worst_instance=worst[1],
        holes=holes,
        copies=len(of_copies),
        missing=tuple(f"{one.name}: {one.reason}" for one in episode.missing),
        loose=tuple(one.object_id for one in of_copies if not one.holds()),
        own_things=len(own),
        own_loose=tuple(one.object_id for one in own if not one.holds()),
        inner_wall=_left_out(room, {item.object_id for item in instances}),
    )
    return msgspec.structs.replace(result, problem=_problem(result))


def outside_boxes(episode: RoomEpisode, view: View) -> tuple[dict[str, float], int]:
    """Return, per instance of a view, how far its points leave its rendered box, and holes.

    The distance is the 99th percentile over the instance's pixels, metres, from depth as it
    travels (millimetres).
    """
    picture = episode.picture(view)
    depth_m = np.rint(picture.depth_m * 1000) / 1000
    found = {}
    for number in np.flatnonzero(np.bincount(picture.ids.ravel()) >= MIN_POINTS):
        if number == 0:
            continue
        rows, columns = np.nonzero(picture.ids == number)
        points = backproject(
            columns + 0.5, rows + 0.5, depth_m[rows, columns], episode.intrinsics, view.pose()
        )
        item = episode.scene.instances[int(number) - 1]
        found[item.object_id] = float(np.percentile(_outside_m(points, *item.corners), PERCENTILE))
    return found, int((picture.ids == 0).sum())


def _outside_m(
    points: NDArray[np.float64], low: NDArray[np.float32], high: NDArray[np.float32]
) -> NDArray[np.float64]:
    outside: NDArray[np.float64] = np.maximum(np.maximum(low - points, points - high), 0).max(
        axis=1
    )
    return outside


def _left_out(room: str, rendered: set[str]) -> tuple[str, ...]:
    objects = load_layout(room).objects
    missing = [o for o in objects if o.object_type in ON_WALLS and o.object_id not in rendered]
    return tuple(sorted(item.object_type for item in missing))


def _problem(check: RoomCheck) -> str:
    if check.cells < FEWEST_CELLS:
        return f"only {check.cells} reachable cells: at least {FEWEST_CELLS} are needed"
    if check.worst_box_m > BOX_LIMIT_M:
        return f"points of {check.worst_instance} lie {check.worst_box_m * 1000:.1f} mm off its box"
    if check.holes:
        return f"{check.holes} pixels hit nothing: the room's shell has a hole"
    if check.loose:
        return f"{', '.join(check.loose)} float or penetrate by more than 1 cm"
    return ""
