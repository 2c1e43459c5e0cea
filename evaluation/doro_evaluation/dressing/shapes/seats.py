"""Seats, beds and garbage cans in drawn proportions; see :mod:`.shapes`."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

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
from doro_sim_feeder.rooms.parts import Part, Rgb, blob_part, box_part


def _legs(rng: Rng, seat: float, color: Rgb) -> list[Part]:
    """Return what carries a seat of width and depth 1: four legs, straight or not, or a column."""
    kind = rng.random()
    if kind < 0.15:
        parts = [lathe([(0.07, 0.12), (0.06, seat)], color, 12)]
        for angle in np.arange(5) * 2 * np.pi / 5:
            foot = np.array([0.46 * np.cos(angle), 0.04, 0.46 * np.sin(angle)])
            parts.append(tube(np.linspace((0, 0.14, 0), foot, 3), 0.035, color))
            parts.append(blob_part((0.09, 0.09, 0.09), (0.06, 0.06, 0.06)).moved(foot * (1, 0, 1)))
        return parts
    leg, spread = between(rng, 0.02, 0.045), between(rng, 0, 0.1)
    around, parts = int(rng.choice([4, 10])), []
    for x in (-1, 1):
        for z in (-1, 1):
            ends = np.array([[0.4 + spread, 0, 0.4 + spread], [0.42, seat, 0.42]]) * (x, 1, z)
            parts.append(tube(np.linspace(ends[0], ends[1], 3), leg, color, around))
    if rng.random() < 0.5:
        at = between(rng, 0.12, 0.28)
        for side in (-0.42, 0.42):
            bar = np.linspace((side, at, -0.42), (side, at, 0.42), 3)
            parts.append(tube(bar, leg * 0.6, color, 6))
    return parts


def _chair(rng: Rng, color: Rgb) -> list[Part]:
    """Return a chair: its back of a board, slats, rungs, spindles in a bow, or soft."""
    seat, lean = between(rng, 0.42, 0.52), between(rng, 0.0, 0.14)
    legs: Rgb = color if rng.random() < 0.7 else accent(rng, color)
    parts = _legs(rng, seat, legs)
    soft = rng.random() < 0.45
    cushion = accent(rng, color) if rng.random() < 0.3 else color
    board = blob_part((1, 0.1, 1), cushion, squareness=(0.5, between(rng, 0.1, 0.5)))
    plain = box_part((-0.5, seat - 0.04, -0.5), (0.5, seat + 0.01, 0.5), color)
    parts.append(board.moved((0, seat - 0.04, 0)) if soft else plain)
    kind, back = rng.random(), -0.47 - lean
    rail = between(rng, 0.018, 0.035)
    posts = [((x, seat, -0.46), (x, 1.0, back)) for x in (-0.44, 0.44)]
    if kind < 0.25:
        whole = blob_part((0.95, 1 - seat, 0.1), cushion, squareness=(between(rng, 0.1, 0.5), 0.2))
        return [*parts, turned(whole, about_x(-lean), (0, seat + 0.02, -0.45))]
    if kind < 0.45:
        at = np.linspace(0, np.pi, 17)
        bow = np.column_stack(
            [0.46 * np.cos(at), seat + (1 - seat) * np.sin(at), np.full(17, back)]
        )
        bow[:, 2] = -0.46 + (back + 0.46) * np.sin(at)
        parts.append(tube(bow, rail, color))
        for x in np.linspace(-0.34, 0.34, int(rng.integers(3, 8))):
            top = seat + (1 - seat) * np.sqrt(max(1 - (x / 0.46) ** 2, 0))
            parts.append(
                tube(np.linspace((x, seat, -0.45), (x, top, back), 3), rail * 0.6, color, 6)
            )
        return parts
    parts += [tube(np.linspace(low, high, 3), rail * 1.3, color) for low, high in posts]
    if kind < 0.75:
        for y in np.linspace(seat + 0.15, 0.97, int(rng.integers(1, 5))):
            z = -0.46 + (back + 0.46) * (y - seat) / (1 - seat)
            wide = between(rng, 0.04, 0.1)
            parts.append(box_part((-0.44, y - wide, z - 0.02), (0.44, y + 0.02, z + 0.02), color))
        return parts
    for x in np.linspace(-0.34, 0.34, int(rng.integers(2, 7))):
        parts.append(tube(np.linspace((x, seat, -0.46), (x, 0.97, back), 3), rail, color, 4))
    return [*parts, box_part((-0.48, 0.88, back - 0.03), (0.48, 1, back + 0.04), color)]


def _stool(rng: Rng, color: Rgb) -> list[Part]:
    """Return a stool: round or square, hard or soft, on legs or on a foot."""
    legs: Rgb = color if rng.random() < 0.6 else accent(rng, color)
    kind = rng.random()
    seat = lathe([(0, 0.92), (0.5, 0.92), (0.5, 1), (0, 1)], color)
    if kind < 0.35:
        seat = blob_part(
            (1, between(rng, 0.1, 0.2), 1), color, squareness=(0.5, between(rng, 0.2, 1))
        )
        seat = seat.moved((0, 0.9, 0))
    elif kind < 0.55:
        seat = box_part((-0.5, 0.92, -0.4), (0.5, 1, 0.4), color)
    if rng.random() < 0.3:
        return [seat, lathe([(0, 0), (0.45, 0), (0.4, 0.05), (0.06, 0.08), (0.06, 0.95)], legs)]
    ring = [(0.38 * np.cos(a), 0.3, 0.38 * np.sin(a)) for a in np.linspace(0, 2 * np.pi, 17)]
    parts = [seat, tube(ring, 0.02, legs)] if rng.random() < 0.6 else [seat]
    count, thick = int(rng.choice([3, 4, 4])), between(rng, 0.025, 0.05)
    for angle in np.arange(count) * 2 * np.pi / count + np.pi / 4:
        x, z = float(np.cos(angle)), float(np.sin(angle))
        parts.append(tube([(0.45 * x, 0, 0.45 * z), (0.32 * x, 0.95, 0.32 * z)], thick, legs))
    return parts


def _soft(low: Sequence[float], high: Sequence[float], color: Rgb, round_: float) -> Part:
    """Return an upholstered block between two corners."""
    size = np.asarray(high) - low
    middle = (np.asarray(high) + low) / 2
    block = blob_part(size, color, squareness=(round_, round_))
    return block.moved((middle[0], low[1], middle[2]))


def _sofa(rng: Rng, color: Rgb) -> list[Part]:
    """Return a sofa or an armchair: soft blocks, arms square or rolled, seats, cushions, feet."""
    arm, seat, back = between(rng, 0.05, 0.15), between(rng, 0.38, 0.52), between(rng, 0.18, 0.35)
    arm_top, round_ = between(rng, 0.55, 0.85), between(rng, 0.08, 0.4)
    lift = between(rng, 0.0, 0.14)
    soft = color if rng.random() < 0.8 else accent(rng, color)
    parts = [
        box_part((-0.49, lift, -0.48), (0.49, seat * 0.75, 0.47), color),
        _soft((-0.5, lift, -0.5), (0.5, 1, -0.5 + back), color, round_),
    ]
    for side in (-1, 1):
        ends = sorted((side * 0.5, side * (0.5 - arm)))
        parts.append(_soft((ends[0], lift, -0.5), (ends[1], arm_top, 0.5), color, round_))
        if rng.random() < 0.3:
            roll = np.linspace(
                (side * (0.5 - arm / 2), arm_top, -0.48), (side * (0.5 - arm / 2), arm_top, 0.5), 3
            )
            parts.append(tube(roll, arm * 0.65, color, 12))
    count = int(rng.integers(1, 4))
    wide = (1 - 2 * arm) / count
    for k in range(count):
        start = -0.5 + arm + wide * k
        parts.append(
            _soft((start, seat * 0.6, -0.5 + back * 0.8), (start + wide, seat, 0.5), soft, 0.25)
        )
        if rng.random() < 0.7:
            behind = (start + 0.01, seat, -0.5 + back * 0.7)
            parts.append(_soft(behind, (start + wide - 0.01, 0.97, -0.4 + back), soft, 0.35))
    for _ in range(int(rng.integers(0, 3))):
        tone, at = accent(rng, color), between(rng, -0.4 + arm, 0.4 - arm)
        cushion = _soft(
            (at - 0.1, seat, -0.5 + back), (at + 0.1, seat + 0.32, -0.3 + back), tone, 0.6
        )
        parts.append(cushion)
    if lift > 0.03:
        for x in (-0.45, 0.45):
            for z in (-0.42, 0.42):
                parts.append(lathe([(0.015, 0), (0.025, lift)], dark(color), 8).moved((x, 0, z)))
    return parts


def _bed(rng: Rng, color: Rgb) -> list[Part]:
    """Return a bed: frame, boards at head and foot, a mattress, a blanket, pillows."""
    frame: Rgb = accent(rng, (0.5, 0.32, 0.18)) if rng.random() < 0.5 else (0.5, 0.33, 0.19)
    sheet: Rgb = (0.9, 0.9, 0.88) if rng.random() < 0.6 else color
    high = between(rng, 0.4, 0.6)
    parts = [box_part((-0.5, 0.06, -0.48), (0.5, high * 0.65, 0.48), frame)]
    parts.append(_soft((-0.49, high * 0.5, -0.47), (0.49, high, 0.48), sheet, 0.15))
    if rng.random() < 0.7:
        parts.append(box_part((-0.5, 0, -0.5), (0.5, 1, -0.46), frame))
    else:
        for x in np.linspace(-0.48, 0.48, int(rng.integers(4, 12))):
            parts.append(tube(np.linspace((x, 0, -0.48), (x, 0.97, -0.48), 3), 0.012, frame, 6))
        parts.append(tube(np.linspace((-0.5, 0.97, -0.48), (0.5, 0.97, -0.48), 3), 0.02, frame))
    if rng.random() < 0.5:
        parts.append(box_part((-0.5, 0, 0.46), (0.5, between(rng, 0.4, 0.75), 0.5), frame))
    if rng.random() < 0.85:
        start = between(rng, -0.3, 0.15)
        parts.append(_soft((-0.515, high * 0.62, start), (0.515, high * 1.07, 0.485), color, 0.12))
        if rng.random() < 0.5:
            parts.append(
                _soft((-0.515, high, start - 0.08), (0.515, high * 1.1, start + 0.04), sheet, 0.3)
            )
    count = int(rng.integers(0, 3))
    for k in range(count):
        at = (k - (count - 1) / 2) * 0.46
        pillow = _soft((at - 0.2, high * 0.98, -0.44), (at + 0.2, high * 1.25, -0.22), sheet, 0.7)
        parts.append(pillow)
    return parts


def _garbage_can(rng: Rng, color: Rgb) -> list[Part]:
    foot = between(rng, 0.7, 1.0)
    parts = [lathe(hollow([(foot, 0), (1, 2.4)], 0.05), color, around=int(rng.choice([4, 24])))]
    if rng.random() < 0.4:
        parts.append(lathe([(1.03, 2.4), (0.9, 2.7), (0, 2.8)], dark(color, 0.7)))
    return parts


SEATS: dict[str, Maker] = {
    "Chair": _chair,
    "Stool": _stool,
    "Sofa": _sofa,
    "ArmChair": _sofa,
    "Bed": _bed,
    "GarbageCan": _garbage_can,
}
