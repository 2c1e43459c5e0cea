"""Spawned copies of one class, on surfaces where the robot can see them."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from doro_schemas.errors import Refused
from doro_sim_feeder.rooms.contact import Around, Body
from doro_sim_feeder.rooms.copies import STACKED, CopySpec, Look, Unplaced, Wish, wishes
from doro_sim_feeder.rooms.instances import Instance
from doro_sim_feeder.rooms.layout import load_layout, sizes_of_type
from doro_sim_feeder.rooms.parts import Part, bounds, place, stable_number
from doro_sim_feeder.rooms.places import (
    CAMERA_HEIGHT_M,
    SOFT,
    Candidates,
    draw_places,
    room_for,
    seen_from,
    still_reached,
    surface_heights,
    turned_size_m,
)
from doro_sim_feeder.rooms.raycast import RayCaster
from doro_sim_feeder.rooms.scene import RESTING_M, Scene, Vector, local_size, object_parts

__all__ = ["CAMERA_HEIGHT_M", "CopySpec", "Spawned", "place_copies", "spawn_copies"]

SPREADS_M = (1.2, 0.8, 0.5, 0.3)  # tried in turn: copies stand apart where the room allows
LAST_TRIES = 4
RAISED_M = 0.04
FLOOR_M, LOWEST_SHELF_M = 0.03, 0.2
STACK_RISE_M = 0.35
STACK_TRIES = 12
STACK_SLIP_M = 0.012
MAX_STACK = 4
FEW_CELLS = 3
PASSABLE_SHARE = 0.7
ON_FLOOR = frozenset(
    """Chair Stool ArmChair Sofa FloorLamp SideTable CoffeeTable DiningTable Desk HousePlant Box
    GarbageCan GarbageBag TVStand Dresser LaundryHamper DogBed Ottoman""".split()  # noqa: SIM905
)


@dataclass(frozen=True)
class Spawned:
    """A scene with copies, and those that found no place."""

    scene: Scene
    missing: tuple[Unplaced, ...]


@dataclass(frozen=True)
class _Place:
    """A place found: where the copy's origin goes and the receptacle's id."""

    position_m: Vector
    yaw_deg: float
    receptacle: str


@dataclass(frozen=True)
class _Copy:
    """A copy to be placed: what is wanted, and its triangles around the origin."""

    wish: Wish
    shape: tuple[Part, ...]

    @property
    def on_floor(self) -> bool:
        return self.wish.object_type in ON_FLOOR


@dataclass
class _Spawner:
    """Places the copies of one class in a room, one after the other."""

    scene: Scene
    rng: np.random.Generator
    size_m: Vector
    caster: RayCaster
    cells: NDArray[np.float64]
    made: list[Instance] = field(default_factory=list)
    tally: Counter[str] = field(default_factory=Counter)

    def spawn(self, wish: Wish, number: int) -> Unplaced | None:
        """Place a copy; return why not where there is no place."""
        self.tally.clear()
        copy = _Copy(wish, self._shape(wish))
        found = self._found(copy)
        if found is None:
            return self._unplaced(wish, number)
        self.made.append(_instance(copy, number, found))
        return None

    def _shape(self, wish: Wish) -> tuple[Part, ...]:
        kind, look = wish.object_type, wish.look
        key = f"{self.scene.name}|{kind}|{look.color}"
        return object_parts(kind, self.size_m, key, look.color, look.material)

    def _found(self, copy: _Copy) -> _Place | None:
        stance = copy.wish.stance
        found = self._on_another(copy) if stance == "stacked" else None
        if found is None and stance == "close":
            beside = self.made[int(self.rng.integers(len(self.made)))] if self.made else None
            found = self._among(copy, beside, 0.0, FEW_CELLS)
        least = max(FEW_CELLS, len(self.scene.cells) // 12)
        for spread_m in SPREADS_M:
            if found is None:
                found = self._among(copy, None, spread_m, least)
        for _ in range(LAST_TRIES):  # a crowded room: close together, seen from a few cells
            if found is None:
                found = self._among(copy, None, 0.2, FEW_CELLS)
        return found

    def _among(
        self, copy: _Copy, beside: Instance | None, spread_m: float, least_cells: int
    ) -> _Place | None:
        """Return the first place that fits, on a receptacle without a copy where there is one."""
        candidates = draw_places(self.scene, copy.on_floor, self.rng, beside)
        if candidates is None:
            self.tally["there is no surface for it"] += 1
            return None
        low, high = bounds(copy.shape)
        soft = copy.wish.object_type in SOFT
        tops = surface_heights(self.caster, candidates, high - low, soft)
        fits = np.abs(tops) <= FLOOR_M if copy.on_floor else tops >= LOWEST_SHELF_M
        self.tally["no flat surface of its size"] += int((~fits).sum())
        for k in self._order(candidates, fits, beside):
            found = self._try(copy, candidates, int(k), float(tops[k]), spread_m)
            if found is None:
                continue
            middle = np.array(found.position_m)
            middle[1] += float(high[1]) / 2
            if copy.on_floor or seen_from(self.scene, self.caster, middle) >= least_cells:
                return found
            self.tally["not in view"] += 1
        return None

    def _order(
        self, candidates: Candidates, fits: NDArray[np.bool_], beside: Instance | None
    ) -> NDArray[np.int64]:
        used = {receptacle for item in self.made for receptacle in item.receptacles}
        names = [self.scene.instances[k].object_id for k in candidates.support]
        taken = np.array([beside is None and name in used for name in names])
        order = np.argsort(taken, kind="stable")
        kept: NDArray[np.int64] = order[fits[order]]
        return kept

    def _try(
        self, copy: _Copy, candidates: Candidates, k: int, top_m: float, spread_m: float
    ) -> _Place | None:
        yaw_deg = float(candidates.yaw_deg[k])
        center = np.array([candidates.x[k], top_m, candidates.z[k]])
        others = [np.mean(item.corners, axis=0) for item in self.made]
        apart = [float(np.hypot(*(center - other)[[0, 2]])) for other in others]
        if min(apart, default=np.inf) < spread_m:
            self.tally["too near to another copy"] += 1
            return None
        if not room_for(center, turned_size_m(copy.shape, yaw_deg), self.scene, self.made):
            self.tally["something else stands there"] += 1
            return None
        if copy.on_floor:
            left = still_reached(self.cells, turned_size_m(copy.shape, yaw_deg), center)
            if len(left) < PASSABLE_SHARE * len(self.scene.cells):
                self.tally["it would block the way"] += 1
                return None
        position = self._at_rest(place(copy.shape, yaw_deg, center), center)
        if position is None:
            return None
        if copy.on_floor:
            self.cells = left
        return _Place(position, yaw_deg, self.scene.instances[candidates.support[k]].object_id)

    def _at_rest(self, parts: tuple[Part, ...], position: NDArray[np.float64]) -> Vector | None:
        """Return where a thing that is let go just above its place comes to rest, exactly."""
        body = Body(parts)
        around = Around([*self.scene.instances, *self.made], body.low, body.high)
        drop_m = around.drop_m(body, RAISED_M)
        rise_m = RAISED_M - drop_m + RESTING_M
        if not -RAISED_M < rise_m < RAISED_M or around.crosses(body, np.array([0.0, rise_m, 0.0])):
            self.tally["it would cut into something"] += 1
            return None
        x, y, z = (float(value) for value in position)
        return (x, y + rise_m, z)

    def _on_another(self, copy: _Copy) -> _Place | None:
        """Return a place on top of a copy that carries nothing yet."""
        carrying = {name for item in self.made for name in item.receptacles}
        bases = [item for item in self.made if item.object_id not in carrying]
        if not bases or copy.wish.object_type not in STACKED:
            return None
        for _ in range(STACK_TRIES):
            base = bases[int(self.rng.integers(len(bases)))]
            low, high = base.corners
            slip = self.rng.uniform(-STACK_SLIP_M, STACK_SLIP_M, 2)
            x, z = (low[0] + high[0]) / 2 + slip[0], (low[2] + high[2]) / 2 + slip[1]
            yaw_deg = base.yaw_deg + float(self.rng.uniform(-10, 10))
            if self._height_of_stack(base) >= MAX_STACK:
                continue
            center = np.array([x, float(high[1]), z], np.float64)
            body = Body(place(copy.shape, yaw_deg, center))
            around = Around([*self.scene.instances, *self.made], body.low, body.high)
            rise_m = RAISED_M - around.drop_m(body, RAISED_M) + RESTING_M
            clear = -STACK_RISE_M < rise_m < RAISED_M
            if clear and not around.crosses(body, np.array([0.0, rise_m, 0.0])):
                position = (float(x), float(high[1]) + rise_m, float(z))
                if seen_from(self.scene, self.caster, np.array(position)) >= FEW_CELLS:
                    return _Place(position, yaw_deg, base.object_id)
        return None

    def _height_of_stack(self, top: Instance) -> int:
        by_id = {item.object_id: item for item in self.made}
        height, item = 1, by_id.get(top.receptacles[0]) if top.receptacles else None
        while item is not None:
            height, item = height + 1, by_id.get(item.receptacles[0])
        return height

    def _unplaced(self, wish: Wish, number: int) -> Unplaced:
        tried = ", ".join(f"{name} ({count})" for name, count in self.tally.most_common())
        return Unplaced(
            name=f"copy{number}",
            object_type=wish.object_type,
            attributes=_attributes(wish.look),
            reason=f"no free, visible place: {tried}",
        )


def place_copies(scene: Scene, spec: CopySpec, seed: int, size_m: Vector | None = None) -> Spawned:
    """Return the scene with copies where they found a place, and the others by name.

    Every copy rests on what is below it (:mod:`contact` measures it) and can be seen from
    several cells. One scene, specification and seed give the same result.

    Args:
        size_m: of the copies, in their own axes; None: of the room's first thing of the class.

    Raises:
        Refused: the class is unknown.
    """
    rng = np.random.default_rng([seed, stable_number(f"{scene.name}|{spec.object_type}")])
    size = size_m or _size_of(scene, spec.object_type)
    spawner = _Spawner(scene, rng, size, scene.caster(), scene.cells)
    missing = [spawner.spawn(wish, k) for k, wish in enumerate(wishes(spec, rng))]
    return Spawned(
        scene.with_instances(spawner.made), tuple(item for item in missing if item is not None)
    )


def spawn_copies(scene: Scene, spec: CopySpec, seed: int) -> Scene:
    """Return the scene with all the copies asked for.

    Raises:
        Refused: the class is unknown or the room has no room for all copies.
    """
    spawned = place_copies(scene, spec, seed)
    if spawned.missing:
        first = spawned.missing[0]
        raise Refused(
            f"{scene.name} has no room for {len(spawned.missing)} of {spec.count} copies of"
            f" {spec.object_type} ({first.name}: {first.reason}): ask for fewer, take another room"
            " or seed, or allow missing copies"
        )
    return spawned.scene


def _size_of(scene: Scene, object_type: str) -> Vector:
    own = load_layout(scene.name).of_type(object_type)
    if own:
        return local_size(own[0])[1]
    known = sorted(sizes_of_type(object_type), key=lambda size: size[0] * size[1] * size[2])
    if not known:
        raise Refused(f"AI2-THOR has no class '{object_type}': names are like Cup or DeskLamp")
    return known[len(known) // 2]


def _attributes(look: Look) -> dict[str, str]:
    pairs = (("color", look.color), ("material", look.material))
    return {name: value for name, value in pairs if value is not None}


def _instance(copy: _Copy, number: int, found: _Place) -> Instance:
    x, y, z = found.position_m
    wish = copy.wish
    return Instance(
        object_id=f"{wish.object_type}|{x:+06.2f}|{y:+06.2f}|{z:+06.2f}|copy{number}",
        object_type=wish.object_type,
        parts=place(copy.shape, found.yaw_deg, found.position_m),
        color=wish.look.color,
        material=wish.look.material,
        yaw_deg=found.yaw_deg,
        pickupable=not copy.on_floor,
        receptacles=(found.receptacle,),
        copy=True,
    )
