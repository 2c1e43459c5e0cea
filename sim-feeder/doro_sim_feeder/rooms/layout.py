"""iTHOR's furnished rooms as typed structs, read from the package ``procthor``.

``procthor==0.0.1.dev2`` ships the objects of all 120 iTHOR rooms as recorded in Unity
(type, position, rotation, box, receptacle, materials) and the sizes of all assets. The
package is only a place where files lie: it is found, never imported.
"""

from __future__ import annotations

import functools
import importlib.util
import re
from pathlib import Path
from typing import Any

import msgspec

from doro_schemas.errors import Refused

LEVEL_M = 0.01
FIRST_ROOM = {"kitchens": 1, "living_rooms": 201, "bedrooms": 301, "bathrooms": 401}
ROOMS_PER_KIND = 30
APARTMENTS = 75
Vector = tuple[float, float, float]


class _Box(msgspec.Struct):
    center: dict[str, float]
    size: dict[str, float]


class _Object(msgspec.Struct, rename="camel"):
    """The fields of AI2-THOR's object metadata that a room is built from."""

    object_id: str
    object_type: str
    asset_id: str
    axis_aligned_bounding_box: _Box
    rotation: dict[str, float]
    parent_receptacles: list[str] | None
    salient_materials: list[str] | None
    pickupable: bool
    moveable: bool


class _Asset(msgspec.Struct, rename="camel"):
    asset_id: str
    bounding_box: dict[str, float]


class LayoutObject(msgspec.Struct, frozen=True):
    """One object where iTHOR has it.

    Attributes:
        low_m, high_m: corners of the axis-aligned box, world x, y, z, metres.
        rotation_deg: Unity Euler angles about x, y, z; y is the yaw, clockwise from above.
        asset_size_m: size of the asset in its own axes; None where it is no asset.
        receptacles: ids of what it stands on or in.
        materials: AI2-THOR's salient materials, lower case.
    """

    object_id: str
    object_type: str
    asset_id: str
    low_m: Vector
    high_m: Vector
    rotation_deg: Vector
    asset_size_m: Vector | None
    receptacles: tuple[str, ...]
    materials: tuple[str, ...]
    pickupable: bool
    moveable: bool

    def size_m(self) -> Vector:
        x, y, z = (high - low for low, high in zip(self.low_m, self.high_m, strict=True))
        return (x, y, z)


class RoomLayout(msgspec.Struct, frozen=True):
    """A room: its name, its kind (``kitchens``, ...) and its objects, the floor among them."""

    name: str
    kind: str
    objects: tuple[LayoutObject, ...]

    def of_type(self, *object_types: str) -> tuple[LayoutObject, ...]:
        return tuple(item for item in self.objects if item.object_type in object_types)


def _database(name: str) -> Path:
    spec = importlib.util.find_spec("procthor")
    if spec is None or not spec.submodule_search_locations:
        raise Refused(
            "room layouts come from the package procthor==0.0.1.dev2, which is not installed:"
            " pip install 'doro-sim-feeder[render]'"
        )
    path = Path(spec.submodule_search_locations[0]) / "databases" / name
    if not path.is_file():
        raise Refused(f"the installed procthor has no databases/{name}: install 0.0.1.dev2")
    return path


@functools.cache
def _assets() -> dict[str, list[_Asset]]:
    raw = _database("asset-database.json").read_bytes()
    assets: dict[str, list[_Asset]] = msgspec.json.decode(raw, type=dict[str, list[_Asset]])
    return assets


@functools.cache
def _asset_sizes() -> dict[str, Vector]:
    return {
        item.asset_id: _xyz(item.bounding_box) for group in _assets().values() for item in group
    }


def sizes_of_type(object_type: str) -> list[Vector]:
    """Return the sizes (x, y, z in the asset's own axes, metres) of all assets of a class."""
    return [_xyz(item.bounding_box) for item in _assets().get(object_type, [])]


@functools.cache
def _all_rooms() -> dict[str, list[msgspec.Raw]]:
    raw = _database("ai2thor-object-metadata.json").read_bytes()
    rooms: dict[str, list[msgspec.Raw]] = msgspec.json.decode(
        raw, type=dict[str, list[msgspec.Raw]]
    )
    return rooms


def room_names(kind: str) -> list[str]:
    """Return the 30 room names of a kind: kitchens, living_rooms, bedrooms or bathrooms."""
    first = FIRST_ROOM[kind]
    return [f"FloorPlan{first + index}" for index in range(ROOMS_PER_KIND)]


def apartment_names() -> list[str]:
    """Return the names of RoboTHOR's 75 apartments."""
    return [f"RoboTHOR{number}" for number in range(1, APARTMENTS + 1)]


def load_layout(name: str) -> RoomLayout:
    """Return the layout of an iTHOR room or a RoboTHOR apartment, its floor at y = 0.

    Some of iTHOR's floors lie higher (22 cm in FloorPlan3, 10 cm in FloorPlan221); what stands
    in those rooms comes down with them.

    Args:
        name: ``FloorPlan1``-``30`` kitchens, ``201``-``230`` living rooms, ``301``-``330``
            bedrooms, ``401``-``430`` bathrooms; ``RoboTHOR1``-``75`` apartments, without
            floor and inner walls, which nobody recorded.

    Raises:
        Refused: no such room, or procthor's files are missing.
    """
    if name in apartment_names():
        index = int(name.removeprefix("RoboTHOR")) - 1
        return RoomLayout(name, "apartments", tuple(_read("robothor", index)))
    match = re.fullmatch(r"FloorPlan(\d+)", name)
    number = int(match.group(1)) if match else -1
    for kind, first in FIRST_ROOM.items():
        index = number - first
        if 0 <= index < ROOMS_PER_KIND:
            return RoomLayout(name, kind, _on_the_floor(_read(kind, index)))
    raise Refused(
        f"there is no room '{name}': use FloorPlan1-30 (kitchens), 201-230 (living rooms),"
        " 301-330 (bedrooms), 401-430 (bathrooms) or RoboTHOR1-75 (apartments)"
    )


def _read(kind: str, index: int) -> list[LayoutObject]:
    objects = msgspec.json.decode(_all_rooms()[kind][index], type=list[_Object])
    return [_typed(item) for item in objects]


def _on_the_floor(objects: list[LayoutObject]) -> tuple[LayoutObject, ...]:
    """Return the objects with the floor's surface at y = 0, where it was elsewhere."""
    level_m = max((item.high_m[1] for item in objects if item.object_type == "Floor"), default=0)
    if abs(level_m) < LEVEL_M:
        return tuple(objects)

    def moved(at: Vector) -> Vector:
        return (at[0], at[1] - level_m, at[2])

    return tuple(
        msgspec.structs.replace(item, low_m=moved(item.low_m), high_m=moved(item.high_m))
        for item in objects
    )


def _xyz(values: dict[str, Any]) -> Vector:
    return (float(values["x"]), float(values["y"]), float(values["z"]))


def _typed(item: _Object) -> LayoutObject:
    center = _xyz(item.axis_aligned_bounding_box.center)
    size = _xyz(item.axis_aligned_bounding_box.size)
    low = tuple(c - s / 2 for c, s in zip(center, size, strict=True))
    high = tuple(c + s / 2 for c, s in zip(center, size, strict=True))
    return LayoutObject(
        object_id=item.object_id,
        object_type=item.object_type,
        asset_id=item.asset_id,
        low_m=(low[0], low[1], low[2]),
        high_m=(high[0], high[1], high[2]),
        rotation_deg=_xyz(item.rotation),
        asset_size_m=_asset_sizes().get(item.asset_id),
        receptacles=tuple(item.parent_receptacles or ()),
        materials=tuple(value.lower() for value in item.salient_materials or ()),
        pickupable=item.pickupable,
        moveable=item.moveable,
    )
