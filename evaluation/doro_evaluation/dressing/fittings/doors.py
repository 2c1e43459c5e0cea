"""Doors for the training rooms, which have none: what is no mirror, no window and no fridge.

They carry no label, so a detector learns to leave them alone. Leaves with panels, plain ones,
and such with many panes, through which one sees a room, are of paint or of wood.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from doro_evaluation.dressing.looks.prints import (
    SIDE_PX,
    Texture,
    landscape,
    mapped,
    picture,
    stretched,
)
from doro_evaluation.dressing.looks.surfaces import near, wood, wood_tone
from doro_evaluation.dressing.shapes.solids import dark
from doro_sim_feeder.rooms.footprints import Rect
from doro_sim_feeder.rooms.parts import Part, Rgb, box_part

Rng = np.random.Generator
Vector = NDArray[np.float64]
WIDE_M, HIGH_M, DEEP_M, SHELL_M = (0.65, 1.0), (1.85, 2.15), (0.03, 0.06), 0.03
WOODEN_SHARE, PANES_SHARE = 0.45, 0.45
COLORS: tuple[Rgb, ...] = (
    (0.9, 0.9, 0.89),
    (0.85, 0.82, 0.75),
    (0.35, 0.19, 0.09),
    (0.55, 0.36, 0.2),
    (0.2, 0.2, 0.21),
    (0.6, 0.62, 0.63),
    (0.5, 0.18, 0.08),
    (0.72, 0.47, 0.2),
)
HANDLES: tuple[Rgb, ...] = ((0.7, 0.7, 0.72), (0.8, 0.65, 0.3), (0.1, 0.1, 0.1))


@dataclass(frozen=True)
class Wall:
    """A place on a wall: its axis, where its face is, from where a door goes along it."""

    axis: int
    far: bool
    face: float
    at: float

    def slab(self, low: Vector, high: Vector, out_m: float, tone: Rgb) -> Part:
        """Return a box between (along, up) corners that stands ``out_m`` off the wall."""
        start, end = np.zeros(3), np.zeros(3)
        start[2 - self.axis], start[1] = self.at + low[0], low[1]
        end[2 - self.axis], end[1] = self.at + high[0], high[1]
        ends = (self.face - out_m, self.face) if self.far else (self.face, self.face + out_m)
        start[self.axis], end[self.axis] = ends
        return box_part(start, end, tone)


def door(room: Rect, rng: Rng) -> tuple[Part, ...]:
    """Return a door at a random place of a wall: frame, leaf, panels or panes, a handle."""
    axis, far = (0, 2)[int(rng.integers(2))], bool(rng.integers(2))
    along = (room.z_low, room.z_high) if axis == 0 else (room.x_low, room.x_high)
    face = ((room.x_low, room.x_high) if axis == 0 else (room.z_low, room.z_high))[far]
    wide, high, deep = (float(rng.uniform(*span)) for span in (WIDE_M, HIGH_M, DEEP_M))
    at = float(rng.uniform(along[0], max(along[1] - wide, along[0] + 0.01)))
    wall = Wall(axis, far, face, at)
    color, trim = (near(COLORS[int(rng.integers(len(COLORS)))], rng, 0.02) for _ in range(2))
    size = np.array([wide, high])
    frame = wall.slab(np.zeros(2), size, deep, trim if rng.random() < 0.5 else color)
    leaf = wall.slab(np.array([SHELL_M * 2, 0.0]), size - SHELL_M * 2, deep + 0.01, color)
    panes: list[Part] = []
    if rng.random() < PANES_SHARE:
        solid, panes = _panes(wall, size, deep, color, rng)
        parts = [frame, leaf, *solid]
    else:
        parts = [frame, leaf, *_panels(wall, size, deep, color, rng)]
    if rng.random() < WOODEN_SHARE:
        grain, span = wood(rng, wood_tone(rng)), float(rng.uniform(0.5, 1.3))
        parts = [_covered(part, grain, span, color) for part in parts]
    side = 0.1 if rng.random() < 0.5 else 0.84
    knob = np.array([side * wide, 0.95])
    tone = HANDLES[int(rng.integers(len(HANDLES)))]
    long = np.array([0.06, 0.04]) if rng.random() < 0.6 else np.array([0.03, 0.16])
    return (*parts, *panes, wall.slab(knob, knob + long, deep + 0.06, tone))


def _covered(part: Part, grain: Texture, span_m: float, color: Rgb) -> Part:
    """Return a part of a door in wood, darker where it was darker than the door's colour."""
    if part.texture is not None:
        return part
    share = min(sum(part.color) / sum(color), 1.0)
    return replace(mapped(part, grain, span_m), color=(share, share, share))


def _panels(wall: Wall, size: Vector, deep: float, color: Rgb, rng: Rng) -> list[Part]:
    """Return raised or sunk panels in rows, one or two in each; the top may be glass."""
    rows, columns = int(rng.integers(0, 5)), int(rng.integers(1, 3))
    share, rim = float(rng.uniform(0.75, 1.1)), float(rng.uniform(0.1, 0.2))
    tone = (min(color[0] * share, 1), min(color[1] * share, 1), min(color[2] * share, 1))
    splits = np.sort(rng.uniform(0.25, 0.75, max(rows - 1, 0)))
    ups = np.concatenate([[0.0], splits, [1.0]]) * 0.86 + 0.08 if rows else np.zeros(0)
    panels = []
    for k in range(rows):
        for column in range(columns):
            left = rim + (1 - 2 * rim) * column / columns + 0.02
            right = rim + (1 - 2 * rim) * (column + 1) / columns - 0.02
            low = np.array([left * size[0], (ups[k] + 0.02) * size[1]])
            end = np.array([right * size[0], (ups[k + 1] - 0.02) * size[1]])
            outer = wall.slab(low, end, deep + 0.014, dark(tone, 0.75))
            inset = np.minimum(0.03, 0.2 * (end - low))
            inner = wall.slab(low + inset, end - inset, deep + 0.02, tone)
            if k == rows - 1 and rng.random() < 0.15:
                inner = stretched(inner, landscape(rng))
            panels += [outer, inner]
    return panels


def _panes(
    wall: Wall, size: Vector, deep: float, color: Rgb, rng: Rng
) -> tuple[list[Part], list[Part]]:
    """Return the bars, and the panes behind them, of a door of glass."""
    rows, columns = int(rng.integers(1, 9)), int(rng.integers(1, 5))
    rim = float(rng.uniform(0.1, 0.2)) * size[0]
    low = np.array([rim, float(rng.choice([rim, 0.4 * size[1]]))])
    high = size - rim
    glass = stretched(wall.slab(low, high, deep + 0.014, (1, 1, 1)), behind(rng))
    bars = []
    thick = float(rng.uniform(0.008, 0.02))
    for axis, count in ((0, columns), (1, rows)):
        for k in range(1, count):
            start, end = low.copy(), high.copy()
            middle = low[axis] + (high[axis] - low[axis]) * k / count
            start[axis], end[axis] = middle - thick, middle + thick
            bars.append(wall.slab(start, end, deep + 0.024, color))
    return bars, [glass]


def behind(rng: Rng) -> Texture:
    """Return what one sees through a door of glass: a dim room, a garden, frosted glass."""
    kind = rng.random()
    if kind < 0.25:
        return landscape(rng)
    image = np.empty((SIDE_PX, SIDE_PX, 3), np.float64)
    image[:] = rng.uniform(70, 200) + rng.normal(0, 10, 3)
    if kind < 0.8:
        floor = int(SIDE_PX * rng.uniform(0.45, 0.8))
        image[floor:] = rng.uniform(20, 230, 3)
        for _ in range(int(rng.integers(1, 5))):
            left, wide = int(rng.integers(SIDE_PX)), int(rng.integers(8, 40))
            top = floor - int(rng.integers(0, 30))
            thing = cv2.resize(picture(rng), (8, 8)).mean(axis=(0, 1))
            image[top : floor + 12, left : left + wide] = thing
    else:
        image += rng.normal(0, 4, image.shape)
    done: Texture = np.clip(image, 0, 255).astype(np.uint8)
    return done
