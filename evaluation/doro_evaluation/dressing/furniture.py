"""Furniture, lamps and plants in drawn proportions; see :mod:`perception_shapes`."""

from __future__ import annotations

import numpy as np

from doro_evaluation.dressing.solids import (
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


def _chair(rng: Rng, color: Rgb) -> list[Part]:
    seat, leg = between(rng, 0.42, 0.52), between(rng, 0.025, 0.05)
    parts = [box_part((-0.5, seat - 0.05, -0.5), (0.5, seat, 0.5), color)]
    legs: Rgb = color if rng.random() < 0.6 else accent(rng, color)
    for x in (-0.45, 0.45):
        for z in (-0.45, 0.45):
            parts.append(box_part((x - leg, 0, z - leg), (x + leg, seat, z + leg), legs))
    if rng.random() < 0.5:
        return [*parts, box_part((-0.5, seat + 0.1, -0.5), (0.5, 1, -0.43), color)]
    for x in np.linspace(-0.45, 0.45, int(rng.integers(2, 7))):
        parts.append(box_part((x - leg, seat, -0.5), (x + leg, 1, -0.44), color))
    return [*parts, box_part((-0.5, 0.86, -0.51), (0.5, 1, -0.43), color)]


def _stool(rng: Rng, color: Rgb) -> list[Part]:
    legs: Rgb = color if rng.random() < 0.6 else accent(rng, color)
    seat = lathe([(0, 0.92), (0.5, 0.92), (0.5, 1), (0, 1)], color)
    if rng.random() < 0.3:
        return [seat, lathe([(0, 0), (0.45, 0), (0.4, 0.05), (0.06, 0.08), (0.06, 0.95)], legs)]
    ring = [(0.38 * np.cos(a), 0.3, 0.38 * np.sin(a)) for a in np.linspace(0, 2 * np.pi, 17)]
    parts = [seat, tube(ring, 0.02, legs)]
    for angle in np.arange(4) * np.pi / 2 + np.pi / 4:
        x, z = float(np.cos(angle)), float(np.sin(angle))
        parts.append(tube([(0.45 * x, 0, 0.45 * z), (0.32 * x, 0.95, 0.32 * z)], 0.035, legs))
    return parts


def _sofa(rng: Rng, color: Rgb) -> list[Part]:
    arm, seat, back = between(rng, 0.05, 0.14), between(rng, 0.4, 0.52), between(rng, 0.2, 0.35)
    arm_top = between(rng, 0.6, 0.8)
    soft = dark(color, between(rng, 0.85, 1.0))
    parts = [
        box_part((-0.5, 0.08, -0.5), (0.5, seat * 0.7, 0.5), color),
        box_part((-0.5, 0.08, -0.5), (0.5, 1, -0.5 + back), color),
        box_part((-0.5, 0.08, -0.5), (-0.5 + arm, arm_top, 0.5), color),
        box_part((0.5 - arm, 0.08, -0.5), (0.5, arm_top, 0.5), color),
    ]
    count = int(rng.integers(1, 4))
    wide = (1 - 2 * arm) / count
    for k in range(count):
        cushion = blob_part((wide, seat * 0.4, 1 - back), soft, squareness=(0.4, 0.25))
        parts.append(cushion.moved((-0.5 + arm + wide * (k + 0.5), seat * 0.65, back / 2)))
    for x in (-0.45, 0.45):
        for z in (-0.45, 0.45):
            low, high = (x - 0.02, 0, z - 0.02), (x + 0.02, 0.1, z + 0.02)
            parts.append(box_part(low, high, dark(color)))
    return parts


def _bed(rng: Rng, color: Rgb) -> list[Part]:
    frame: Rgb = accent(rng, (0.5, 0.32, 0.18))
    high = between(rng, 0.45, 0.6)
    mattress = blob_part((0.98, high * 0.6, 0.96), color, squareness=(0.2, 0.15))
    parts = [
        box_part((-0.5, 0.05, -0.5), (0.5, high * 0.6, 0.5), frame),
        box_part((-0.5, 0, -0.5), (0.5, 1, -0.46), frame),
        mattress.moved((0, high * 0.5, 0.01)),
    ]
    if rng.random() < 0.6:
        fold = box_part((-0.5, high * 0.75, -0.1), (0.5, high * 1.12, 0.49), dark(color, 0.85))
        parts.append(fold)
    return parts


def _garbage_can(rng: Rng, color: Rgb) -> list[Part]:
    foot = between(rng, 0.7, 1.0)
    parts = [lathe(hollow([(foot, 0), (1, 2.4)], 0.05), color, around=int(rng.choice([4, 24])))]
    if rng.random() < 0.4:
        parts.append(lathe([(1.03, 2.4), (0.9, 2.7), (0, 2.8)], dark(color, 0.7)))
    return parts


FURNITURE: dict[str, Maker] = {
    "Chair": _chair,
    "Stool": _stool,
    "Sofa": _sofa,
    "ArmChair": _sofa,
    "Bed": _bed,
    "GarbageCan": _garbage_can,
}
