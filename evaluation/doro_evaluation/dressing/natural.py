"""Things as houses have them: meshes in their own colours, shapes in usual ones, wood that is wood.

Colour and material are named by what is then seen of the thing, or not at all.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from doro_evaluation.dressing.looks.colours import seen_colour, shifted, usual_rgb
from doro_evaluation.dressing.looks.prints import mapped
from doro_evaluation.dressing.looks.surfaces import wood, wood_tone
from doro_evaluation.dressing.meshes.libraries import MoreMeshes
from doro_evaluation.dressing.shapes.makers import make_shape
from doro_evaluation.dressing.shapes.oddments import ODDMENTS
from doro_sim_feeder.rooms.appearance import (
    COPY_MATERIALS,
    NATURAL_COLOR,
    NO_COLOR,
    usual_material,
)
from doro_sim_feeder.rooms.instances import Instance
from doro_sim_feeder.rooms.parts import Part, place, yaw_matrix
from doro_sim_feeder.rooms.scene import object_parts

Rng = np.random.Generator
Size = tuple[float, float, float]
MESH_SHARE, SHAPE_SHARE, WOOD_SHARE = 0.5, 0.75, 0.5
# Classes that rooms and shapes know nothing of.
ONLY_NATURAL = frozenset({"TableTopDecor", "Wardrobe", "Boots", "Desktop"})
FURNITURE = frozenset(
    """DiningTable CoffeeTable SideTable Desk Dresser TVStand ShelvingUnit Chair Stool Bed Box
    Safe""".split()  # noqa: SIM905
)
# Classes whose models of the library are made of this and that.
MANY = frozenset({"Statue", "Chair", "DeskLamp", "Cup", "Box", "Laptop", "Vase", "Stool", "Bowl"})
# Of what one sees that it is so; other materials of a class stay without a name.
MADE_OF = {
    "Cup": ("plastic", "glass", "ceramic", "paper"),
    "Mug": ("ceramic", "ceramic", "metal"),
    "Bowl": ("ceramic", "metal", "glass", "wood"),
    "Bottle": ("glass", "plastic"),
    "Vase": ("ceramic", "ceramic", "glass"),
    "Chair": ("wood", "wood", "plastic"),
    "DeskLamp": ("metal", "metal", "plastic"),
    "Box": ("paper",),
    "Book": ("paper",),
    "Stool": ("wood", "wood", "metal"),
    "SideTable": ("wood",),
    "Statue": ("metal", "stone", "ceramic", "wood"),
    "AlarmClock": ("plastic", "metal"),
    "Bathtub": ("ceramic",),
    "Toilet": ("ceramic",),
    "LaundryHamper": ("plastic", "fabric", "wood"),
}


def natural(item: Instance, rng: Rng, meshes: MoreMeshes | None) -> Instance:
    """Return a thing as a house may have it, in the same place and of the same size."""
    kind = item.object_type
    size = _size_of(item)
    choices = MADE_OF.get(kind) or COPY_MATERIALS.get(kind)
    material = str(rng.choice(list(choices))) if choices else usual_material(kind)
    parts: tuple[Part, ...] | None = None
    row = meshes.fitting(kind, size, rng) if meshes is not None else None
    if meshes is not None and row and (rng.random() < MESH_SHARE or kind in ONLY_NATURAL):
        parts, material = shifted(meshes.parts(row, size), rng), row.material
        if kind == "Statue" and rng.random() < 0.7:
            material = str(rng.choice(list(MADE_OF["Statue"])))
            parts = _of_one_piece(parts, material, rng)
    elif rng.random() < SHAPE_SHARE or kind in ODDMENTS:
        parts = make_shape(kind, size, usual_rgb(kind, material, rng), rng)
    if parts is None:
        key = str(rng.integers(1 << 30))
        parts = shifted(object_parts(kind, size, key, None, material), rng)
        if kind in ("Pillow", "Ottoman", "DogBed", "SprayBottle", "DishSponge"):
            tone = usual_rgb(kind, material, rng)
            parts = tuple(replace(part, color=tone) for part in parts)
        material = None if kind in MANY else usual_material(kind)
    if kind == "Bed":
        material = None
    if material == "wood" and kind in FURNITURE and rng.random() < WOOD_SHARE:
        parts = _grained(parts, rng)
    low, high = item.corners
    middle = (low + high) / 2
    return replace(
        item,
        parts=place(parts, item.yaw_deg, (middle[0], low[1], middle[2])),
        color=_colour(kind, parts),
        material=material,
    )


def _colour(kind: str, parts: tuple[Part, ...]) -> str | None:
    if kind in NO_COLOR:
        return None
    named = kind in ("HousePlant", "Lettuce", "BasketBall", "Tomato")
    return NATURAL_COLOR[kind] if named else seen_colour(parts)


def _size_of(item: Instance) -> Size:
    """Return the size of a thing along its own axes, metres."""
    turn = yaw_matrix(-item.yaw_deg)
    points = np.concatenate([part.vertices for part in item.parts]) @ turn.T
    wide, high, deep = np.maximum(points.max(axis=0) - points.min(axis=0), 0.004).tolist()
    return wide, high, deep


def _of_one_piece(parts: tuple[Part, ...], material: str, rng: Rng) -> tuple[Part, ...]:
    """Return the parts as cast or carved of one material."""
    tone = usual_rgb("Statue" if material != "wood" else "", material, rng)
    return tuple(replace(part, color=tone, texture=None, uv=None) for part in parts)


def _grained(parts: tuple[Part, ...], rng: Rng) -> tuple[Part, ...]:
    """Return the parts with the large ones covered in wood."""
    areas = [part.area_m2() for part in parts]
    most, texture = max(areas), wood(rng, wood_tone(rng))
    span = float(rng.uniform(0.4, 1.2))
    return tuple(
        mapped(part, texture, span) if area > 0.15 * most else part
        for part, area in zip(parts, areas, strict=True)
    )
