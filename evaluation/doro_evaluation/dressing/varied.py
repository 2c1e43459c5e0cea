"""A room of the training with other furniture, rendered as the evaluation renders.

A layout's colours, meshes and materials follow from its names, so that plain frames of a room show
the same sofa in every seed, and a net learns that sofa by heart. Here names are salted, some
things are taken out, and others are made of another material of their class.
"""

from __future__ import annotations

from dataclasses import replace

import msgspec
import numpy as np

from doro_sim_feeder.rooms.appearance import COPY_MATERIALS
from doro_sim_feeder.rooms.layout import LayoutObject, RoomLayout, load_layout
from doro_sim_feeder.rooms.scene import Scene, build_layout

TAKEN_SHARE, OTHER_MATERIAL_SHARE = 0.25, 0.5


def varied(layout: RoomLayout, rng: np.random.Generator) -> RoomLayout:
    """Return the layout under another name, with other looks and some things less."""
    salt = f"~{int(rng.integers(1 << 30))}"
    kept = []
    for item in layout.objects:
        loose = item.moveable or item.pickupable
        if loose and rng.random() < TAKEN_SHARE:
            continue
        own = item.asset_id or item.object_id
        kept.append(
            msgspec.structs.replace(item, asset_id=own + salt, materials=_materials(item, rng))
        )
    return msgspec.structs.replace(layout, name=layout.name + salt, objects=tuple(kept))


def _materials(item: LayoutObject, rng: np.random.Generator) -> tuple[str, ...]:
    choice = COPY_MATERIALS.get(item.object_type, ())
    if choice and rng.random() < OTHER_MATERIAL_SHARE:
        return (choice[int(rng.integers(len(choice)))],)
    return item.materials


def varied_scene(room: str, rng: np.random.Generator) -> Scene:
    """Return a room of other furniture."""
    return replace(build_layout(varied(load_layout(room), rng)), name=room)
