"""Four identical chairs round a table, as people leave them: the hardest thing to count.

The table is the room's own dining table where all its sides are free, else one put where the
floor is. The chairs stand at its four sides, face it and are pushed under it as far as the
seed says and their backs and seats allow; none touches table or chair. The room's other
chairs are taken out, so that there are four.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from doro_schemas.errors import Refused
from doro_sim_feeder.rooms.appearance import PALETTE
from doro_sim_feeder.rooms.copies import copy_material
from doro_sim_feeder.rooms.instances import Instance
from doro_sim_feeder.rooms.layout import load_layout, sizes_of_type
from doro_sim_feeder.rooms.parts import Part, bounds, stable_number
from doro_sim_feeder.rooms.places import seen_from
from doro_sim_feeder.rooms.resting import at_rest
from doro_sim_feeder.rooms.scene import Scene, Vector, local_size, object_parts

TABLE, CHAIR = "DiningTable", "Chair"
TABLE_SIDES_M = (0.65, 1.9)
TABLE_HEIGHTS_M = (0.6, 0.95)
NEW_TABLE_M = ((1.2, 0.75, 0.8), (0.9, 0.75, 0.9), (1.4, 0.75, 0.9), (1.0, 0.74, 0.75))
PLACES = 120
PUSHED = (0.1, 0.6)
"""Share of a chair's depth that is under the table."""
PULLED_M, STEP_M, ASIDE = 0.2, 0.03, 0.12
SHARE_OF_CELLS, LEAST_CELLS, SEEN_FROM = 0.5, 30, 4
NORMALS = ((0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0))
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class _Chairs:
    """What the four chairs look like: triangles round the origin, front to +z."""

    shape: tuple[Part, ...]
    color: str
    material: str | None


@dataclass(frozen=True)
class _Side:
    """Where a chair is to stand: outward normal, shares aside of the middle and under the table."""

    number: int
    normal: Floats
    aside: float
    pushed: float


def chairs_round_table(scene: Scene, seed: int) -> Scene:
    """Return the room with a table and four identical chairs round it, and no other chair.

    Raises:
        Refused: the room has no place for them from which they can be walked round and seen.
    """
    rng = np.random.default_rng([seed, stable_number(f"{scene.name}|chairs")])
    bare = _without_chairs(scene)
    look = _look(scene.name, rng)
    for base, table in _tables(bare, rng):
        chairs = _round(base, table, look, rng)
        if chairs is None:
            continue
        full = base.with_instances(chairs)
        if _can_be_seen(full, chairs, len(bare.cells)):
            return full
    raise Refused(
        f"{scene.name} has no place for a table with four chairs round it: take another room"
    )


def _without_chairs(scene: Scene) -> Scene:
    gone = {item.object_id for item in scene.instances if item.object_type == CHAIR}
    kept = tuple(
        item
        for item in scene.instances
        if item.object_id not in gone and not gone & set(item.receptacles)
    )
    return replace(scene, instances=kept).with_instances([])


def _look(room: str, rng: np.random.Generator) -> _Chairs:
    own = load_layout(room).of_type(CHAIR)
    sizes = sorted(sizes_of_type(CHAIR), key=lambda size: size[0] * size[2])
    size = local_size(own[0])[1] if own else sizes[len(sizes) // 2]
    color = str(rng.choice(list(PALETTE)))
    material = copy_material(CHAIR, color)
    shape = object_parts(CHAIR, size, f"{room}|{CHAIR}|{color}", color, material)
    return _Chairs(shape, color, material)


def _tables(scene: Scene, rng: np.random.Generator) -> Iterator[tuple[Scene, Instance]]:
    """Yield rooms with a table to try: the room's own, then one at places on the floor."""
    for item in scene.instances:
        if item.object_type == TABLE and _is_usual(item):
            yield scene, item
    if not len(scene.cells):
        return
    for number in range(PLACES):
        size_m = NEW_TABLE_M[number % len(NEW_TABLE_M)]
        x, z = scene.cells[int(rng.integers(len(scene.cells)))]
        yaw_deg = 90.0 * int(rng.integers(2))
        table = _table(scene, size_m, (float(x), 0.0, float(z)), yaw_deg)
        if table is not None:
            yield scene.with_instances([table]), table


def _is_usual(table: Instance) -> bool:
    across, along, up = table.box().size_m
    low, high = TABLE_SIDES_M
    return (
        low <= min(across, along)
        and max(across, along) <= high
        and (TABLE_HEIGHTS_M[0] <= up <= TABLE_HEIGHTS_M[1])
    )


def _table(scene: Scene, size_m: Vector, at_m: Vector, yaw_deg: float) -> Instance | None:
    shape = object_parts(TABLE, size_m, f"{scene.name}|{TABLE}", "brown", "wood")
    parts = at_rest(shape, yaw_deg, np.asarray(at_m), scene.instances)
    if parts is None or abs(float(bounds(parts)[0][1])) > STEP_M:
        return None
    return Instance(
        object_id=f"{TABLE}|{at_m[0]:+06.2f}|{at_m[1]:+06.2f}|{at_m[2]:+06.2f}|new",
        object_type=TABLE,
        parts=parts,
        color="brown",
        material="wood",
        yaw_deg=yaw_deg,
        receptacles=("Floor",),
        copy=True,
    )


def _round(
    scene: Scene, table: Instance, look: _Chairs, rng: np.random.Generator
) -> list[Instance] | None:
    """Return four chairs at the table's sides, None where one of them has no room."""
    made: list[Instance] = []
    for number, normal in enumerate(NORMALS):
        aside, pushed = float(rng.uniform(-ASIDE, ASIDE)), float(rng.uniform(*PUSHED))
        side = _Side(number, np.asarray(normal), aside, pushed)
        chair = _at_side([*scene.instances, *made], table, look, side)
        if chair is None:
            return None
        made.append(chair)
    return made


def _at_side(
    others: list[Instance], table: Instance, look: _Chairs, side: _Side
) -> Instance | None:
    """Return a chair that faces the table, drawn back as far as it takes to be free."""
    center, size = table.box().center_m, table.box().size_m
    normal = side.normal
    along = np.array([normal[1], -normal[0]])
    half = float(np.abs(normal) @ np.asarray(size[:2])) / 2
    width = float(np.abs(along) @ np.asarray(size[:2]))
    low, high = bounds(look.shape)
    depth = float(high[2] - low[2])
    yaw_deg = float(np.degrees(np.arctan2(-normal[0], -normal[1]))) % 360
    for back_m in np.arange(-side.pushed * depth, PULLED_M, STEP_M):
        ground = np.asarray(center[:2]) + normal * (half + back_m + depth / 2)
        ground = ground + along * side.aside * width
        position = np.array([ground[0], 0.0, ground[1]])
        parts = at_rest(look.shape, yaw_deg, position, others)
        if parts is not None and abs(float(bounds(parts)[0][1])) < STEP_M:
            return _chair(look, parts, position, yaw_deg, side.number)
    return None


def _chair(
    look: _Chairs, parts: tuple[Part, ...], at_m: Floats, yaw_deg: float, number: int
) -> Instance:
    return Instance(
        object_id=f"{CHAIR}|{at_m[0]:+06.2f}|{at_m[1]:+06.2f}|{at_m[2]:+06.2f}|side{number}",
        object_type=CHAIR,
        parts=parts,
        color=look.color,
        material=look.material,
        yaw_deg=yaw_deg,
        receptacles=("Floor",),
        copy=True,
    )


def _can_be_seen(scene: Scene, chairs: list[Instance], cells: int) -> bool:
    if len(scene.cells) < max(LEAST_CELLS, SHARE_OF_CELLS * cells):
        return False
    caster = scene.caster()
    for chair in chairs:
        low, high = chair.corners
        top = np.array([(low[0] + high[0]) / 2, high[1] - 0.05, (low[2] + high[2]) / 2])
        if seen_from(scene, caster, top.astype(np.float64)) < SEEN_FROM:
            return False
    return True
