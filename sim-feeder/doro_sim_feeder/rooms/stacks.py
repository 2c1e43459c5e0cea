"""Stacked and contained things: books on books, a mug on a plate, an apple in a bowl.

Each pile stands on a table or a counter; every thing of it is let go above the one below and
comes to rest on its triangles, so that nothing floats or cuts in. A pile is kept only if the
shared rule (:mod:`doro_schemas.spatial`) says is-on or is-at of every thing and the one below,
on the boxes as rendered.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from doro_schemas.spatial import relation_between
from doro_sim_feeder.rooms.appearance import NATURAL_COLOR, PALETTE, usual_material
from doro_sim_feeder.rooms.copies import NATURAL_CHOICE, Look, copy_material
from doro_sim_feeder.rooms.instances import Instance
from doro_sim_feeder.rooms.layout import sizes_of_type
from doro_sim_feeder.rooms.parts import Part, bounds, stable_number
from doro_sim_feeder.rooms.places import (
    draw_places,
    room_for,
    seen_from,
    surface_heights,
    turned_size_m,
)
from doro_sim_feeder.rooms.raycast import RayCaster
from doro_sim_feeder.rooms.resting import at_rest
from doro_sim_feeder.rooms.scene import Scene, Vector, object_parts

RECIPES: tuple[tuple[str, ...], ...] = (
    ("Book", "Book"),
    ("Plate", "Mug"),
    ("Bowl", "Apple"),
    ("Plate", "Plate", "Plate"),
    ("Book", "Book", "Book"),
    ("Box", "Box"),
    ("Bowl", "Bowl"),
    ("Plate", "Bowl", "Apple"),
    ("Box", "Apple"),
    ("Book", "Book", "Mug"),
    ("Plate", "Plate"),
    ("Box", "Book", "Book"),
    ("Book", "Book", "Book", "Book"),
    ("Bowl", "Bowl", "Apple"),
    ("Plate", "Plate", "Bowl", "Apple"),
    ("Plate", "Apple"),
    ("Box", "Box", "Book"),
)
"""From below to the top."""
SUPPORTS = frozenset({"CounterTop", "DiningTable", "CoffeeTable", "SideTable", "Desk", "Dresser"})
TWIN_SHARE = 0.3
SMALLER = {"Book": 0.93, "Box": 0.8, "Plate": 0.97, "Bowl": 0.95}
"""A thing on one of its kind is smaller by this factor, as people stack."""
BOOK_M = (0.21, 0.035, 0.29)
BOOK_THICK_M = (0.02, 0.05)
HEIGHTS_M = (0.2, 1.25)
"""Of the surface: the camera, 1.58 m up, looks down on what stands there."""
SLIP_M, TURN_DEG = 0.012, 25.0
APART_M, TRIES, PLACES = 0.7, 6, 40
SEEN_SHARE, SEEN_FROM = 0.06, 6
HELD = ("is-on", "is-at")
Floats = NDArray[np.float64]


@dataclass
class _Piler:
    """Builds the piles of a room, one after the other."""

    scene: Scene
    rng: np.random.Generator
    caster: RayCaster
    made: list[Instance] = field(default_factory=list)
    places: list[Floats] = field(default_factory=list)

    def build(self, recipe: tuple[str, ...], number: int) -> bool:
        """Add a pile; False where no place takes it."""
        looks = _looks(recipe, self.rng)
        sizes = _sizes(recipe, self.rng)
        shapes = [
            object_parts(kind, size, f"{self.scene.name}|{kind}|{look.color}", look.color,
                         look.material)
            for kind, size, look in zip(recipe, sizes, looks, strict=True)
        ]  # fmt: skip
        for _ in range(TRIES):
            for place_m, yaw_deg, support in self._bases(shapes):
                pile = self._pile(recipe, looks, shapes, (place_m, yaw_deg, support), number)
                if pile:
                    self.made += pile
                    self.places.append(place_m)
                    return True
        return False

    def _bases(self, shapes: list[tuple[Part, ...]]) -> list[tuple[Floats, float, str]]:
        """Return places for the lowest thing: flat, free, in view, away from other piles."""
        candidates = draw_places(self.scene, False, self.rng)
        if candidates is None:
            return []
        low, high = bounds(shapes[0])
        tops = surface_heights(self.caster, candidates, high - low, soft=False)
        height = sum(float(bounds(shape)[1][1]) for shape in shapes)
        found: list[tuple[Floats, float, str]] = []
        for k in np.flatnonzero((tops >= HEIGHTS_M[0]) & (tops <= HEIGHTS_M[1])):
            support = self.scene.instances[candidates.support[k]]
            at = np.array([candidates.x[k], float(tops[k]), candidates.z[k]])
            if support.object_type not in SUPPORTS or not self._apart(at):
                continue
            size = turned_size_m(shapes[0], float(candidates.yaw_deg[k]))
            size[1] = height
            if not room_for(at, size, self.scene, self.made):
                continue
            if self._views(at + np.array([0.0, float(high[1]) * 0.8, 0.0])) >= self._least():
                found.append((at, float(candidates.yaw_deg[k]), support.object_id))
            if len(found) >= PLACES // TRIES:
                break
        return found

    def _pile(
        self,
        recipe: tuple[str, ...],
        looks: list[Look],
        shapes: list[tuple[Part, ...]],
        base: tuple[Floats, float, str],
        number: int,
    ) -> list[Instance]:
        """Return the things of a pile at a place, empty where one of them does not rest."""
        at, yaw_deg, below = base
        pile: list[Instance] = []
        for level, (kind, look, shape) in enumerate(zip(recipe, looks, shapes, strict=True)):
            place, sinks = at, 0.04
            if pile:
                center, size = pile[-1].box().center_m, pile[-1].box().size_m
                slip = self.rng.uniform(-SLIP_M, SLIP_M, 2)
                top = float(pile[-1].corners[1][1])
                place = np.array([center[0] + slip[0], top, center[1] + slip[1]])
                yaw_deg, sinks = yaw_deg + float(self.rng.uniform(-TURN_DEG, TURN_DEG)), size[2]
            parts = at_rest(
                shape, yaw_deg, place, [*self.scene.instances, *self.made, *pile], sinks_m=sinks
            )
            if parts is None:
                return []
            x, y, z = place
            item = Instance(
                object_id=f"{kind}|{x:+06.2f}|{y:+06.2f}|{z:+06.2f}|pile{number}.{level}",
                object_type=kind,
                parts=parts,
                color=look.color,
                material=look.material,
                yaw_deg=yaw_deg,
                pickupable=True,
                receptacles=(below,),
                copy=True,
                piled=bool(pile),
            )
            if pile and relation_between(item.box(), pile[-1].box()) not in HELD:
                return []
            pile.append(item)
            below = item.object_id
        return pile

    def _apart(self, at: Floats) -> bool:
        return all(float(np.hypot(*(at - other)[[0, 2]])) > APART_M for other in self.places)

    def _views(self, at: Floats) -> int:
        return seen_from(self.scene, self.caster, at)

    def _least(self) -> int:
        return max(SEEN_FROM, int(SEEN_SHARE * len(self.scene.cells)))


def add_stacks(scene: Scene, seed: int, first: int, count: int) -> Scene:
    """Return the room with up to ``count`` piles by the recipes from number ``first`` on.

    A recipe for which the room has no place is passed over; the next is tried.
    """
    rng = np.random.default_rng([seed, stable_number(f"{scene.name}|stacks")])
    piler = _Piler(scene, rng, scene.caster())
    for number in range(first, first + 2 * count):
        if len(piler.places) < count:
            piler.build(RECIPES[number % len(RECIPES)], number)
    return scene.with_instances(piler.made)


def _looks(recipe: tuple[str, ...], rng: np.random.Generator) -> list[Look]:
    looks: list[Look] = []
    for level, kind in enumerate(recipe):
        twin = level > 0 and recipe[level - 1] == kind and rng.random() < TWIN_SHARE
        palette = NATURAL_CHOICE.get(kind, tuple(PALETTE))
        color = NATURAL_COLOR.get(kind) if kind not in NATURAL_CHOICE else None
        color = color or str(rng.choice(list(palette)))
        material = copy_material(kind, color) or usual_material(kind)
        looks.append(looks[-1] if twin else Look(color, material))
    return looks


def _sizes(recipe: tuple[str, ...], rng: np.random.Generator) -> list[Vector]:
    """Return the sizes of the things, each one's usual, smaller on its own kind."""
    sizes: list[Vector] = []
    for level, kind in enumerate(recipe):
        known = sorted(sizes_of_type(kind), key=lambda size: size[0] * size[1] * size[2])
        size = BOOK_M if kind == "Book" else known[len(known) // 2]
        like = level > 0 and recipe[level - 1] == kind
        factor = SMALLER[kind] if like else 1.0
        x, y, z = sizes[-1] if like else size
        if kind == "Book":
            factor *= float(rng.uniform(0.9, 1.0))
            sizes.append((x * factor, float(rng.uniform(*BOOK_THICK_M)), z * factor))
        else:
            sizes.append((x * factor, y * (factor if kind == "Box" else 1.0), z * factor))
    return sizes
