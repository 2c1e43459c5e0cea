"""Copies of things in the rooms of training frames that look as the evaluation's do."""

from __future__ import annotations

import numpy as np

from doro_sim_feeder.rooms.copies import CopySpec
from doro_sim_feeder.rooms.layout import sizes_of_type
from doro_sim_feeder.rooms.placement import place_copies
from doro_sim_feeder.rooms.scene import Scene

COPIED = (
    "Cup", "Mug", "Bowl", "Plate", "Bottle", "Apple", "Vase", "Book", "CellPhone",
    "RemoteControl", "Statue", "Laptop", "Pillow", "Box", "DeskLamp", "HousePlant", "Stool",
    "Chair", "SideTable", "ArmChair", "Sofa",
)  # fmt: skip
ALSO_COPIED = (
    "Kettle", "Pan", "Pot", "WineBottle", "Bread", "Toaster", "AlarmClock", "Watch",
    "TeddyBear", "SoapBottle", "SprayBottle", "TissueBox", "Newspaper", "FloorLamp",
    "GarbageCan", "CoffeeTable", "Safe", "CoffeeMachine", "BasketBall", "Tomato",
)  # fmt: skip
FLOOR = frozenset({"Stool", "Chair", "SideTable", "ArmChair", "Sofa", "FloorLamp", "GarbageCan"})
DECEIVING_FLOOR = (
    "DogBed",
    "GarbageBag",
    "Ottoman",
    "LaundryHamper",
    "Dresser",
    "TVStand",
    "CoffeeTable",
)
DECEIVING = ("Newspaper", "DishSponge", "TissueBox", "AlarmClock", "Safe", "Watch")
"""What the networks took for pillows, side tables, remote controls and books."""
ANY_SIZE_SHARE = 0.6


def with_copies(scene: Scene, rng: np.random.Generator, kinds: int) -> Scene:
    """Return the room with two to four copies each of several classes, where they fit."""
    small = [name for name in COPIED if name not in FLOOR]
    also = [name for name in ALSO_COPIED if name not in FLOOR]
    count = max(kinds - 2, 1)
    chosen = [str(name) for name in rng.permutation(small)[: count * 2 // 3 + 1]]
    chosen += [str(name) for name in rng.permutation(also)[: count // 3]]
    chosen += [str(name) for name in rng.permutation(sorted(FLOOR))[:2]]
    for name in chosen:
        number = int(rng.integers(1, 3)) if name in FLOOR else int(rng.integers(2, 5))
        spec = CopySpec(name, number, arrange="mixed")
        scene = place_copies(scene, spec, int(rng.integers(1 << 30))).scene
    return scene


def with_varied_copies(scene: Scene, rng: np.random.Generator) -> Scene:
    """Return the room with copies of more classes, of what deceives as well, each of any size
    that AI2-THOR has of its class.
    """
    floor = sorted(FLOOR)
    small = [name for name in COPIED if name not in FLOOR]
    also = [name for name in ALSO_COPIED if name not in FLOOR]
    counts = ((small, 4), (also, 1), (DECEIVING, 1), (floor, int(rng.integers(1, 4))))
    chosen = [str(name) for names, count in counts for name in rng.permutation(names)[:count]]
    chosen += [str(name) for name in rng.permutation(DECEIVING_FLOOR)[: int(rng.integers(1, 3))]]
    for name in chosen:
        large = name in FLOOR or name in DECEIVING_FLOOR
        spec = CopySpec(name, int(rng.integers(1, 3 if large else 4)), arrange="mixed")
        sizes = sizes_of_type(name)
        some = sizes[int(rng.integers(len(sizes)))] if sizes else None
        size_m = some if rng.random() < ANY_SIZE_SHARE else None
        scene = place_copies(scene, spec, int(rng.integers(1 << 30)), size_m).scene
    return scene
