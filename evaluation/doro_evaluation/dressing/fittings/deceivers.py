"""Things in training rooms that deceive: lamps, rugs, doors, windows, pictures, sockets, clocks.

Pictures and windows are labelled as what they are, the rest carries no label.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from doro_evaluation.dressing.fittings.doors import behind, door
from doro_evaluation.dressing.looks.colours import shifted, usual_rgb
from doro_evaluation.dressing.looks.prints import (
    Texture,
    cloth,
    covering,
    landscape,
    mapped,
    picture,
    stretched,
)
from doro_evaluation.dressing.looks.surfaces import near, wood_tone
from doro_evaluation.dressing.meshes.libraries import GLASS, MoreMeshes
from doro_evaluation.dressing.shapes.solids import lathe
from doro_sim_feeder.rooms.appearance import PALETTE
from doro_sim_feeder.rooms.fittings import CEILING_M
from doro_sim_feeder.rooms.footprints import Rect
from doro_sim_feeder.rooms.instances import Instance
from doro_sim_feeder.rooms.parts import Part, Rgb, box_part, place, vertex_normals

Rng = np.random.Generator
PROUD_M, FRAME_M, TALLEST_WINDOW_M = 0.1, 0.002, 1.8


def deceivers(room: Rect, rng: Rng, meshes: MoreMeshes | None = None) -> list[Instance]:
    """Return ceiling lamps, rugs, sun spots, and on the walls doors, windows, pictures, clocks."""
    found: list[Instance] = []
    for number in range(int(rng.integers(0, 4))):
        found.append(Instance(f"Deceiver|lamp{number}", "Structure", _ceiling_lamp(room, rng)))
    if rng.random() < 0.5:
        found.append(Instance("Deceiver|rug", "Structure", (_rug(room, rng),)))
    if rng.random() < 0.25:
        found.append(Instance("Deceiver|sun", "Structure", _sun_spots(room, rng)))
    for number in range(int(rng.integers(0, 4))):
        made = _mesh_door(room, rng, meshes) if meshes and rng.random() < 0.45 else None
        wooden = "wood" if rng.random() < 0.5 else None
        parts = made or door(room, rng)
        found.append(Instance(f"Deceiver|door{number}", "Structure", parts, material=wooden))
    if meshes is not None:
        found += _mesh_fittings(room, rng, meshes)
    if rng.random() < 0.3:
        found.append(Instance("Deceiver|curtains", "Curtains", _curtains(room, rng)))
    for number in range(int(rng.integers(2, 9))):
        parts, kind = _on_wall(room, rng)
        found.append(Instance(f"Deceiver|wall{number}", kind, parts))
    return found


def _curtains(room: Rect, rng: Rng) -> tuple[Part, ...]:
    """Return one or two curtains in folds, on a rail."""
    wide, high = float(rng.uniform(0.4, 1.0)), float(rng.uniform(1.1, 2.2))
    folds, bulge = int(rng.integers(4, 12)), float(rng.uniform(0.015, 0.04))
    color = usual_rgb("", "fabric", rng)
    at = np.linspace(0, 1, 8 * folds)
    path = np.column_stack([wide * at, np.zeros(len(at)), bulge * np.sin(2 * np.pi * folds * at)])
    ends = np.concatenate([path, path + np.array([0, high, 0])])
    count = len(at)
    k = np.arange(count - 1)
    faces = np.concatenate([np.stack([k, k + 1, k + count + 1], 1),
                            np.stack([k, k + count + 1, k + count], 1)])  # fmt: skip
    normals = vertex_normals(ends, faces).astype(np.float32)
    sheet = Part(ends.astype(np.float32), faces.astype(np.int32), normals, None, color)
    if rng.random() < 0.4:
        sheet = mapped(sheet, cloth(rng, color), 0.4)
    gap = float(rng.uniform(0, 1.0))
    sheets = [sheet.moved((-wide - gap / 2, 0, 0))]
    if rng.random() < 0.7:
        sheets.append(sheet.moved((gap / 2, 0, 0)))
    span = wide + gap / 2 + 0.05
    rail = box_part((-span, high, -0.01), (span, high + 0.025, 0.015), (0.3, 0.25, 0.2))
    low_m = 0.03 if high > 1.8 else float(rng.uniform(0.4, 0.9))
    size = (2 * span, high, 0.12)
    return _at_wall(room, (*sheets, rail), size, low_m, rng)


def _any(rng: Rng) -> str:
    return str(rng.choice(list(PALETTE)))


def _sun_spots(room: Rect, rng: Rng) -> tuple[Part, ...]:
    """Return bright quads on the floor, as the sun makes through panes."""
    x = float(rng.uniform(room.x_low + 0.3, room.x_high - 0.8))
    z = float(rng.uniform(room.z_low + 0.3, room.z_high - 0.8))
    wide, deep = rng.uniform(0.15, 0.6, 2).tolist()
    spots = [box_part((0, 0.0005, 0), (wide, 0.003, deep), (0.98, 0.97, 0.93))]
    if rng.random() < 0.6:
        spots.append(spots[0].moved((wide + 0.08, 0, 0)))
    return place(tuple(spots), float(rng.uniform(0, 360)), (x, 0, z))


def _at_wall(
    room: Rect, parts: tuple[Part, ...], size_m: tuple[float, float, float], low_m: float, rng: Rng
) -> tuple[Part, ...]:
    """Return parts (back to -z, standing on the origin) put against a random wall."""
    side = int(rng.integers(4))
    along = (room.x_low, room.x_high) if side % 2 == 0 else (room.z_low, room.z_high)
    half, off = size_m[0] / 2, size_m[2] / 2 + FRAME_M
    at = float(rng.uniform(along[0] + half, max(along[1] - half, along[0] + half + 0.01)))
    spot = {
        0: (at, low_m, room.z_low + off),
        1: (room.x_low + off, low_m, at),
        2: (at, low_m, room.z_high - off),
        3: (room.x_high - off, low_m, at),
    }[side]
    return place(parts, 90.0 * side, spot)


def _mesh_door(room: Rect, rng: Rng, meshes: MoreMeshes) -> tuple[Part, ...] | None:
    """Return a modelled door, closed in its wall or standing open into the room."""
    rows = meshes.of("Door")
    if not rows:
        return None
    row = rows[int(rng.integers(len(rows)))]
    wide, high, _ = meshes.size_m(row)
    size = (wide * float(rng.uniform(0.85, 1.05)), high * float(rng.uniform(0.92, 1.05)), PROUD_M)
    parts = _glazed(meshes.parts(row, size), behind(rng))
    if rng.random() < 0.6:
        tone = wood_tone(rng) if rng.random() < 0.7 else near(PALETTE[_any(rng)], rng)
        parts = _painted(parts, tone)
    parts = shifted(parts, rng)
    if rng.random() < 0.2:
        parts = place(parts, 90.0, (0, 0, size[0] / 2))
        size = (PROUD_M, size[1], 0.0)
    return _at_wall(room, parts, size, 0.0, rng)


def _glazed(parts: tuple[Part, ...], view: Texture) -> tuple[Part, ...]:
    """Return the parts of a window or a door with a view where glass is."""
    return tuple(stretched(part, view) if part.color == GLASS else part for part in parts)


def _painted(parts: tuple[Part, ...], tone: Rgb) -> tuple[Part, ...]:
    """Return the parts with all large ones without a print in a tone."""
    areas = [part.area_m2() for part in parts]
    most = max(areas)
    return tuple(
        replace(part, color=tone) if part.texture is None and area > 0.08 * most else part
        for part, area in zip(parts, areas, strict=True)
    )


def _mesh_fittings(room: Rect, rng: Rng, meshes: MoreMeshes) -> list[Instance]:
    """Return modelled windows with a view, and radiators and other fittings without a label."""
    found = []
    rows = meshes.of("Window")
    for number in range(int(rng.integers(0, 3)) if rows else 0):
        row = rows[int(rng.integers(len(rows)))]
        wide, high, _ = meshes.size_m(row)
        size = (wide, min(high, 2.2), PROUD_M)
        parts = _glazed(meshes.parts(row, size), landscape(rng))
        low_m = 0.02 if high > TALLEST_WINDOW_M else float(rng.uniform(0.7, 1.1))
        placed = _at_wall(room, parts, size, low_m, rng)
        # What reaches down to the floor is a door.
        kind = "Window" if high <= TALLEST_WINDOW_M else "Structure"
        found.append(Instance(f"Deceiver|window{number}", kind, placed))
    rows = meshes.of("WallThing")
    for number in range(int(rng.integers(0, 2)) if rows else 0):
        row = rows[int(rng.integers(len(rows)))]
        size = meshes.size_m(row)
        low_m = 0.1 if size[1] > 0.4 else float(rng.uniform(0.3, 2.1))
        placed = _at_wall(room, meshes.parts(row, size), size, low_m, rng)
        found.append(Instance(f"Deceiver|fitting{number}", "Structure", placed))
    return found


def _ceiling_lamp(room: Rect, rng: Rng) -> tuple[Part, ...]:
    x = float(rng.uniform(room.x_low + 0.4, room.x_high - 0.4))
    z = float(rng.uniform(room.z_low + 0.4, room.z_high - 0.4))
    wide, deep = float(rng.uniform(0.06, 0.35)), float(rng.uniform(0.05, 0.3))
    shade = near(PALETTE[_any(rng)] if rng.random() < 0.5 else (0.95, 0.93, 0.86), rng)
    drop = float(rng.uniform(0, 0.7)) if rng.random() < 0.5 else 0.0
    top = CEILING_M - drop
    rows = [(wide, top - deep), (wide * float(rng.uniform(0.2, 1)), top), (0, top)]
    if rng.random() < 0.5:
        rows = [(0.0, top - deep), *rows]
    parts = [lathe(rows, shade).moved((x, 0, z))]
    if drop:
        cord = lathe([(0.008, top), (0.008, CEILING_M)], (0.1, 0.1, 0.1), 6)
        parts.append(cord.moved((x, 0, z)))
    return tuple(parts)


def _rug(room: Rect, rng: Rng) -> Part:
    span = np.array([room.x_high - room.x_low, room.z_high - room.z_low])
    size = span * rng.uniform(0.25, 0.6, 2)
    x, z = (np.array([room.x_low, room.z_low]) + (span - size) * rng.random(2)).tolist()
    flat = box_part((x, 0.0005, z), (x + float(size[0]), 0.004, z + float(size[1])), (1, 1, 1))
    texture = picture(rng) if rng.random() < 0.4 else covering(rng)
    return stretched(flat, texture)


def _on_wall(room: Rect, rng: Rng) -> tuple[tuple[Part, ...], str]:
    """Return a picture, a socket, a board or a clock on a wall, and its objectType."""
    axis, far = (0, 2)[int(rng.integers(2))], bool(rng.integers(2))
    along = (room.z_low, room.z_high) if axis == 0 else (room.x_low, room.x_high)
    face = ((room.x_low, room.x_high) if axis == 0 else (room.z_low, room.z_high))[far]
    kind = rng.random()
    wide, high, deep = {
        0: (rng.uniform(0.15, 0.9), rng.uniform(0.15, 0.9), 0.03),
        1: (rng.uniform(0.05, 0.12), rng.uniform(0.05, 0.12), 0.012),
        2: (rng.uniform(0.3, 0.8), rng.uniform(0.02, 0.04), 0.2),
        3: (rng.uniform(0.2, 0.4), rng.uniform(0.2, 0.4), 0.04),
    }[int(np.searchsorted([0.45, 0.7, 0.8], kind))]
    at = float(rng.uniform(along[0] + 0.1, max(along[1] - 0.1 - wide, along[0] + 0.11)))
    low_m = float(rng.uniform(0.2, 2.2)) if kind >= 0.45 else float(rng.uniform(0.9, 1.8))
    low, size = np.zeros(3), np.zeros(3)
    low[2 - axis], low[1], low[axis] = at, low_m, face - (deep if far else 0)
    size[2 - axis], size[1], size[axis] = wide, min(high, CEILING_M - low_m - 0.02), deep
    frame = box_part(low, low + size, near(PALETTE[_any(rng)], rng))
    if kind >= 0.8:
        size[axis] += 0.01
        inner = box_part(low + size * 0.08, low + size * 0.92, (0.92, 0.92, 0.9))
        return (frame, inner), "Structure"
    if kind >= 0.45:
        return (frame,), "Structure"
    inset = np.minimum(size * 0.08, 0.05)
    pane_low, pane_high = low + inset, low + size - inset
    pane_low[axis], pane_high[axis] = low[axis] - 0.004, low[axis] + size[axis] + 0.004
    pane = box_part(pane_low, pane_high, (1, 1, 1))
    return (frame, stretched(pane, picture(rng))), "Painting"
