"""Things scattered over a room for training: quicker and looser than the copies of the evaluation.

A thing is put down where nine rays from above meet a level surface and its box is free; it may
stand out of an edge by a little. The evaluation's copies come to rest exactly, which takes
a hundred times as long.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from doro_evaluation.dressing.dress import look_of
from doro_evaluation.dressing.meshes.libraries import MoreMeshes
from doro_sim_feeder.rooms.instances import Instance
from doro_sim_feeder.rooms.layout import sizes_of_type
from doro_sim_feeder.rooms.parts import place
from doro_sim_feeder.rooms.scene import Scene, object_parts

SMALL = (
    "Cup", "Mug", "Bowl", "Plate", "Bottle", "Apple", "Vase", "Book", "CellPhone",
    "RemoteControl", "Statue", "Laptop", "Pillow", "Box", "DeskLamp", "HousePlant",
    "Kettle", "Pan", "Pot", "WineBottle", "Bread", "Toaster", "AlarmClock", "Watch",
    "TeddyBear", "SoapBottle", "SprayBottle", "TissueBox", "Newspaper", "Tomato",
    "CoffeeMachine", "Candle", "KeyChain", "SaltShaker", "BasketBall", "Microwave",
    "Television", "Towel", "Desktop", "TableTopDecor",
)  # fmt: skip
LARGE = (
    "Chair", "Stool", "SideTable", "ArmChair", "Sofa", "FloorLamp", "GarbageCan", "Box",
    "HousePlant", "CoffeeTable", "Safe", "LaundryHamper", "Ottoman", "DogBed", "Boots", "Desk",
    "Dresser", "DiningTable", "ShelvingUnit", "TVStand", "Bed", "Television", "TeddyBear",
    "Wardrobe",
)  # fmt: skip
MORE_OFTEN = frozenset({"DogBed", "Safe", "Dresser", "CellPhone", "RemoteControl", "Watch"})
MESHES_ONLY = frozenset({"TableTopDecor", "Wardrobe", "Boots", "Desktop"})
MESH_SIZE_SHARE, CLOSED_SHARE, STANDING_SHARE, SOFT_SHARE = 0.5, 0.25, 0.25, 0.7
SOFT = frozenset({"Bed", "Sofa", "ArmChair"})
HELD = (
    "AlarmClock", "DeskLamp", "Book", "Laptop", "Pillow", "RemoteControl", "CellPhone", "Vase",
    "Statue", "TeddyBear", "Box", "Bowl", "Mug", "Cup", "Plate", "Bottle", "Apple", "TissueBox",
    "Newspaper", "Watch", "HousePlant",
)  # fmt: skip
HELD_EYES_M, HELD_ODDS, HELD_FIRST = (0.95, 1.5), 3.0, 5
SUPPORTS = frozenset(
    """CounterTop DiningTable CoffeeTable SideTable Desk Dresser TVStand Shelf ShelvingUnit Bed
    Sofa ArmChair Stool Chair Ottoman Toilet Bathtub Safe""".split()  # noqa: SIM905
)
EVALUATED_ODDS = 3.0
CANDIDATES = 700
LEVEL_M, SOFT_LEVEL_M, RISE_M, REACH = 0.014, 0.12, 0.004, (-0.4, 0.0, 0.4)
HIGHEST_M, FROM_ABOVE_M = 1.75, 0.35
GRID = np.array([(a, b) for a in REACH for b in REACH])


# Class, size, whether on the floor, nine points (x, z), the height above them.
Wish = tuple[str, tuple[float, float, float], bool, NDArray[np.float64], float]


def scattered(
    scene: Scene,
    rng: np.random.Generator,
    small: int,
    large: int,
    meshes: MoreMeshes | None = None,
) -> Scene:
    """Return the room with up to so many more things on furniture and on the floor."""
    supports = [
        item
        for item in scene.instances
        if item.object_type in SUPPORTS and item.corners[1][1] < HIGHEST_M
    ]
    wishes = [_wish(scene, supports, rng, meshes, on_floor=k % 5 == 0) for k in range(CANDIDATES)]
    lows = np.array([item.corners[0] for item in scene.instances])
    highs = np.array([item.corners[1] for item in scene.instances])
    solid = np.array([item.object_type not in ("Floor", "Ceiling") for item in scene.instances])
    made: list[Instance] = []
    left = {True: large, False: small}
    for (kind, size, on_floor, at, top), fall in zip(wishes, _falls(scene, wishes), strict=True):
        level = SOFT_LEVEL_M if kind == "Pillow" else LEVEL_M
        surface = top - float(np.median(fall))
        if left[on_floor] <= 0 or not np.isfinite(fall).all() or np.ptp(fall) > level:
            continue
        if (surface > 0.02) if on_floor else not 0.12 < surface < HIGHEST_M:
            continue
        item = _made(kind, size, (float(at[4, 0]), surface + RISE_M, float(at[4, 1])), rng)
        low, high = item.corners
        hits_box = (low[None] + 0.008 < highs) & (high[None] - 0.008 > lows)
        inside = scene.room.x_low < low[0] and high[0] < scene.room.x_high
        inside = inside and scene.room.z_low < low[2] and high[2] < scene.room.z_high
        below = lows[:, 1] < surface - 0.02 if not on_floor else np.zeros(len(lows), np.bool_)
        # It may reach into the box of what stands below it: a chair's back, a bed's rail.
        if not inside or (hits_box.all(axis=1) & solid & ~below).any():
            continue
        made.append(item)
        lows, highs = np.vstack([lows, low]), np.vstack([highs, high])
        solid = np.append(solid, True)
        left[on_floor] -= 1
    return scene.with_instances(made)


def held(
    scene: Scene, rng: np.random.Generator, count: int, meshes: MoreMeshes | None = None
) -> Scene:
    """Return the room with some things in the air, as before a robot that carries them."""
    odds = np.where(np.arange(len(HELD)) < HELD_FIRST, HELD_ODDS, 1.0)
    made = []
    for cell in rng.permutation(len(scene.cells))[:count].tolist():
        kind = str(rng.choice(list(HELD), p=odds / odds.sum()))
        x, z = scene.cells[cell].tolist()
        at = (x, float(rng.uniform(*HELD_EYES_M)), z)
        made.append(_made(kind, _size(kind, rng, meshes), at, rng))
    return replace(scene, instances=(*scene.instances, *made))


def _falls(scene: Scene, wishes: list[Wish]) -> NDArray[np.float64]:
    """Return how far it is from above to a surface at each wish's points, metres, (wishes, 9)."""
    origins = np.concatenate(
        [np.column_stack([at[:, 0], np.full(9, top), at[:, 1]]) for *_, at, top in wishes]
    )
    hits = scene.caster().cast(origins, np.broadcast_to([0.0, -1.0, 0.0], origins.shape))
    return hits.distance.reshape(-1, 9).astype(np.float64)


def _wish(
    scene: Scene,
    supports: list[Instance],
    rng: np.random.Generator,
    meshes: MoreMeshes | None,
    *,
    on_floor: bool,
) -> Wish:
    """Return class, size, whether on the floor, nine points (x, z) and the height above them."""
    names = LARGE if on_floor or not supports else SMALL
    odds = np.ones(len(names))
    odds[: 16 if names is SMALL else 5] = EVALUATED_ODDS
    odds[-1] = EVALUATED_ODDS
    odds[[name in MORE_OFTEN for name in names]] = EVALUATED_ODDS
    if meshes is None:
        odds[[name in MESHES_ONLY for name in names]] = 0
    kind = str(rng.choice(list(names), p=odds / odds.sum()))
    size_m = _size(kind, rng, meshes)
    if kind == "Pillow" and rng.random() < SOFT_SHARE:
        supports = [item for item in supports if item.object_type in SOFT] or supports
    room = scene.room
    if names is LARGE:
        x = float(rng.uniform(room.x_low + 0.2, room.x_high - 0.2))
        z = float(rng.uniform(room.z_low + 0.2, room.z_high - 0.2))
        top = 2.4
    else:
        areas = [np.sqrt(max(np.prod(np.ptp(s.corners, axis=0)[[0, 2]]), 0.01)) for s in supports]
        weight = np.asarray(areas) / np.sum(areas)
        low, high = supports[int(rng.choice(len(supports), p=weight))].corners
        x, z = float(rng.uniform(low[0], high[0])), float(rng.uniform(low[2], high[2]))
        top = float(high[1]) + FROM_ABOVE_M
    points = np.array([x, z]) + GRID * max(size_m[0], size_m[2])
    return kind, size_m, names is LARGE, points, top


def _size(
    kind: str, rng: np.random.Generator, meshes: MoreMeshes | None
) -> tuple[float, float, float]:
    """Return a size of a class: of one of AI2-THOR's, or as long but of a mesh's shape."""
    sizes = [] if kind in MESHES_ONLY else sizes_of_type(kind)
    base = np.asarray(sizes[int(rng.integers(len(sizes)))] if sizes else (0.2, 0.2, 0.2))
    if meshes is not None and (not sizes or rng.random() < MESH_SIZE_SHARE):
        longest = float(base.max()) if sizes else None
        base = np.asarray(meshes.any_size(kind, longest, rng) or base)
    if kind == "Laptop" and rng.random() < CLOSED_SHARE:
        base = base * np.array([1.0, 0.1, 1.0])
    if kind == "Book" and rng.random() < STANDING_SHARE:
        base = np.array([max(base[0], base[2]) * 0.75, max(base[0], base[2]), base.min()])
    size = np.maximum(base * rng.uniform(0.85, 1.15, 3) * rng.uniform(0.9, 1.1), 0.006)
    return float(size[0]), float(size[1]), float(size[2])


def _made(
    kind: str,
    size_m: tuple[float, float, float],
    position_m: tuple[float, float, float],
    rng: np.random.Generator,
) -> Instance:
    color, material = look_of(kind, rng)
    parts = object_parts(kind, size_m, str(rng.integers(1 << 30)), color, material)
    yaw_deg = float(rng.uniform(0, 360))
    x, y, z = position_m
    return Instance(
        object_id=f"{kind}|{x:+06.2f}|{y:+06.2f}|{z:+06.2f}|scattered",
        object_type=kind,
        parts=place(parts, yaw_deg, position_m),
        color=color,
        material=material,
        yaw_deg=yaw_deg,
        pickupable=kind in SMALL,
        copy=True,
    )
