"""Which copies are asked for: class, number, looks, and how they stand to each other."""

from __future__ import annotations

from typing import Literal

import msgspec
import numpy as np

from doro_schemas.errors import Refused
from doro_sim_feeder.rooms.appearance import (
    COPY_MATERIALS,
    NATURAL_COLOR,
    PALETTE,
    usual_material,
)
from doro_sim_feeder.rooms.parts import stable_number

MAX_COPIES = 20
TWIN_SHARE = 0.3
OTHER_MATERIAL_SHARE = 0.15
STACK_SHARE, CLOSE_SHARE = 0.25, 0.3
# What people stack on its like.
STACKED = frozenset({"Plate", "Bowl", "Book", "Box", "CD", "Newspaper"})
# Natural things that come in several colours all the same.
NATURAL_CHOICE = {"Apple": ("red", "green", "yellow")}
Arrangement = Literal["mixed", "apart"]
Stance = Literal["apart", "close", "stacked"]


class CopySpec(msgspec.Struct, frozen=True):
    """Which copies to spawn.

    Attributes:
        object_type: AI2-THOR's class name ("Cup").
        count: how many, besides those that the room has.
        colors: named colours in turn; empty: drawn by the seed, now and then twins.
        arrange: ``apart``: on different receptacles where there are; ``mixed``: some of them
            10-30 cm from another copy, and some on top of one where the class is stacked.
    """

    object_type: str
    count: int
    colors: tuple[str, ...] = ()
    arrange: Arrangement = "apart"

    def __post_init__(self) -> None:
        if not 1 <= self.count <= MAX_COPIES:
            raise Refused(f"{self.count} copies were asked for: 1 to {MAX_COPIES} can be placed")
        unknown = [color for color in self.colors if color not in PALETTE]
        if unknown:
            raise Refused(f"unknown colour '{unknown[0]}': use one of {', '.join(PALETTE)}")


class Look(msgspec.Struct, frozen=True):
    """What a copy looks like; equal looks are identical twins."""

    color: str | None
    material: str | None


class Wish(msgspec.Struct, frozen=True):
    """One copy as it is wanted."""

    object_type: str
    look: Look
    stance: Stance


class Unplaced(msgspec.Struct, frozen=True):
    """A copy that was asked for and found no place.

    Attributes:
        name: ``copy<k>``, its number among those asked for.
        reason: what kept the places tried from being taken.
    """

    name: str
    object_type: str
    attributes: dict[str, str]
    reason: str


def wishes(spec: CopySpec, rng: np.random.Generator) -> list[Wish]:
    """Return the copies of a specification in the order in which they are placed."""
    stances: list[Stance] = ["apart"] * spec.count
    if spec.arrange == "mixed":
        for k in range(1, spec.count):
            draw = rng.random()
            if spec.object_type in STACKED and draw < STACK_SHARE:
                stances[k] = "stacked"
            elif draw > 1 - CLOSE_SHARE:
                stances[k] = "close"
    return [
        Wish(spec.object_type, look, stance)
        for look, stance in zip(_looks(spec, rng), stances, strict=True)
    ]


def _looks(spec: CopySpec, rng: np.random.Generator) -> list[Look]:
    kind = spec.object_type
    if spec.colors:
        named = [spec.colors[k % len(spec.colors)] for k in range(spec.count)]
        return [Look(color, copy_material(kind, color)) for color in named]
    if kind in NATURAL_COLOR and kind not in NATURAL_CHOICE:
        return [Look(NATURAL_COLOR[kind], usual_material(kind))] * spec.count
    palette = NATURAL_CHOICE.get(kind, tuple(PALETTE))
    fresh = [str(name) for name in rng.permutation(list(palette))]
    looks: list[Look] = []
    for _ in range(spec.count):
        draw = rng.random()
        old = looks[int(rng.integers(len(looks)))] if looks else None
        others = [] if old is None else _other_materials(kind, old)
        if old is not None and (draw < TWIN_SHARE or not fresh):
            looks.append(old)
        elif old is not None and others and draw < TWIN_SHARE + OTHER_MATERIAL_SHARE:
            looks.append(Look(old.color, others[0]))
        else:
            color = fresh.pop()
            looks.append(Look(color, copy_material(kind, color)))
    return looks


def _other_materials(kind: str, look: Look) -> list[str]:
    return [name for name in COPY_MATERIALS.get(kind, ()) if name != look.material]


def copy_material(object_type: str, color: str) -> str | None:
    """Return the material of a spawned copy; twins of a colour share it."""
    choices = COPY_MATERIALS.get(object_type)
    if choices is None:
        return usual_material(object_type)
    return choices[stable_number(f"{object_type}|{color}") % len(choices)]
