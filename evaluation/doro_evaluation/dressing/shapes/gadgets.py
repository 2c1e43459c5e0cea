"""Laptops, telephones, remote controls, clocks and watches, with what is printed on them."""

from __future__ import annotations

import cv2
import numpy as np

from doro_evaluation.dressing.looks.prints import Texture, screen, stretched
from doro_evaluation.dressing.shapes.solids import (
    Maker,
    Rng,
    about_x,
    accent,
    between,
    dark,
    lathe,
    tube,
    turned,
)
from doro_sim_feeder.rooms.parts import Part, Rgb, blob_part, box_part

DARK: Rgb = (0.04, 0.04, 0.045)
WHITE: Rgb = (1.0, 1.0, 1.0)
KEYS_PX = (48, 112)


def slab(wide: float, high: float, deep: float, color: Rgb, round_: float = 0.12) -> Part:
    """Return a flat body with round corners, standing on the origin."""
    return blob_part((wide, high, deep), color, squareness=(round_ * 2, round_))


def _keys(rng: Rng, color: Rgb) -> Texture:
    """Return a keyboard from above."""
    key = (np.asarray(dark(color, 0.5) if rng.random() < 0.4 else DARK) * 255).tolist()
    gap = (np.asarray(color) * 235).tolist()
    image = np.empty((*KEYS_PX, 3), np.uint8)
    image[:] = gap
    for row in range(5):
        for column in range(13):
            x, y = 3 + column * 8 + row, 3 + row * 9
            if row == 4 and 3 < column < 8:
                x, wide = 35, 36
            else:
                wide = 6
            cv2.rectangle(image, (x, y), (x + wide, y + 6), key, -1)
    return image


def _laptop(rng: Rng, color: Rgb) -> list[Part]:
    """Return a laptop, open at some angle or closed."""
    thick = between(rng, 0.035, 0.09)
    parts = [slab(2, thick, 1.36, color, 0.06)]
    if rng.random() < 0.2:
        lid = slab(2, thick * 0.8, 1.36, color, 0.06).moved((0, thick * 1.02, 0))
        mark = lathe([(0.1, 0), (0.1, 0.004), (0, 0.004)], _mark(rng, color), 16)
        return [*parts, lid, mark.moved((0, thick * 1.82, 0))]
    keys = box_part((-0.9, thick, -0.52), (0.9, thick + 0.012, 0.12), WHITE)
    pad = box_part((-0.25, thick, 0.25), (0.25, thick + 0.006, 0.6), dark(color, 0.8))
    lean, hinge = about_x(-np.radians(between(rng, -5, 45))), (0, thick, -0.66)
    lid = box_part((-1, 0, -0.05), (1, 1.34, 0), color)
    edge = between(rng, 0.04, 0.12)
    rim = box_part((-0.985, 0.02, 0), (0.985, 1.32, 0.006), DARK if rng.random() < 0.7 else color)
    shown = box_part((-1 + edge, 0.06, 0), (1 - edge, 1.34 - edge, 0.014), WHITE)
    lit = stretched(shown, np.ascontiguousarray(screen(rng)[:, ::-1]))
    parts += [stretched(keys, _keys(rng, color)), pad]
    return [*parts, *(turned(part, lean, hinge) for part in (lid, rim, lit))]


def _mark(rng: Rng, color: Rgb) -> Rgb:
    return dark(color, 0.6) if rng.random() < 0.5 else (0.85, 0.85, 0.85)


def _buttons(rng: Rng, color: Rgb) -> Texture:
    """Return the front of a remote control: many buttons, perhaps a ring and a small window."""
    image = np.empty((160, 48, 3), np.uint8)
    image[:] = (np.asarray(color) * 255).tolist()
    key = (np.asarray(accent(rng, color)) * 255).tolist()
    if max(color) < 0.3 and max(key) < 75:
        key = [185, 185, 185]
    columns, rows = int(rng.integers(2, 5)), int(rng.integers(6, 13))
    ring = int(rng.integers(rows)) if rng.random() < 0.6 else -9
    for row in range(rows):
        y = int(10 + (row + 0.5) * 140 / rows)
        if row in (ring, ring + 1):
            continue
        for column in range(columns):
            x = int(4 + (column + 0.5) * 40 / columns)
            tone = key if rng.random() < 0.88 else rng.uniform(30, 250, 3).tolist()
            if rng.random() < 0.5:
                cv2.circle(image, (x, y), max(2, 14 // columns), tone, -1)
            else:
                cv2.rectangle(
                    image, (x - 12 // columns, y - 3), (x + 12 // columns, y + 3), tone, -1
                )
    if ring >= 0:
        y = int(10 + (ring + 1) * 140 / rows)
        cv2.circle(image, (24, y), 15, key, 4)
        cv2.circle(image, (24, y), 5, key, -1)
    cv2.circle(image, (10, 8), 4, (40, 40, 210), -1)
    return image[..., ::-1].copy()


def _remote(rng: Rng, color: Rgb) -> list[Part]:
    high = between(rng, 0.3, 0.55)
    body = slab(1, high, between(rng, 3.2, 5.0), color, between(rng, 0.08, 0.3))
    low, top = body.vertices.min(axis=0), body.vertices.max(axis=0)
    inset = np.array([0.1, 0, 0.25])
    front = box_part(low + inset + [0, high * 0.8, 0], top - inset + [0, 0.015, 0], WHITE)
    parts = [body, stretched(front, _buttons(rng, color))]
    if rng.random() < 0.4:
        for column in (-0.25, 0.0, 0.25):
            for row in np.linspace(low[2] * 0.7, top[2] * 0.6, int(rng.integers(4, 8))):
                knob = lathe([(0.09, 0), (0.09, 0.1), (0, 0.1)], accent(rng, color), 8)
                parts.append(knob.moved((column, high, float(row))))
    return parts


def _icons(rng: Rng) -> Texture:
    """Return a telephone's screen: dark, or a picture with icons on it."""
    if rng.random() < 0.45:
        return np.full((96, 48, 3), int(rng.integers(4, 40)), np.uint8)
    image = cv2.resize(screen(rng), (48, 96))
    for row in range(int(rng.integers(0, 7))):
        for column in range(4):
            x, y = 4 + column * 11, 8 + row * 13
            tone = rng.uniform(30, 255, 3).tolist()
            cv2.rectangle(image, (x, y), (x + 7, y + 8), tone, -1)
    return np.asarray(image, np.uint8)


def _phone(rng: Rng, color: Rgb) -> list[Part]:
    long, high = between(rng, 1.85, 2.2), between(rng, 0.12, 0.28)
    body = slab(1, high, long, color, between(rng, 0.1, 0.25))
    edge, chin = between(rng, 0.02, 0.08), between(rng, 0.05, 0.3)
    low, top = (-0.5 + edge, high * 0.9, -long / 2 + chin), (0.5 - edge, high + 0.012, long / 2)
    parts = [body]
    if rng.random() < 0.85:
        front = box_part(low, (top[0], top[1], top[2] - chin), WHITE)
        parts.append(stretched(front, _icons(rng)))
        dot = lathe([(0.08, 0), (0.08, 0.015), (0, 0.015)], dark(color, 0.5), 12)
        parts.append(dot.moved((0, high, long / 2 - chin / 2)))
    else:
        lens = box_part((0.2, high * 0.9, -long * 0.44), (0.42, high + 0.03, -long * 0.3), DARK)
        parts.append(lens)
    if rng.random() < 0.2:
        lean = about_x(np.pi / 2 - 0.35)
        parts = [turned(part, lean) for part in parts]
    return parts


def _dial(rng: Rng) -> Texture:
    """Return the face of a clock."""
    pale = rng.random() < 0.75
    image = np.full(
        (96, 96, 3), int(rng.integers(215, 250) if pale else rng.integers(5, 40)), np.uint8
    )
    tone = (20, 20, 20) if pale else (235, 235, 235)
    for k in range(12):
        angle = k * np.pi / 6
        way = np.array([np.sin(angle), -np.cos(angle)])
        start, end = 48 + way * (34 if k % 3 else 29), 48 + way * 41
        cv2.line(
            image, start.astype(int).tolist(), end.astype(int).tolist(), tone, 2 if k % 3 else 4
        )
    for long, thick in ((22, 4), (34, 3)):
        angle = float(rng.uniform(0, 2 * np.pi))
        tip = (int(48 + long * np.sin(angle)), int(48 - long * np.cos(angle)))
        cv2.line(image, (48, 48), tip, tone, thick)
    return image


def _face(texture: Texture, wide: float, at: tuple[float, float, float]) -> Part:
    """Return a round face looking to +z."""
    face = turned(lathe([(wide, 0), (0, 0.001)], WHITE), about_x(np.pi / 2))
    return stretched(face, texture[:, ::-1].copy()).moved(at)


def _digits(rng: Rng) -> Texture:
    """Return the glowing time of a digital clock."""
    image = np.full((48, 112, 3), int(rng.integers(3, 26)), np.uint8)
    glow = [(40, 255, 60), (255, 40, 30), (60, 200, 255), (240, 240, 240)][int(rng.integers(4))]
    text = f"{int(rng.integers(1, 24)):2d}:{int(rng.integers(60)):02d}"
    cv2.putText(image, text, (4, 37), cv2.FONT_HERSHEY_SIMPLEX, 1.2, glow, 4)
    return image


def _round_clock(rng: Rng, color: Rgb) -> list[Part]:
    """Return a round clock: with two bells and feet, or plain."""
    other, deep = accent(rng, color), between(rng, 0.4, 0.8)
    rows = [(0, 0), (0.9, 0), (1, 0.1), (1, deep), (0.92, deep + 0.05), (0.9, deep - 0.03)]
    parts = [
        turned(lathe(rows, color), about_x(np.pi / 2)),
        _face(_dial(rng), 0.92, (0, 0, deep - 0.02)),
    ]
    for side in (-1, 1):
        foot = [(0.5 * side, -0.7, deep / 2), (0.7 * side, -1.2, deep / 2 + 0.1)]
        middle = tuple(np.mean(foot, axis=0).tolist())
        parts.append(tube([foot[0], middle, foot[1]], 0.1, other))
    if rng.random() < 0.65:
        for side in (-1, 1):
            lean = np.array([[0.85, side * 0.5, 0], [-side * 0.5, 0.85, 0], [0, 0, 1.0]])
            bell = blob_part((0.85, 0.5, 0.7), other)
            parts.append(turned(bell, lean, (side * 0.52, 0.85, deep / 2)))
        angle = np.linspace(0, np.pi, 9)
        handle = np.column_stack(
            [0.45 * np.cos(angle), 1.2 + 0.5 * np.sin(angle), np.full(9, deep / 2)]
        )
        parts.append(tube(handle, 0.06, other))
    return parts


def _box_clock(rng: Rng, color: Rgb) -> list[Part]:
    """Return a digital clock, a cube with a dial, a wedge."""
    wide, deep = between(rng, 0.6, 1.3), between(rng, 0.4, 0.9)
    body = slab(2 * wide, 1, deep, color, between(rng, 0.05, 0.3))
    if rng.random() < 0.65:
        front = box_part(
            (-wide * 0.82, 0.15, deep * 0.42), (wide * 0.82, 0.85, deep / 2 + 0.02), WHITE
        )
        parts = [body, stretched(front, _digits(rng)[:, ::-1].copy())]
    else:
        parts = [body, _face(_dial(rng), 0.4, (0, 0.5, deep / 2 + 0.02))]
    if rng.random() < 0.4:
        button = box_part((-wide * 0.5, 0.98, -0.1), (wide * 0.5, 1.08, 0.1), accent(rng, color))
        parts.append(button)
    return parts


def _clock(rng: Rng, color: Rgb) -> list[Part]:
    return (_round_clock if rng.random() < 0.6 else _box_clock)(rng, color)


def _watch(rng: Rng, color: Rgb) -> list[Part]:
    """Return a watch, its band closed in a ring or lying open."""
    other = accent(rng, color)
    case = other if rng.random() < 0.4 else color
    dial = lathe([(0, 0), (0.36, 0), (0.38, 0.1), (0.33, 0.16)], case)
    glass = stretched(lathe([(0.34, 0.15), (0, 0.151)], WHITE), _dial(rng))
    if rng.random() < 0.45:
        band = slab(0.5, 0.1, between(rng, 3, 5), other, 0.1)
        return [band, dial.moved((0, 0.06, 0)), glass.moved((0, 0.06, 0))]
    wide = between(rng, 0.35, 0.6)
    band = lathe([(0.92, 0), (1, 0.06), (1, wide - 0.06), (0.92, wide), (0.9, 0)], other)
    lean = about_x(np.pi / 2)
    parts = [turned(part, lean, (0, wide / 2, 0.96)) for part in (dial, glass)]
    if rng.random() < 0.5:
        return [band, *parts]
    return [turned(part, about_x(-np.pi / 2), (0, 0, 0)) for part in (band, *parts)]


GADGETS: dict[str, Maker] = {
    "Laptop": _laptop,
    "RemoteControl": _remote,
    "CellPhone": _phone,
    "AlarmClock": _clock,
    "Watch": _watch,
}
