"""A room of the training with other furniture, rendered as the evaluation renders.

A layout's colours, meshes and materials follow from its names, so that plain frames of a room show
the same sofa in every seed, and a net learns that sofa by heart. Here names are salted, some
things are taken out, and others are made of another material, or have another size, of their class.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import msgspec
import numpy as np

from doro_sim_feeder.rooms.appearance import COPY_MATERIALS
from doro_sim_feeder.rooms.layout import LayoutObject, RoomLayout, load_layout, sizes_of_type
from doro_sim_feeder.rooms.parts import yaw_matrix
from doro_sim_feeder.rooms.scene import Scene, build_layout

TAKEN_SHARE, OTHER_MATERIAL_SHARE, OTHER_SIZE_SHARE = 0.25, 0.5, 0.6
WIDER, HIGHER_M = 1.1, 0.2
"""Another size may be so much wider than the own, and so much higher: it has to find room."""
LEVEL_DEG = 5.0
LEAST_LONG_M = 3.5
"""So long a stretch of an apartment at least is one room."""


def varied(layout: RoomLayout, rng: np.random.Generator) -> RoomLayout:
    """Return the layout under another name, with other looks and some things less."""
    salt = f"~{int(rng.integers(1 << 30))}"
    carrying = {name for item in layout.objects for name in item.receptacles}
    kept = []
    gone: set[str] = set()
    for item in layout.objects:
        loose = item.moveable or item.pickupable
        if loose and rng.random() < TAKEN_SHARE:
            gone.add(item.object_id)
            continue
        own = item.asset_id or item.object_id
        other = item
        if loose and rng.random() < OTHER_SIZE_SHARE:
            other = _resized(item, HIGHER_M * (item.object_id not in carrying), rng)
        kept.append(
            msgspec.structs.replace(other, asset_id=own + salt, materials=_materials(item, rng))
        )
    objects = _still_carried(kept, gone)
    return msgspec.structs.replace(layout, name=layout.name + salt, objects=objects)


def _still_carried(kept: Iterable[LayoutObject], gone: Iterable[str]) -> tuple[LayoutObject, ...]:
    """Return what does not stand on anything that was taken out, nor on what goes with that."""
    left, without = list(kept), set(gone)
    while fallen := {item.object_id for item in left if without.intersection(item.receptacles)}:
        without |= fallen
        left = [item for item in left if item.object_id not in fallen]
    return tuple(left)


def _materials(item: LayoutObject, rng: np.random.Generator) -> tuple[str, ...]:
    choice = COPY_MATERIALS.get(item.object_type, ())
    if choice and rng.random() < OTHER_MATERIAL_SHARE:
        return (choice[int(rng.integers(len(choice)))],)
    return item.materials


def _resized(item: LayoutObject, higher_m: float, rng: np.random.Generator) -> LayoutObject:
    """Return a thing that stands upright in the size of another asset of its class.

    Args:
        higher_m: how much higher it may be; 0: something stands on it, it stays as high as it is.
    """
    own = item.asset_size_m
    tilt = max(
        abs((angle + 180) % 360 - 180) for angle in (item.rotation_deg[0], item.rotation_deg[2])
    )
    if own is None or tilt > LEVEL_DEG:
        return item
    fit = [
        size
        for size in sizes_of_type(item.object_type)
        if size[0] <= own[0] * WIDER
        and size[2] <= own[2] * WIDER
        and (size[1] <= own[1] + higher_m or not higher_m)
    ]
    if not higher_m:
        fit = [(size[0], own[1], size[2]) for size in fit]
    if not fit:
        return item
    size = fit[int(rng.integers(len(fit)))]
    half = np.abs(yaw_matrix(item.rotation_deg[1])) @ np.asarray(size) / 2
    x, z = ((item.low_m[k] + item.high_m[k]) / 2 for k in (0, 2))
    low = (x - float(half[0]), item.low_m[1], z - float(half[2]))
    high = (x + float(half[0]), item.low_m[1] + size[1], z + float(half[2]))
    return msgspec.structs.replace(item, low_m=low, high_m=high, asset_size_m=size)


def stretch(layout: RoomLayout, rng: np.random.Generator) -> RoomLayout:
    """Return a part of an apartment as a room: what stands between two x, the ends at random.

    An apartment's inner walls are not recorded, and nobody sees all of it at once.
    """
    low = min(item.low_m[0] for item in layout.objects)
    high = max(item.high_m[0] for item in layout.objects)
    long_m = float(rng.uniform(LEAST_LONG_M, max(high - low, LEAST_LONG_M)))
    start = float(rng.uniform(low, max(high - long_m, low)))
    inside = tuple(
        item
        for item in layout.objects
        if item.low_m[0] >= start and item.high_m[0] <= start + long_m
    )
    return msgspec.structs.replace(layout, objects=inside)


def varied_scene(room: str, rng: np.random.Generator) -> Scene:
    """Return a room of other furniture; of an apartment a part."""
    layout = load_layout(room)
    if layout.kind == "apartments":
        layout = stretch(layout, rng)
    return replace(build_layout(varied(layout, rng)), name=room)
