"""Small things that are taught as things without a name: plain boxes would teach wrongly."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from doro_evaluation.dressing.looks.prints import cloth, stretched
from doro_evaluation.dressing.shapes.papers import cover
from doro_evaluation.dressing.shapes.solids import (
    Maker,
    Rng,
    about_x,
    accent,
    between,
    dark,
    hollow,
    lathe,
    tube,
    turned,
)
from doro_sim_feeder.rooms.parts import Part, Rgb, blob_part, box_part, vertex_normals

LYING: NDArray[Any] = about_x(np.pi / 2)


def _pen(rng: Rng, color: Rgb) -> list[Part]:
    """Return a pen or a pencil that lies along z."""
    tip = accent(rng, color)
    parts = [lathe([(0, 0), (0.5, 0), (0.5, 8), (0, 8)], color, int(rng.choice([6, 16])))]
    parts.append(lathe([(0.5, 8), (0.1, 9.2), (0, 9.2)], tip, 12))
    if rng.random() < 0.5:
        parts.append(box_part((0.4, 0.2, -0.1), (0.65, 3, 0.1), tip))
    return [turned(part, LYING) for part in parts]


def _disc(rng: Rng, color: Rgb) -> list[Part]:
    """Return a disc in its case, or without."""
    disc = lathe([(0.15, 0.03), (1, 0.03), (1, 0.05), (0.15, 0.05)], (0.75, 0.77, 0.8), 32)
    if rng.random() < 0.4:
        return [disc]
    case = box_part((-1.05, 0, -1.05), (1.15, 0.16, 1.05), (1, 1, 1))
    return [stretched(case, cover(rng, color))]


def _card(rng: Rng, color: Rgb) -> list[Part]:
    """Return a card with a stripe and a chip."""
    parts = [blob_part((1.6, 0.03, 1), color, squareness=(0.1, 0.15))]
    parts.append(box_part((-0.8, 0.028, -0.42), (0.8, 0.034, -0.2), dark(color, 0.3)))
    parts.append(box_part((-0.6, 0.028, 0), (-0.35, 0.036, 0.2), (0.8, 0.66, 0.3)))
    return parts if rng.random() < 0.7 else parts[:1]


def _rag(rng: Rng, color: Rgb) -> list[Part]:
    """Return a cloth that lies in folds."""
    side = np.linspace(-1, 1, 13)
    x, z = (grid.ravel() for grid in np.meshgrid(side, side))
    waves = rng.uniform(-4, 4, (4, 3))
    y = sum(np.sin(a * x + b * z + c) for a, b, c in waves) * 0.07
    shrink = 1 - 0.25 * np.abs(np.sin(waves[0, 0] + 2 * x)) * between(rng, 0, 1)
    points = np.column_stack([x * shrink, y - np.min(y) + 0.01, z])
    corner = (np.arange(12)[:, None] * 13 + np.arange(12)).ravel()
    quads = corner[:, None] + np.array([0, 1, 14, 13])
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]).astype(np.int32)
    normals = vertex_normals(points, faces).astype(np.float32)
    uv = np.column_stack([x, z]).astype(np.float32)
    sheet = Part(points.astype(np.float32), faces, normals, uv, (1.0, 1.0, 1.0))
    return [replace(sheet, texture=cloth(rng, color))]


def _bat(rng: Rng, color: Rgb) -> list[Part]:
    knob = between(rng, 0.3, 0.45)
    rows = [(0, 0), (knob, 0), (0.25, 0.4), (0.28, 4), (0.7, 9), (0.75, 12), (0, 12.4)]
    return [lathe(rows, color)]


def _handled(rng: Rng, color: Rgb) -> list[Part]:
    """Return a plunger or a brush: a stick in what it is for."""
    stick = lathe([(0.16, 0), (0.16, between(rng, 4, 7)), (0, 7)], accent(rng, color), 10)
    if rng.random() < 0.5:
        rows = [(1, 0), (0.95, 0.6), (0.4, 1.1), (0.2, 1.4)]
        return [lathe(rows, color), stick.moved((0, 1.2, 0))]
    return [lathe(hollow([(0.8, 0), (0.9, 1.8)], 0.1), color), stick.moved((0, 0.6, 0))]


def _scoop(rng: Rng, color: Rgb) -> list[Part]:
    """Return a spatula or a ladle that lies."""
    grip = tube([(0, 0.25, 0), (0, 0.3, 2), (0, 0.2, between(rng, 3.5, 5))], 0.13, color)
    if rng.random() < 0.5:
        return [grip, box_part((-0.6, 0, -1.4), (0.6, 0.08, 0.1), accent(rng, color))]
    return [grip, lathe(hollow([(0.3, 0), (0.8, 0.5)], 0.06), color).moved((0, 0, -0.7))]


def _soap(rng: Rng, color: Rgb) -> list[Part]:
    square = (between(rng, 0.3, 0.8), between(rng, 0.3, 0.9))
    return [blob_part((1.6, between(rng, 0.4, 0.7), 1), color, squareness=square)]


def _can(rng: Rng, color: Rgb) -> list[Part]:
    """Return a watering can."""
    parts = [lathe([(0, 0), (1, 0), (between(rng, 0.7, 1), 1.6), (0.5, 1.7), (0, 1.7)], color)]
    spout = [(0, 0.4, 0.8), (0, 1.0, 1.5), (0, 1.8, 2.1)]
    rose = turned(lathe([(0.12, 0), (0.35, 0.3), (0, 0.32)], color, 14), about_x(0.6))
    at = np.linspace(-0.4, np.pi * 0.8, 12)
    ear = np.column_stack([np.zeros(12), 1.0 + 0.9 * np.sin(at), -0.7 - 0.7 * np.cos(at)])
    return [*parts, tube(spout, 0.14, color), rose.moved((0, 1.75, 2.05)), tube(ear, 0.1, color)]


def _dumbbell(rng: Rng, color: Rgb) -> list[Part]:
    around, reach = int(rng.choice([6, 24])), between(rng, 0.7, 1.2)
    bar = lathe([(0.16, -reach), (0.16, reach)], (0.6, 0.6, 0.61), 12)
    parts = [turned(bar, LYING)]
    for side in (-1, 1):
        disc = lathe(
            [(0, 0), (0.5, 0), (0.55, 0.1), (0.55, 0.5), (0.5, 0.6), (0, 0.6)], color, around
        )
        start = side * reach - (0.6 if side < 0 else 0)
        parts.append(turned(disc, LYING, (0, 0, start)))
    return parts


def _bag(rng: Rng, color: Rgb) -> list[Part]:
    """Return a full bag, tied above."""
    body = blob_part((1, between(rng, 0.8, 1.1), 0.95), color, squareness=(0.8, 0.9))
    points = body.vertices.astype(np.float64)
    waves = np.sin(7 * points[:, 0] + 9 * points[:, 1]) * np.sin(8 * points[:, 2] + 3)
    points += 0.04 * waves[:, None] * body.normals
    top = float(points[:, 1].max())
    knot = lathe([(0.12, 0), (0.06, 0.1), (0.22, 0.3)], color, 10)
    return [replace(body, vertices=points.astype(np.float32)), knot.moved((0, top - 0.05, 0))]


def _boots(rng: Rng, color: Rgb) -> list[Part]:
    """Return a pair of boots or shoes."""
    parts, high = [], between(rng, 0.3, 2.4)
    for x in (-0.55, 0.55):
        ahead = between(rng, -0.1, 0.2)
        sole = blob_part((0.8, 0.16, 2.2), dark(color), squareness=(0.3, 0.7))
        foot = blob_part((0.75, 0.8, 2.1), color, squareness=(0.8, 0.7))
        shaft = lathe([(0.42, 0.3), (0.42, 0.6 + high), (0.36, 0.6 + high)], color)
        parts += [sole.moved((x, 0, ahead)), foot.moved((x, 0.08, ahead))]
        parts.append(shaft.moved((x, 0.1, ahead - 0.55)))
    return parts


def _cleaner(rng: Rng, color: Rgb) -> list[Part]:
    """Return an upright vacuum cleaner."""
    tall, lean = between(rng, 1.4, 2.4), about_x(-between(rng, 0.1, 0.4))
    head = blob_part((1.2, 0.35, between(rng, 0.5, 0.9)), color, squareness=(0.4, 0.3))
    tank = blob_part(
        (between(rng, 0.4, 0.8), tall, 0.45), accent(rng, color), squareness=(0.3, 0.7)
    )
    body = turned(tank, lean, (0, 0.2, -0.1))
    top = lean @ np.array([0, tall, 0])
    ends = np.array([[0, 0, 0], [0, 1.2, -0.3], [0, 1.6, -0.1]])
    return [head, body, tube(top + ends, 0.07, color)]


def _footstool(rng: Rng, color: Rgb) -> list[Part]:
    seat = blob_part((1, 0.3, 1), color, squareness=(0.4, between(rng, 0.15, 1)))
    parts = [seat.moved((0, 0.65, 0))]
    for x in (-0.36, 0.36):
        for z in (-0.36, 0.36):
            parts.append(lathe([(0.05, 0), (0.07, 0.75)], (0.35, 0.2, 0.1), 8).moved((x, 0, z)))
    return parts


def _foil(rng: Rng, color: Rgb) -> list[Part]:
    """Return a long box of foil with a print."""
    del color
    tone = (between(rng, 0.1, 0.9), between(rng, 0.1, 0.9), between(rng, 0.1, 0.9))
    return [stretched(box_part((-3, 0, -0.5), (3, 1, 0.5), (1, 1, 1)), cover(rng, tone))]


ODDMENTS: dict[str, Maker] = {
    "Pen": _pen,
    "Pencil": _pen,
    "CD": _disc,
    "CreditCard": _card,
    "Cloth": _rag,
    "HandTowel": _rag,
    "BaseballBat": _bat,
    "Plunger": _handled,
    "ScrubBrush": _handled,
    "Spatula": _scoop,
    "Ladle": _scoop,
    "SoapBar": _soap,
    "WateringCan": _can,
    "Dumbbell": _dumbbell,
    "GarbageBag": _bag,
    "Boots": _boots,
    "VacuumCleaner": _cleaner,
    "Footstool": _footstool,
    "AluminumFoil": _foil,
}
