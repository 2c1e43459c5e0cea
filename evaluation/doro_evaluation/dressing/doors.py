"""Doors for the training rooms, which have none: what is no mirror, no window and no fridge.

They carry no label, so a detector learns to leave them alone.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from doro_evaluation.dressing.prints import landscape, stretched
from doro_sim_feeder.rooms.footprints import Rect
from doro_sim_feeder.rooms.parts import Part, Rgb, box_part

Rng = np.random.Generator
Vector = NDArray[np.float64]
WIDE_M, HIGH_M, DEEP_M, SHELL_M = (0.65, 1.0), (1.85, 2.15), (0.03, 0.06), 0.03
COLORS: tuple[Rgb, ...] = (
    (0.9, 0.9, 0.89),
    (0.85, 0.82, 0.75),
    (0.35, 0.19, 0.09),
    (0.55, 0.36, 0.2),
    (0.2, 0.2, 0.21),
    (0.6, 0.62, 0.63),
)
HANDLES: tuple[Rgb, ...] = ((0.7, 0.7, 0.72), (0.8, 0.65, 0.3), (0.1, 0.1, 0.1))


def door(room: Rect, rng: Rng) -> tuple[Part, ...]:
    """Return a door at a random place of a wall: frame, leaf, panels or a pane, a handle."""
    axis, far = (0, 2)[int(rng.integers(2))], bool(rng.integers(2))
    along = (room.z_low, room.z_high) if axis == 0 else (room.x_low, room.x_high)
    face = ((room.x_low, room.x_high) if axis == 0 else (room.z_low, room.z_high))[far]
    wide, high, deep = (float(rng.uniform(*span)) for span in (WIDE_M, HIGH_M, DEEP_M))
    at = float(rng.uniform(along[0], max(along[1] - wide, along[0] + 0.01)))
    color, trim = (COLORS[int(rng.integers(len(COLORS)))] for _ in range(2))

    def slab(low: Vector, high: Vector, out_m: float, tone: Rgb) -> Part:
        """Return a box between (along, up) corners that stands ``out_m`` off the wall."""
        start, end = np.zeros(3), np.zeros(3)
        start[2 - axis], start[1] = at + low[0], low[1]
        end[2 - axis], end[1] = at + high[0], high[1]
        start[axis], end[axis] = (face - out_m, face) if far else (face, face + out_m)
        return box_part(start, end, tone)

    size = np.array([wide, high])
    parts = [
        slab(np.zeros(2), size, deep, trim if rng.random() < 0.5 else color),
        slab(np.array([SHELL_M * 2, 0.0]), size - SHELL_M * 2, deep + 0.01, color),
    ]
    rows = int(rng.integers(0, 4))
    for k in range(rows):
        low = np.array([0.16 * wide, high * (0.1 + 0.8 * k / rows)])
        end = np.array([0.84 * wide, high * (0.05 + 0.8 * (k + 1) / rows)])
        darker = (color[0] * 0.85, color[1] * 0.85, color[2] * 0.85)
        panel = slab(low, end, deep + 0.016, darker)
        if k == rows - 1 and rng.random() < 0.3:
            panel = stretched(panel, landscape(rng))
        parts.append(panel)
    side = 0.1 if rng.random() < 0.5 else 0.84
    knob = np.array([side * wide, 0.95])
    tone = HANDLES[int(rng.integers(len(HANDLES)))]
    parts.append(slab(knob, knob + np.array([0.06, 0.04]), deep + 0.06, tone))
    return tuple(parts)
