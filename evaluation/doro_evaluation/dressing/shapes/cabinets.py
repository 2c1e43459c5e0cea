"""Boxy furniture: dressers, tables, desks, shelves, safes, stands."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from doro_evaluation.dressing.shapes.solids import Maker, Rng, accent, between, dark, lathe, tube
from doro_sim_feeder.rooms.parts import Part, Rgb, blob_part, box_part

Vectors = NDArray[Any]
HANDLES: tuple[Rgb, ...] = (
    (0.7, 0.7, 0.71), (0.1, 0.1, 0.1), (0.65, 0.5, 0.2), (0.88, 0.88, 0.86), (0.3, 0.18, 0.1),
)  # fmt: skip


def _handle(rng: Rng, at: tuple[float, float, float], wide: float, style: int, tone: Rgb) -> Part:
    """Return a knob, a bar, a cup or a groove on a front that looks to +z."""
    del rng
    x, y, z = at
    if style == 0:
        return blob_part((0.035, 0.035, 0.035), tone).moved((x, y - 0.018, z + 0.012))
    if style == 1:
        ends = [
            (x - wide, y, z),
            (x - wide, y, z + 0.025),
            (x + wide, y, z + 0.025),
            (x + wide, y, z),
        ]
        return tube(ends, 0.008, tone, 6)
    if style == 2:
        return blob_part((wide * 1.4, 0.03, 0.03), tone).moved((x, y - 0.015, z + 0.01))
    return box_part((x - wide, y - 0.01, z - 0.002), (x + wide, y + 0.01, z + 0.004), dark(tone))


def fronts(
    rng: Rng, color: Rgb, low: tuple[float, float], high: tuple[float, float], z: float
) -> list[Part]:
    """Return drawers or doors that fill a field (x, y) of a front at z, with their handles."""
    rows, columns = int(rng.integers(1, 6)), int(rng.integers(1, 4))
    gap, style = between(rng, 0.006, 0.02), int(rng.integers(4))
    tone = HANDLES[int(rng.integers(len(HANDLES)))]
    face = color if rng.random() < 0.75 else dark(color, between(rng, 0.75, 1.1))
    inset = rng.random() < 0.4
    parts = []
    step = (np.array(high) - low) / (columns, rows)
    for row in range(rows):
        for column in range(columns):
            start = np.array(low) + step * (column, row) + gap
            end = np.array(low) + step * (column + 1, row + 1) - gap
            parts.append(box_part((*start, z), (*end, z + 0.018), face))
            if inset:
                rim = 0.14 * (end - start)
                parts.append(
                    box_part((*(start + rim), z), (*(end - rim), z + 0.021), dark(face, 0.88))
                )
            x, y = ((start + end) / 2).tolist()
            half = 0.16 * float(end[0] - start[0])
            parts.append(_handle(rng, (x, y, z + 0.02), half, style, tone))
    return parts


def _body(rng: Rng, color: Rgb, high: float = 1.0) -> tuple[list[Part], float]:
    """Return a carcass of width and depth 1 on legs or a plinth, and where its front begins."""
    lift = between(rng, 0.02, 0.18)
    top = between(rng, 0.02, 0.05)
    parts = [
        box_part((-0.5, lift, -0.5), (0.5, high - top, 0.47), color),
        box_part(
            (-0.515, high - top, -0.5), (0.515, high, 0.51), dark(color, between(rng, 0.8, 1))
        ),
    ]
    if rng.random() < 0.5:
        parts.append(box_part((-0.48, 0, -0.48), (0.48, lift, 0.42), dark(color, 0.7)))
    else:
        for x in (-0.44, 0.44):
            for z in (-0.42, 0.4):
                leg = lathe([(0.02, 0), (0.03, lift), (0, lift)], dark(color, 0.8), 8)
                parts.append(leg.moved((x, 0, z)))
    return parts, lift


def _dresser(rng: Rng, color: Rgb) -> list[Part]:
    parts, lift = _body(rng, color)
    return parts + fronts(rng, color, (-0.49, lift + 0.01), (0.49, 0.95), 0.47)


def _stand(rng: Rng, color: Rgb) -> list[Part]:
    """Return a low board or a side table: open compartments beside drawers."""
    lift, board = between(rng, 0.03, 0.25), between(rng, 0.03, 0.06)
    parts = [
        box_part((-0.5, 1 - board, -0.5), (0.5, 1, 0.5), color),
        box_part((-0.5, lift, -0.5), (0.5, lift + board, 0.5), color),
        box_part((-0.5, 0, -0.5), (-0.5 + board, 1, 0.5), color),
        box_part((0.5 - board, 0, -0.5), (0.5, 1, 0.5), color),
        box_part((-0.5, lift, -0.5), (0.5, 1, -0.48), dark(color, 0.8)),
    ]
    split = between(rng, -0.3, 0.3)
    if rng.random() < 0.7:
        parts.append(box_part((split - board / 2, lift, -0.5), (split + board / 2, 1, 0.48), color))
    if rng.random() < 0.8:
        low = between(rng, lift + 0.05, 0.6)
        ends = (-0.48, low), (split if rng.random() < 0.5 else 0.48, 1 - board)
        parts.append(box_part((*ends[0], -0.4), (*ends[1], 0.44), dark(color, 0.9)))
        parts += fronts(rng, color, *ends, 0.45)
    return parts


def _table(rng: Rng, color: Rgb) -> list[Part]:
    """Return a table: a board, round or not, on legs, a pillar, trestles or sides."""
    top, leg = between(rng, 0.03, 0.08), between(rng, 0.025, 0.06)
    under: Rgb = color if rng.random() < 0.7 else accent(rng, color)
    round_ = rng.random() < 0.3
    if round_:
        rows = [(0, 1 - top), (0.48, 1 - top), (0.5, 1 - top / 2), (0.48, 1), (0, 1)]
        parts = [lathe(rows, color, 40)]
    else:
        parts = [box_part((-0.5, 1 - top, -0.5), (0.5, 1, 0.5), color)]
    kind = int(rng.integers(5))
    if kind == 0:
        foot = [(0.32, 0), (0.3, 0.04), (0.06, 0.1), (leg * 2, 0.5), (0.08, 1 - top)]
        return [*parts, lathe(foot, under)]
    if kind == 1:
        for x in (-0.45, 0.42):
            parts.append(box_part((x, 0, -0.46), (x + 0.03, 1 - top, 0.46), under))
        return [*parts, box_part((-0.44, 0.55, -0.44), (0.44, 0.9, -0.41), under)]
    spread = between(rng, 0, 0.1)
    inset = between(rng, 0.2, 0.31) if round_ else between(rng, 0.36, 0.46)
    for x in (-1, 1):
        for z in (-1, 1):
            ends = [
                ((inset + spread) * x, 0, (inset + spread) * z),
                (inset * x, 1 - top, inset * z),
            ]
            middle = np.mean(ends, axis=0)
            parts.append(tube([ends[0], middle, ends[1]], leg, under, 4 if kind == 2 else 10))
    if rng.random() < 0.6:
        rail = 1 - top - between(rng, 0.06, 0.2)
        parts.append(box_part((-inset, rail, -inset), (inset, 1 - top, inset), dark(under, 0.95)))
        if rng.random() < 0.6:
            parts += fronts(rng, under, (-inset, rail), (inset, 1 - top), inset)
    if rng.random() < 0.3:
        parts.append(box_part((-inset, 0.15, -inset), (inset, 0.18, inset), color))
    return parts


def _desk(rng: Rng, color: Rgb) -> list[Part]:
    """Return a desk with drawers below on one side or both."""
    if rng.random() < 0.35:
        return _table(rng, color)
    top = between(rng, 0.03, 0.06)
    parts = [box_part((-0.5, 1 - top, -0.5), (0.5, 1, 0.5), color)]
    wide = between(rng, 0.22, 0.36)
    both = rng.random() < 0.4
    parts.append(box_part((-0.49, 0.02, -0.48), (-0.49 + wide, 1 - top, 0.44), color))
    parts += fronts(rng, color, (-0.485, 0.04), (-0.495 + wide, 1 - top), 0.44)
    if both:
        parts.append(box_part((0.49 - wide, 0.02, -0.48), (0.49, 1 - top, 0.44), color))
        parts += fronts(rng, color, (0.495 - wide, 0.04), (0.485, 1 - top), 0.44)
    else:
        parts.append(box_part((0.44, 0, -0.48), (0.48, 1 - top, 0.46), color))
    parts.append(box_part((-0.48, 0.4, -0.48), (0.48, 1 - top, -0.45), dark(color, 0.9)))
    return parts


def _shelves(rng: Rng, color: Rgb) -> list[Part]:
    """Return shelves: boards between sides or posts, with or without a back, books on some."""
    count, board = int(rng.integers(2, 7)), between(rng, 0.012, 0.03)
    posts = rng.random() < 0.4
    side: Rgb = color if not posts or rng.random() < 0.5 else (0.15, 0.15, 0.16)
    parts = []
    for x in (-0.5, 0.5 - 0.04):
        if posts:
            parts += [box_part((x, 0, z), (x + 0.04, 1, z + 0.06), side) for z in (-0.5, 0.44)]
        else:
            parts.append(box_part((x, 0, -0.5), (x + 0.04, 1, 0.5), side))
    heights = np.linspace(0.02, 1 - board, count + 1)
    for y in heights:
        parts.append(box_part((-0.48, y, -0.48), (0.48, y + board, 0.48), color))
    if rng.random() < 0.5:
        parts.append(box_part((-0.49, 0.02, -0.5), (0.49, 1, -0.48), dark(color, 0.85)))
    if rng.random() < 0.35:
        for y in heights[:-1]:
            x, most = -0.45, between(rng, -0.3, 0.45)
            while x < most:
                thick, tall = between(rng, 0.02, 0.06), between(rng, 0.5, 0.85) / count
                low = (x, y + board, -0.3)
                parts.append(box_part(low, (x + thick, y + board + tall, 0.3), accent(rng, color)))
                x += thick + 0.004
    return parts


def _safe(rng: Rng, color: Rgb) -> list[Part]:
    """Return a safe: a thick door with hinges, a dial or keys, a handle."""
    parts = [blob_part((1, 1, 1), color, squareness=(0.08, 0.08))]
    edge = between(rng, 0.06, 0.14)
    door = box_part(
        (-0.5 + edge, edge, 0.46), (0.5 - edge, 1 - edge, 0.52), dark(color, between(rng, 0.7, 1.2))
    )
    parts.append(door)
    tone = HANDLES[int(rng.integers(2))]
    if rng.random() < 0.5:
        turn = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
        dial = lathe([(0.11, 0), (0.1, 0.06), (0, 0.06)], tone)
        from_ = dial.vertices @ turn.T + np.array([between(rng, -0.1, 0.1), 0.62, 0.52])
        parts.append(moved_to(dial, from_, turn))
    else:
        parts.append(box_part((-0.2, 0.5, 0.5), (0.05, 0.8, 0.535), (0.05, 0.05, 0.05)))
        for k in range(12):
            x, y = -0.18 + 0.075 * (k % 3), 0.54 + 0.06 * (k // 3)
            parts.append(box_part((x, y, 0.5), (x + 0.05, y + 0.04, 0.545), (0.7, 0.7, 0.7)))
    parts.append(tube([(0.2, 0.35, 0.5), (0.2, 0.35, 0.6), (0.2, 0.6, 0.6)], 0.025, tone))
    for y in (0.25, 0.75):
        parts.append(
            box_part((-0.5 + edge * 0.6, y - 0.06, 0.48), (-0.5 + edge, y + 0.06, 0.55), tone)
        )
    return parts


def moved_to(part: Part, vertices: Vectors, turn: Vectors) -> Part:
    normals = (part.normals @ turn.T).astype(np.float32)
    return Part(vertices.astype(np.float32), part.faces, normals, part.uv, part.color)


CABINETS: dict[str, Maker] = {
    "Dresser": _dresser,
    "TVStand": _stand,
    "SideTable": lambda rng, color: (_table, _stand, _dresser)[int(rng.integers(3))](rng, color),
    "CoffeeTable": lambda rng, color: (_table, _table, _stand)[int(rng.integers(3))](rng, color),
    "DiningTable": _table,
    "Desk": _desk,
    "ShelvingUnit": _shelves,
    "Safe": _safe,
}
