"""Televisions, fridges, ovens; toilets and baths."""

from __future__ import annotations

import numpy as np

from doro_evaluation.dressing.looks.prints import screen, stretched
from doro_evaluation.dressing.shapes.cabinets import HANDLES, moved_to
from doro_evaluation.dressing.shapes.solids import (
    Maker,
    Rng,
    accent,
    between,
    dark,
    hollow,
    lathe,
    tube,
)
from doro_sim_feeder.rooms.parts import Part, Rgb, blob_part, box_part

GLASS: Rgb = (0.07, 0.07, 0.08)


def _television(rng: Rng, color: Rgb) -> list[Part]:
    """Return a flat television on feet, on a foot, or for the wall; now and then a deep one."""
    edge = between(rng, 0.015, 0.06)
    shown = box_part((-0.8 + edge, 0.12 + edge, 0.0), (0.8 - edge, 1.02 - edge, 0.034), (1, 1, 1))
    lit = (
        screen(rng)
        if rng.random() < 0.4
        else np.full((4, 4, 3), int(rng.integers(4, 34)), np.uint8)
    )
    parts = [
        box_part((-0.8, 0.12, -0.03), (0.8, 1.02, 0.03), color),
        stretched(shown, np.ascontiguousarray(lit[:, ::-1])),
    ]
    kind = rng.random()
    if kind < 0.4:
        parts.append(lathe([(0.36, 0), (0.34, 0.02), (0.06, 0.03), (0.05, 0.2)], color))
    elif kind < 0.75:
        for x in (-0.5, 0.5):
            parts.append(tube([(x, 0, 0.16), (x, 0.1, 0.02), (x, 0.14, 0)], 0.012, color))
            parts.append(tube([(x, 0, -0.16), (x, 0.1, -0.02), (x, 0.14, 0)], 0.012, color))
    elif kind < 0.85:
        parts.append(
            blob_part((1.3, 0.8, 0.9), color, squareness=(0.4, 0.3)).moved((0, 0.15, -0.45))
        )
    return parts


def _fridge(rng: Rng, color: Rgb) -> list[Part]:
    """Return a fridge with one door, two above each other or two beside."""
    split = between(rng, 0.3, 0.72)
    parts = [box_part((-0.5, 0, -0.5), (0.5, 1, 0.4), dark(color, 0.85))]
    beside = rng.random() < 0.3
    fields = [((-0.5, 0.02), (0.5, split)), ((-0.5, split + 0.008), (0.5, 1))]
    if beside:
        fields = [((-0.5, 0.02), (-0.004, 1)), ((0.004, 0.02), (0.5, 1))]
    elif rng.random() < 0.2:
        fields = [((-0.5, 0.02), (0.5, 1))]
    tone = HANDLES[int(rng.integers(len(HANDLES)))]
    for number, (low, high) in enumerate(fields):
        door = blob_part((high[0] - low[0], high[1] - low[1], 0.14), color, squareness=(0.05, 0.08))
        parts.append(door.moved(((low[0] + high[0]) / 2, low[1], 0.43)))
        x = (low[0] + 0.06) if not beside or number else (high[0] - 0.06)
        ends = low[1] + np.array([0.25, 0.75]) * (high[1] - low[1])
        bar = [(x, ends[0], 0.49), (x, ends[0], 0.54), (x, ends[1], 0.54), (x, ends[1], 0.49)]
        parts.append(tube(bar, 0.014, tone, 6))
    return parts


def _microwave(rng: Rng, color: Rgb) -> list[Part]:
    """Return a microwave oven: window, keys or knobs."""
    side = between(rng, 0.2, 0.32)
    parts = [box_part((-0.85, 0, -0.5), (0.85, 1, 0.45), color)]
    parts.append(box_part((-0.82, 0.06, 0.44), (0.85 - 2 * side, 0.94, 0.48), dark(color, 0.9)))
    parts.append(box_part((-0.72, 0.18, 0.45), (0.75 - 2 * side, 0.82, 0.49), GLASS))
    x = 0.85 - 2 * side
    parts.append(
        tube(
            [(x, 0.15, 0.48), (x, 0.15, 0.56), (x, 0.85, 0.56), (x, 0.85, 0.48)],
            0.03,
            accent(rng, color),
        )
    )
    panel = (0.9 - 2 * side, 0.8)
    parts.append(box_part((panel[0], 0.78, 0.45), (0.8, 0.92, 0.475), (0.04, 0.12, 0.08)))
    for k in range(12):
        at = (panel[0] + (0.8 - panel[0]) * (k % 3) / 3, 0.1 + 0.16 * (k // 3))
        end = (at[0] + (0.8 - panel[0]) * 0.27, at[1] + 0.11)
        parts.append(box_part((*at, 0.45), (*end, 0.47), dark(color, 0.7)))
    return parts


def _toilet(rng: Rng, color: Rgb) -> list[Part]:
    """Return a toilet: bowl, seat, lid up or down, tank."""
    bowl = lathe(
        [(0.24, 0), (0.2, 0.25), (0.3, 0.5), (0.38, 0.62), (0.3, 0.62), (0.15, 0.35)], color
    )
    long = np.array([1.0, 1.0, between(rng, 1.2, 1.45)])
    seat = lathe([(0.26, 0.62), (0.4, 0.62), (0.4, 0.67), (0.26, 0.67)], dark(color, 0.95))
    parts = [moved_to(part, part.vertices * long, np.eye(3)) for part in (bowl, seat)]
    back = -0.4 * float(long[2])
    parts.append(box_part((-0.4, 0.55, back - 0.3), (0.4, between(rng, 1.1, 1.4), back), color))
    if rng.random() < 0.5:
        parts.append(
            blob_part((0.76, 0.8, 0.06), color, squareness=(0.5, 0.3)).moved((0, 0.64, back + 0.06))
        )
    else:
        parts.append(
            blob_part((0.8, 0.05, 0.8 * float(long[2])), color, squareness=(0.3, 0.8)).moved(
                (0, 0.66, 0)
            )
        )
    return parts


def _bathtub(rng: Rng, color: Rgb) -> list[Part]:
    """Return a bath: an oval trough, free or built in."""
    round_ = between(rng, 0.15, 0.8)
    rows = hollow([(between(rng, 0.75, 0.98), 0), (0.95, 0.5), (1, 0.6)], 0.09)
    tub = lathe(rows, color, 40)
    angle = np.arctan2(tub.vertices[:, 2], tub.vertices[:, 0])
    bulge = (np.abs(np.cos(angle)) ** 8 + np.abs(np.sin(angle)) ** 8) ** (-1 / 8)
    wide = 1 + (bulge - 1) * (1 - round_)
    size = np.column_stack([0.5 * wide, np.ones(len(wide)), wide])
    return [moved_to(tub, tub.vertices * size, np.eye(3))]


APPLIANCES: dict[str, Maker] = {
    "Television": _television,
    "Fridge": _fridge,
    "Microwave": _microwave,
    "Toilet": _toilet,
    "Bathtub": _bathtub,
}
