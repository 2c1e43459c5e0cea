"""Rooms dressed anew for training: colours, materials, shapes, prints, and things that deceive.

What the one-hour probe took for objects is put into every room on purpose: pictures and
posters with things on them, windows with plants behind them, ceiling lamps, wall clocks,
sockets, rugs, handles. Pictures are labelled as paintings, the rest carries no label.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from doro_evaluation.dressing.fittings.deceivers import deceivers
from doro_evaluation.dressing.looks import surfaces
from doro_evaluation.dressing.looks.colours import usual_rgb
from doro_evaluation.dressing.looks.prints import (
    Texture,
    cloth,
    covering,
    landscape,
    mapped,
    picture,
    screen,
    stretched,
)
from doro_evaluation.dressing.meshes.libraries import MoreMeshes
from doro_evaluation.dressing.natural import ONLY_NATURAL, natural
from doro_evaluation.dressing.shapes.makers import make_shape
from doro_sim_feeder.rooms.appearance import (
    COPY_MATERIALS,
    NATURAL_COLOR,
    NO_COLOR,
    PALETTE,
    USUAL_COLORS,
    recoloured,
    usual_material,
)
from doro_sim_feeder.rooms.footprints import ON_WALLS
from doro_sim_feeder.rooms.instances import Instance
from doro_sim_feeder.rooms.meshes import mesh_library
from doro_sim_feeder.rooms.parts import Part, Rgb, bounds, box_part, place, yaw_matrix
from doro_sim_feeder.rooms.scene import FLAT, Scene, object_parts

Rng = np.random.Generator
SHAPE_SHARE, MESH_SHARE, COLOR_SHARE, CLOTH_SHARE = 0.42, 0.3, 0.5, 0.45
HOUSE_SHARE, BOXES_SHARE = 0.67, 0.8
FIXED = FLAT | ON_WALLS | {"CounterTop", "Sink", "Cabinet", "Drawer", "Structure", "Curtains"}
SHELL = frozenset({"Floor", "Wall", "Ceiling"})
OWN_COLOR = frozenset({"Bread", "HousePlant", "TeddyBear", "BasketBall", "Potato", "Egg"})
MORE_MATERIALS = {
    "Cup": ("plastic", "glass", "ceramic", "metal", "paper"),
    "Mug": ("ceramic", "metal", "plastic"),
    "Bowl": ("ceramic", "metal", "glass", "wood", "plastic"),
    "Bottle": ("glass", "plastic", "metal"),
    "Vase": ("ceramic", "glass", "metal", "wood"),
    "Plate": ("ceramic", "plastic", "glass"),
    "Laptop": ("metal", "plastic"),
    "Chair": ("wood", "plastic", "metal"),
    "DeskLamp": ("metal", "plastic", "wood"),
    "Box": ("paper", "plastic", "wood"),
    "DiningTable": ("wood", "metal", "glass"),
    "AlarmClock": ("plastic", "metal"),
}
CLOTHED = frozenset({"Pillow", "Sofa", "ArmChair", "Bed", "Curtains", "Towel", "Cloth", "Ottoman"})
PRINTED = frozenset({"Book", "Box", "TissueBox", "Newspaper", "Poster", "CD"})


def dressed(scene: Scene, rng: Rng, meshes: MoreMeshes | None = None) -> Scene:
    """Return the room with other looks of everything in it; what is where stays as it is.

    Two rooms of three are dressed as houses are, the others in any colour.
    """
    housely = rng.random() < HOUSE_SHARE
    share = 0.88 if housely else 0.15
    fronts = _jittered(PALETTE[str(rng.choice(list(PALETTE)))], rng)
    if housely:
        fronts = usual_rgb("", str(rng.choice(["wood", "paint"])), rng)
    wooden = housely and rng.random() < 0.5
    instances = []
    for item in scene.instances:
        if item.object_type in SHELL:
            instances.append(_shell(item, rng, housely=housely))
        elif item.object_type in ("Cabinet", "Drawer", "Structure"):
            front = _front(item, fronts, rng)
            instances.append(replace(front, material="wood") if wooden else front)
        elif item.object_type in FIXED or len(item.parts) == 0:
            instances.append(_fixed(item, rng, housely=housely))
        elif rng.random() < share or item.object_type in ONLY_NATURAL:
            instances.append(_printed(natural(item, rng, meshes), rng))
        else:
            instances.append(_object(item, rng))
    return replace(scene, instances=(*instances, *deceivers(scene.room, rng, meshes)))


def _shell(item: Instance, rng: Rng, *, housely: bool) -> Instance:
    """Return a floor, the walls or the ceiling covered anew."""
    if item.object_type == "Ceiling" and rng.random() < 0.8:
        return item
    if not housely:
        part = mapped(item.parts[0], covering(rng), float(rng.uniform(0.4, 2.5)))
        return replace(item, parts=(part,))
    kind = surfaces.floor if item.object_type == "Floor" else surfaces.wall
    texture, span, shine = kind(rng)
    return replace(item, parts=(mapped(item.parts[0], texture, span),), material=shine or None)


def _front(item: Instance, color: Rgb, rng: Rng) -> Instance:
    body = [replace(part, color=color) for part in item.parts]
    if item.object_type != "Structure" and len(body) == 3:
        handle = PALETTE[str(rng.choice(["gray", "black", "white", "brown", "yellow"]))]
        body[2] = replace(item.parts[2], color=handle)
    return replace(item, parts=tuple(body))


def _object(item: Instance, rng: Rng) -> Instance:
    """Return a thing with another shape, mesh, colour or print, in the same place."""
    kind = item.object_type
    low, high = item.corners
    share = SHAPE_SHARE if mesh_library().choose(kind, 0) else BOXES_SHARE
    if (high - low).max() > 0.02 and rng.random() < share:
        item = _reshaped(item, rng, shape=True)
    elif rng.random() < MESH_SHARE:
        item = _reshaped(item, rng, shape=False)
    elif rng.random() < COLOR_SHARE and kind not in OWN_COLOR and kind not in NO_COLOR:
        name = _color(kind, rng)
        jittered = _tinted(recoloured(item.parts, name), PALETTE[name], rng)
        item = replace(item, parts=jittered, color=name, material=_material(item, rng))
    return _printed(item, rng)


def _reshaped(item: Instance, rng: Rng, *, shape: bool) -> Instance:
    low, high = item.corners
    turn = yaw_matrix(-item.yaw_deg)
    points = np.concatenate([part.vertices for part in item.parts]) @ turn.T
    size = np.maximum(points.max(axis=0) - points.min(axis=0), 0.004)
    size_m = (float(size[0]), float(size[1]), float(size[2]))
    name = NATURAL_COLOR.get(item.object_type) or _color(item.object_type, rng)
    if item.object_type == "Apple":
        name = str(rng.choice(["red", "green", "yellow"]))
    material = _material(item, rng)
    if shape:
        parts = make_shape(item.object_type, size_m, _jittered(PALETTE[name], rng), rng)
        if parts is None:
            return item
    else:
        key = str(rng.integers(1 << 30))
        parts = object_parts(item.object_type, size_m, key, name, material)
        if item.object_type not in OWN_COLOR and item.object_type not in NATURAL_COLOR:
            parts = _tinted(parts, PALETTE[name], rng)
    middle = (low + high) / 2
    placed = place(parts, item.yaw_deg, (middle[0], low[1], middle[2]))
    color = None if item.object_type in NO_COLOR else name
    return replace(item, parts=placed, color=color, material=material)


def look_of(kind: str, rng: Rng) -> tuple[str | None, str | None]:
    """Return a colour and a material that a thing of a class may have."""
    color = NATURAL_COLOR.get(kind) or _color(kind, rng)
    if kind == "Apple":
        color = str(rng.choice(["red", "green", "yellow"]))
    choices = MORE_MATERIALS.get(kind) or COPY_MATERIALS.get(kind)
    material = str(rng.choice(list(choices))) if choices else usual_material(kind)
    return (None if kind in NO_COLOR else color), material


def _tinted(parts: tuple[Part, ...], rgb: Rgb, rng: Rng) -> tuple[Part, ...]:
    """Return the parts of exactly this colour in a nearby one."""
    near = _jittered(rgb, rng)
    return tuple(replace(part, color=near) if part.color == rgb else part for part in parts)


def _color(kind: str, rng: Rng) -> str:
    names = USUAL_COLORS.get(kind, ())
    if names and rng.random() < 0.35:
        return str(rng.choice(list(names)))
    return str(rng.choice(list(PALETTE)))


def _material(item: Instance, rng: Rng) -> str | None:
    kind = item.object_type
    choices = MORE_MATERIALS.get(kind) or COPY_MATERIALS.get(kind)
    if choices and rng.random() < 0.6:
        return str(rng.choice(list(choices)))
    return item.material or usual_material(kind)


def _jittered(rgb: Rgb, rng: Rng) -> Rgb:
    moved = np.clip(np.asarray(rgb) * rng.uniform(0.85, 1.15) + rng.normal(0, 0.02, 3), 0.02, 0.97)
    red, green, blue = moved.tolist()
    return (red, green, blue)


def _printed(item: Instance, rng: Rng) -> Instance:
    """Return cloth with a pattern, paper with a print; the colour that is named stays."""
    kind = item.object_type
    areas = [part.area_m2() for part in item.parts]
    largest = int(np.argmax(areas))
    part = item.parts[largest]
    parts = list(item.parts)
    if kind in CLOTHED and part.texture is None and rng.random() < CLOTH_SHARE:
        span = float(rng.uniform(0.15, 0.6))
        parts[largest] = mapped(part, cloth(rng, part.color), span)
    elif kind in PRINTED and part.texture is None and rng.random() < CLOTH_SHARE:
        low, high = bounds((part,))
        size = high - low
        inner = 0.5 * size * rng.uniform(0.3, 0.75, 3)
        inner[1] = size[1] / 2 + 0.002
        if kind == "Box" and rng.random() < 0.6:
            flip = int(rng.choice([0, 2]))
            inner = 0.5 * size * rng.uniform(0.3, 0.75, 3)
            inner[flip] = size[flip] / 2 + 0.003
        middle = (low + high) / 2
        label = box_part(middle - inner, middle + inner, (1.0, 1.0, 1.0))
        # Only small prints keep the colour that names the thing the main one.
        if item.yaw_deg % 90 == 0 or kind != "Box":
            parts.append(stretched(label, picture(rng)))
    elif kind in ("Television", "Laptop") and len(parts) > 1 and rng.random() < 0.6:
        dark = [k for k, one in enumerate(parts) if max(one.color) < 0.12 and areas[k] > 0.01]
        for k in dark[:1]:
            parts[k] = stretched(parts[k], screen(rng))
    return replace(item, parts=tuple(parts))


def _fixed(item: Instance, rng: Rng, *, housely: bool) -> Instance:
    """Return a picture, window, mirror, curtain or counter with another look."""
    kind, parts = item.object_type, list(item.parts)
    if kind in ("Painting", "Poster") and parts:
        parts[0] = replace(parts[0], color=_jittered(PALETTE[_color("", rng)], rng))
        parts[-1] = stretched(parts[-1], picture(rng))
    elif kind == "Window" and len(parts) == 2:
        if rng.random() < 0.8:
            parts[1] = stretched(parts[1], landscape(rng))
        parts += _bars(parts[1], rng)
    elif kind == "Mirror" and len(parts) == 2:
        parts[1] = stretched(parts[1], _pale(rng))
    elif kind == "CounterTop":
        if housely:
            return _counter(item, rng)
        texture = cloth(rng, _jittered(PALETTE[_color(kind, rng)], rng))
        return replace(item, parts=tuple(mapped(p, texture, 0.5) for p in parts), color=None)
    elif kind == "Curtains":
        tone = usual_rgb("", "fabric", rng) if housely else PALETTE[_color("", rng)]
        texture = cloth(rng, _jittered(tone, rng))
        return replace(item, parts=tuple(mapped(p, texture, 0.4) for p in parts), color=None)
    return replace(item, parts=tuple(parts))


def _counter(item: Instance, rng: Rng) -> Instance:
    """Return a counter of stone or wood."""
    if rng.random() < 0.7:
        tone = usual_rgb("", "stone", rng)
        texture, material = surfaces.stone(rng, tone), "stone"
    else:
        texture, material = surfaces.wood(rng, surfaces.wood_tone(rng)), "wood"
    parts = tuple(mapped(part, texture, 0.7) for part in item.parts)
    return replace(item, parts=parts, color=None, material=material)


def _pale(rng: Rng) -> Texture:
    """Return the pale, smooth image of a mirror."""
    ends = rng.uniform(110, 240, (2, 1, 1, 3)) * np.array([0.97, 1.0, 1.03])
    share = np.linspace(0, 1, 64)[:, None, None]
    image = ends[0] * (1 - share) + ends[1] * share
    pale: Texture = np.clip(np.broadcast_to(image, (64, 64, 3)), 0, 255).astype(np.uint8)
    return pale


def _bars(pane: Part, rng: Rng) -> list[Part]:
    """Return the mullions of a window."""
    low, high = bounds((pane,))
    size = high - low
    thin = 0 if size[0] < size[2] else 2
    wide = 2 - thin
    color = _jittered(PALETTE[str(rng.choice(["white", "brown", "gray", "black"]))], rng)
    bars = []
    for axis, count in ((wide, int(rng.integers(0, 4))), (1, int(rng.integers(0, 4)))):
        for k in range(count):
            at = low[axis] + size[axis] * (k + 1) / (count + 1)
            bar_low, bar_high = low.copy(), high.copy()
            bar_low[axis], bar_high[axis] = at - 0.015, at + 0.015
            bar_low[thin] -= 0.008
            bar_high[thin] += 0.008
            bars.append(box_part(bar_low, bar_high, color))
    return bars
