"""A room as rendered: every object of the layout in place, on its support, in known colours."""

from __future__ import annotations

from dataclasses import dataclass, replace

import msgspec
import numpy as np
from numpy.typing import NDArray

from doro_sim_feeder.rooms.appearance import PALETTE, color_of, material_of, recoloured
from doro_sim_feeder.rooms.contact import Around, Body
from doro_sim_feeder.rooms.fittings import Fitting, flat_parts, make_fitting
from doro_sim_feeder.rooms.footprints import (
    AGENT_HEIGHT_M,
    ON_WALLS,
    STEP_OVER_M,
    Rect,
    content_rects,
    reachable_cells,
    rect_of,
)
from doro_sim_feeder.rooms.instances import Instance
from doro_sim_feeder.rooms.layout import LayoutObject, RoomLayout, load_layout
from doro_sim_feeder.rooms.meshes import mesh_library
from doro_sim_feeder.rooms.parts import (
    Part,
    Rgb,
    blob_part,
    bounds,
    box_part,
    place,
    stable_number,
    yaw_matrix,
)
from doro_sim_feeder.rooms.raycast import RayCaster, make_soup

Vector = tuple[float, float, float]
SETTLE_FROM_M, SETTLE_DOWN_M = (0.03, 0.06, 0.12, 0.25), 1.5
RESTING_M = 0.0005  # air below a thing at rest, so that surfaces never cross by rounding
CEILING_LAMP_M = 2.3
# Boxes of the layout that are rendered as parts of something else or not at all.
SKIPPED = frozenset({"Floor", "CounterTop", "Sink", "SinkBasin", "Cabinet", "Drawer", "Wall"})
TABLES = frozenset({"DiningTable", "CoffeeTable", "SideTable", "Desk", "TVStand"})
WALL_GAP_M = 0.35
FLAT = ON_WALLS | {"Shelf", "StoveBurner", "StoveKnob"}
BLOBS: dict[str, tuple[Rgb, tuple[float, float], float]] = {
    "Apple": ((0.72, 0.07, 0.05), (1.0, 1.0), 0.3),
    "Tomato": ((0.82, 0.10, 0.04), (1.0, 1.0), 0.25),
    "Potato": ((0.45, 0.28, 0.13), (1.0, 1.0), 0.0),
    "Egg": ((0.92, 0.89, 0.82), (1.0, 1.0), 0.0),
    "Lettuce": ((0.22, 0.55, 0.12), (1.0, 1.0), 0.0),
    "Pillow": ((0.9, 0.9, 0.88), (0.75, 0.35), 0.0),
    "Ottoman": ((0.5, 0.4, 0.3), (0.3, 0.3), 0.0),
    "DogBed": ((0.5, 0.4, 0.3), (0.6, 0.6), 0.0),
    "DishSponge": ((0.9, 0.8, 0.2), (0.25, 0.25), 0.0),
    "SprayBottle": ((0.2, 0.4, 0.8), (0.5, 1.0), 0.0),
}


@dataclass(frozen=True)
class Scene:
    """A room ready to be rendered; the id of ``instances[k]`` in pictures is ``k + 1``.

    Attributes:
        cells: float64 (n, 2), x and z of the cells where the agent can stand.
        contents: footprints of the layout's objects, whose hull the cells lie in.
    """

    name: str
    room: Rect
    instances: tuple[Instance, ...]
    cells: NDArray[np.float64]
    contents: tuple[Rect, ...] = ()

    def caster(self) -> RayCaster:
        """Return the Embree scene of all instances."""
        return RayCaster(make_soup([(k + 1, i.parts) for k, i in enumerate(self.instances)]))

    def part_materials(self) -> list[str | None]:
        """Return the material of each part in the order of :func:`make_soup`."""
        return [instance.material for instance in self.instances for _ in instance.parts]

    def with_instances(self, added: list[Instance]) -> Scene:
        """Return the scene with more things, and without the cells that they block."""
        instances = (*self.instances, *added)
        return replace(self, instances=instances, cells=_cells(self.room, instances, self.contents))


def build_scene(name: str) -> Scene:
    """Return an iTHOR room as rendered, without spawned copies.

    Raises:
        Refused: no such room, or the layouts or meshes are not installed.
    """
    return build_layout(load_layout(name))


def build_layout(layout: RoomLayout) -> Scene:
    """Return a layout as rendered. Looks follow from the names in it, so that a layout of another
    name, with other asset ids, is the same room with other looks.
    """
    fitting = make_fitting(layout)
    instances = _fitted(layout, fitting)
    for item in layout.objects:
        if item.object_type not in SKIPPED and not _on_missing_wall(item, fitting.room):
            instances.append(_furnished(_standing(item), layout, fitting))
    settled = _settle(instances)
    contents = tuple(content_rects(layout))
    cells = _cells(fitting.room, tuple(settled), contents)
    return Scene(layout.name, fitting.room, tuple(settled), cells, contents)


def _fitted(layout: RoomLayout, fitting: Fitting) -> list[Instance]:
    instances = fitting.shell()
    for item in layout.of_type("CounterTop"):
        instances += fitting.counter(item)
    solid = [
        Rect(*_ground(part))
        for it in instances
        if it.object_type == "CounterTop"
        for part in it.parts
    ]
    solid += [rect_of(item) for item in layout.of_type("Fridge")]
    for item in layout.of_type("SinkBasin"):
        instances += fitting.basin(item)
    instances += fitting.stoves()
    for item in layout.of_type("Cabinet", "Drawer"):
        instances += fitting.front(item, solid)
    return instances


def _on_missing_wall(item: LayoutObject, room: Rect) -> bool:
    """Tell whether a thing hangs on an inner wall: only the outer walls are known."""
    (x0, _, z0), (x1, _, z1) = item.low_m, item.high_m
    gaps = (x0 - room.x_low, room.x_high - x1, z0 - room.z_low, room.z_high - z1)
    return item.object_type in ON_WALLS and min(gaps) > WALL_GAP_M


def _standing(item: LayoutObject) -> LayoutObject:
    """Return furniture whose recorded box is only its top with the box down to the floor."""
    if item.object_type not in TABLES or item.low_m[1] < 0.15:
        return item
    low = (item.low_m[0], 0.0, item.low_m[2])
    return msgspec.structs.replace(item, low_m=low, asset_size_m=None)


def _ground(part: Part) -> tuple[float, float, float, float]:
    low, high = bounds((part,))
    return float(low[0]), float(high[0]), float(low[2]), float(high[2])


def _cells(
    room: Rect, instances: tuple[Instance, ...], contents: tuple[Rect, ...]
) -> NDArray[np.float64]:
    obstacles = []
    for instance in instances:
        if instance.pickupable or instance.object_type in ("Floor", "Wall", "Ceiling"):
            continue
        for rect, low, high in _pieces(instance):
            if low < AGENT_HEIGHT_M and high > STEP_OVER_M:
                obstacles.append(rect)
    return reachable_cells(room, obstacles, list(contents))


def _pieces(instance: Instance) -> list[tuple[Rect, float, float]]:
    """Return what blocks the way: counters and blocks piece by piece, other things whole."""
    pieces = instance.object_type in ("CounterTop", "Structure", "Sink")
    groups = [(part,) for part in instance.parts] if pieces else [instance.parts]
    found = []
    for group in groups:
        low, high = bounds(group)
        rect = Rect(float(low[0]), float(high[0]), float(low[2]), float(high[2]))
        found.append((rect, float(low[1]), float(high[1])))
    return found


def _furnished(item: LayoutObject, layout: RoomLayout, fitting: Fitting) -> Instance:
    color = color_of(item.object_type, item.object_id, layout.name)
    material = material_of(item.object_type, item.materials)
    rgb = PALETTE[color] if color else (0.6, 0.6, 0.58)
    yaw_deg = 0.0
    if item.object_type in FLAT:
        parts = flat_parts(item, rgb, fitting.room)
    else:
        yaw_deg, size = local_size(item)
        shape = object_parts(
            item.object_type, size, item.asset_id or item.object_id, color, material
        )
        middle = [(a + b) / 2 for a, b in zip(item.low_m, item.high_m, strict=True)]
        parts = place(shape, yaw_deg, (middle[0], item.low_m[1], middle[2]))
    return Instance(
        object_id=item.object_id,
        object_type=item.object_type,
        parts=parts,
        color=color,
        material=material,
        yaw_deg=yaw_deg,
        pickupable=item.pickupable,
        receptacles=item.receptacles,
    )


def local_size(item: LayoutObject) -> tuple[float, Vector]:
    """Return (yaw, size in the object's own axes) that reproduce the layout's box.

    The asset's size is used, tipped over where the object lies on a side; where it does
    not explain the recorded box, the box itself at the nearest right angle is.
    """
    box = np.asarray(item.size_m())
    yaw = item.rotation_deg[1]
    if item.asset_size_m is not None:
        about_x, about_z = (np.radians(item.rotation_deg[k]) for k in (0, 2))
        tip_x = np.array(
            [
                [1, 0, 0],
                [0, np.cos(about_x), -np.sin(about_x)],
                [0, np.sin(about_x), np.cos(about_x)],
            ]
        )
        tip_z = np.array(
            [
                [np.cos(about_z), -np.sin(about_z), 0],
                [np.sin(about_z), np.cos(about_z), 0],
                [0, 0, 1],
            ]
        )
        size = np.abs(np.rint(tip_x @ tip_z)) @ np.asarray(item.asset_size_m)
        extent = np.abs(yaw_matrix(yaw)) @ size
        if (size > 0).all() and np.abs(extent - box).max() <= 0.25 * box.max():
            return yaw, (float(size[0]), float(size[1]), float(size[2]))
    quarter = round(yaw / 90) % 4
    x, y, z = (float(value) for value in box)
    return quarter * 90.0, (z, y, x) if quarter % 2 else (x, y, z)


def object_parts(
    object_type: str, size_m: Vector, key: str, color: str | None, material: str | None
) -> tuple[Part, ...]:
    """Return an object of a class, standing on the origin, front to +z, in a named colour."""
    size_m = (max(size_m[0], 0.004), max(size_m[1], 0.004), max(size_m[2], 0.004))
    if object_type in BLOBS:
        rgb, squareness, dent = BLOBS[object_type]
        tinted = ("Pillow", "Ottoman", "DogBed", "SprayBottle", "DishSponge", "Apple")
        natural = object_type not in tinted or (object_type == "Apple" and color == "red")
        tint = rgb if natural or color is None else PALETTE[color]
        return (blob_part(size_m, tint, squareness=squareness, dent=dent),)
    mesh = mesh_library().choose(object_type, stable_number(key), material)
    if mesh is None:
        x, y, z = size_m
        tint = PALETTE[color] if color else (0.6, 0.58, 0.55)
        return (box_part((-x / 2, 0, -z / 2), (x / 2, y, z / 2), tint),)
    parts = mesh.scaled(size_m)
    kept = color is None or object_type in ("Bread", "HousePlant", "TeddyBear", "BasketBall")
    return parts if kept or color is None else recoloured(parts, color)


def _settle(instances: list[Instance]) -> list[Instance]:
    """Put pickupable things down on the surfaces as rendered; the meshes are not Unity's.

    One after the other from below, each on what is fixed and what has been put down.
    """
    resting = [item for item in instances if not item.pickupable]
    order = sorted(
        (k for k, item in enumerate(instances) if item.pickupable),
        key=lambda k: (float(instances[k].corners[0][1]), k),
    )
    settled = list(instances)
    for k in order:
        settled[k] = _put_down(instances[k], resting)
        resting.append(settled[k])
    return settled


def _put_down(item: Instance, resting: list[Instance]) -> Instance:
    """Return the thing let go a little above its place; from higher where that is blocked."""
    body = Body(item.parts)
    around = Around(resting, body.low, body.high)
    for raised_m in SETTLE_FROM_M:
        rise_m = raised_m - around.drop_m(body, raised_m) + RESTING_M
        clear = -SETTLE_DOWN_M < rise_m <= raised_m + RESTING_M
        if clear and not around.crosses(body, np.array([0.0, rise_m, 0.0])):
            return item.raised(rise_m)
    return item
