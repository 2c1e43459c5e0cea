"""Spawned copies of one class, on surfaces where the robot can see them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from doro_schemas.errors import Refused
from doro_sim_feeder.rooms.appearance import COPY_MATERIALS, PALETTE, usual_material
from doro_sim_feeder.rooms.instances import BACKGROUND, Instance
from doro_sim_feeder.rooms.layout import load_layout, sizes_of_type
from doro_sim_feeder.rooms.parts import Part, bounds, place, stable_number
from doro_sim_feeder.rooms.raycast import RayCaster
from doro_sim_feeder.rooms.scene import Scene, Vector, local_size, object_parts

CAMERA_HEIGHT_M = 1.576
TWIN_SHARE = 0.3
CANDIDATES = 2500
FLAT_M = 0.012
SOFT_M = 0.07  # what soft things may lean on: cushions are no planes
SOFT = frozenset({"Pillow", "TeddyBear", "Cloth"})
CLEARANCE_M = 0.03
SEEN_WITHIN_M = 2.6
SPREADS_M = (1.2, 0.8, 0.5, 0.3)  # tried in turn: copies stand apart where the room allows
LAST_TRIES = 4
SURFACES = frozenset(
    """CounterTop DiningTable CoffeeTable SideTable Desk Dresser TVStand Shelf ShelvingUnit
    Sofa Bed ArmChair""".split()  # noqa: SIM905
)
ON_FLOOR = frozenset(
    """Chair Stool ArmChair Sofa FloorLamp SideTable CoffeeTable DiningTable Desk HousePlant Box
    GarbageCan TVStand Dresser LaundryHamper""".split()  # noqa: SIM905
)


class CopySpec(msgspec.Struct, frozen=True):
    """Which copies to spawn.

    Attributes:
        object_type: AI2-THOR's class name ("Cup").
        count: how many, besides those that the room has.
        colors: named colours in turn; empty: drawn by the seed, now and then twins.
    """

    object_type: str
    count: int
    colors: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not 1 <= self.count <= 20:
            raise Refused(f"{self.count} copies were asked for: 1 to 20 can be placed")
        unknown = [color for color in self.colors if color not in PALETTE]
        if unknown:
            raise Refused(f"unknown colour '{unknown[0]}': use one of {', '.join(PALETTE)}")


@dataclass(frozen=True)
class _Copy:
    """A copy to be placed: its class, colour and triangles around the origin."""

    object_type: str
    color: str
    shape: tuple[Part, ...]

    @property
    def on_floor(self) -> bool:
        return self.object_type in ON_FLOOR


@dataclass(frozen=True)
class _Place:
    """A place found: where the copy's origin goes and the receptacle's id."""

    position_m: Vector
    yaw_deg: float
    receptacle: str


@dataclass(frozen=True)
class _Candidates:
    """Places to try: ground positions, yaw, and where rays fall from."""

    x: NDArray[np.float64]
    z: NDArray[np.float64]
    yaw_deg: NDArray[np.float64]
    support: NDArray[np.int64]
    from_m: NDArray[np.float64]


def spawn_copies(scene: Scene, spec: CopySpec, seed: int) -> Scene:
    """Return the scene with copies at random places that are seen from several cells.

    Raises:
        Refused: the class is unknown or the room has no room for the copies.
    """
    rng = np.random.default_rng([seed, stable_number(f"{scene.name}|{spec.object_type}")])
    caster = scene.caster()
    size = _size_of(scene, spec.object_type)
    made: list[Instance] = []
    for color in _colors(spec, rng):
        copy = _Copy(spec.object_type, color, _shape(scene, spec, size, color))
        found = None
        for spread_m in SPREADS_M:
            candidates = _draw(scene, copy.on_floor, rng)
            if found is None and candidates is not None:
                found = _find_place(scene, caster, copy, _Search(candidates, made, spread_m))
        for _ in range(LAST_TRIES):  # a crowded room: close together, seen from a few cells
            candidates = _draw(scene, copy.on_floor, rng) if found is None else None
            if candidates is not None:
                found = _find_place(scene, caster, copy, _Search(candidates, made, 0.2, 3))
        if found is None:
            raise Refused(
                f"{scene.name} has no free, visible place for {spec.count} copies of"
                f" {spec.object_type}: ask for fewer or take another room or seed"
            )
        made.append(_instance(copy, len(made), found))
    return scene.with_instances(made)


def _colors(spec: CopySpec, rng: np.random.Generator) -> list[str]:
    if spec.colors:
        return [spec.colors[k % len(spec.colors)] for k in range(spec.count)]
    fresh = [str(name) for name in rng.permutation(list(PALETTE))]
    colors: list[str] = []
    for _ in range(spec.count):
        twin = bool(colors) and (rng.random() < TWIN_SHARE or not fresh)
        colors.append(str(rng.choice(colors)) if twin else fresh.pop())
    return colors


def copy_material(object_type: str, color: str) -> str | None:
    """Return the material of a spawned copy; twins of a colour share it."""
    choices = COPY_MATERIALS.get(object_type)
    if choices is None:
        return usual_material(object_type)
    return choices[stable_number(f"{object_type}|{color}") % len(choices)]


def _size_of(scene: Scene, object_type: str) -> Vector:
    own = load_layout(scene.name).of_type(object_type)
    if own:
        return local_size(own[0])[1]
    known = sorted(sizes_of_type(object_type), key=lambda size: size[0] * size[1] * size[2])
    if not known:
        raise Refused(f"AI2-THOR has no class '{object_type}': names are like Cup or DeskLamp")
    return known[len(known) // 2]


def _shape(scene: Scene, spec: CopySpec, size: Vector, color: str) -> tuple[Part, ...]:
    material = copy_material(spec.object_type, color)
    key = f"{scene.name}|{spec.object_type}|{color}"
    return object_parts(spec.object_type, size, key, color, material)


@dataclass(frozen=True)
class _Search:
    """Where to look, what is made and how far to stay from it, cells that must see the place."""

    candidates: _Candidates
    made: list[Instance]
    spread_m: float
    least_cells: int | None = None


def _find_place(scene: Scene, caster: RayCaster, copy: _Copy, search: _Search) -> _Place | None:
    """Return the first place that fits, on a receptacle without a copy where there is one."""
    candidates, made = search.candidates, search.made
    low, high = bounds(copy.shape)
    tops = _surface(caster, candidates, copy, high - low)
    least = search.least_cells
    if least is None:
        least = 0 if copy.on_floor else max(3, len(scene.cells) // 12)
    used = {receptacle for item in made for receptacle in item.receptacles}
    names = [scene.instances[k].object_id for k in candidates.support]
    taken = np.array([name in used for name in names])
    for k in np.argsort(taken, kind="stable"):
        top = float(tops[k])
        if not np.isfinite(top) or (top > 0.03 if copy.on_floor else top < 0.2):
            continue
        position = (float(candidates.x[k]), top + 0.001, float(candidates.z[k]))
        placed = place(copy.shape, float(candidates.yaw_deg[k]), position)
        if not (_apart(placed, made, search.spread_m) and _free(placed, scene, made)):
            continue
        middle = np.array(position)
        middle[1] += float(high[1]) / 2
        if copy.on_floor and not _passable(scene, placed):
            continue
        if _seen_from(scene, caster, middle) >= least:
            return _Place(position, float(candidates.yaw_deg[k]), names[k])
    return None


def _draw(scene: Scene, on_floor: bool, rng: np.random.Generator) -> _Candidates | None:
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
    return _Candidates(
        x=low[:, 0] + share[:, 0] * (high[:, 0] - low[:, 0]),
        z=low[:, 2] + share[:, 1] * (high[:, 2] - low[:, 2]),
        yaw_deg=turn,
        support=chosen,
        from_m=high[:, 1] + (2.4 if on_floor else 0.3),
    )


def _surface(
    caster: RayCaster, places: _Candidates, copy: _Copy, extent_m: NDArray[np.floating[Any]]
) -> NDArray[np.float64]:
    """Return the height of the surface below each place; NaN where it is not flat."""
    steps = np.linspace(-0.48, 0.48, 5)
    across, along = (grid.ravel() for grid in np.meshgrid(steps, steps))
    across, along = across * extent_m[0], along * extent_m[2]
    yaw = np.radians(places.yaw_deg)[:, None]
    x = places.x[:, None] + np.cos(yaw) * across + np.sin(yaw) * along
    z = places.z[:, None] - np.sin(yaw) * across + np.cos(yaw) * along
    y = np.broadcast_to(places.from_m[:, None], x.shape)
    origins = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    down = np.broadcast_to(np.array([0.0, -1.0, 0.0]), origins.shape)
    height = y - caster.cast(origins, down).distance.reshape(x.shape)
    height = np.where(np.isfinite(height), height, -1e3)
    soft = copy.object_type in SOFT
    flat = np.ptp(height, axis=1) <= (SOFT_M if soft else FLAT_M)
    top = np.median(height, axis=1) if soft else height.max(axis=1)
    return np.where(flat, top, np.nan)


def _apart(placed: tuple[Part, ...], made: list[Instance], spread_m: float) -> bool:
    low, high = bounds(placed)
    middle = (low + high)[[0, 2]] / 2
    others = [(item.corners[0] + item.corners[1])[[0, 2]] / 2 for item in made]
    return all(float(np.hypot(*(middle - other))) >= spread_m for other in others)


def _free(placed: tuple[Part, ...], scene: Scene, made: list[Instance]) -> bool:
    low, high = bounds(placed)
    for item in (*scene.instances, *made):
        if item.object_type in BACKGROUND:
            continue
        other_low, other_high = item.corners
        overlaps = (low - CLEARANCE_M < other_high) & (high + CLEARANCE_M > other_low)
        if overlaps.all() and other_high[1] > low[1] + FLAT_M and other_low[1] > low[1] - 0.02:
            return False
    return True


def _seen_from(scene: Scene, caster: RayCaster, middle_m: NDArray[np.float64]) -> int:
    """Return from how many cells a point is in view and near enough to make out."""
    cells = scene.cells
    eyes = np.column_stack([cells[:, 0], np.full(len(cells), CAMERA_HEIGHT_M), cells[:, 1]])
    rays = middle_m - eyes
    near = np.linalg.norm(rays, axis=1) < SEEN_WITHIN_M
    return int((near & ~caster.occluded(eyes, rays, reach=0.97)).sum())


def _passable(scene: Scene, placed: tuple[Part, ...]) -> bool:
    """Tell whether the agent still gets to most of the room around a thing on the floor."""
    blocked = Instance("", "Box", placed)
    return len(scene.with_instances([blocked]).cells) >= 0.7 * len(scene.cells)


def _instance(copy: _Copy, number: int, found: _Place) -> Instance:
    x, y, z = found.position_m
    return Instance(
        object_id=f"{copy.object_type}|{x:+06.2f}|{y:+06.2f}|{z:+06.2f}|copy{number}",
        object_type=copy.object_type,
        parts=place(copy.shape, found.yaw_deg, found.position_m),
        color=copy.color,
        material=copy_material(copy.object_type, copy.color),
        yaw_deg=found.yaw_deg,
        pickupable=not copy.on_floor,
        receptacles=(found.receptacle,),
        copy=True,
    )
