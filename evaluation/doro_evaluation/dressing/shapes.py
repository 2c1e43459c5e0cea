"""Household things made of lathes, tubes and boxes: more shapes than the mesh library has.

For the training of the captioner only: the rooms of the evaluation have the library's shapes.
Every maker draws its proportions from the generator it is given; :func:`make_shape` fits the
result into the size that the thing has in the room.
"""

from __future__ import annotations

import numpy as np

from doro_evaluation.dressing.furniture import FURNITURE
from doro_evaluation.dressing.solids import (
    AROUND,
    Maker,
    Rng,
    about_x,
    accent,
    between,
    dark,
    fitted,
    hollow,
    lathe,
    tube,
    turned,
)
from doro_sim_feeder.rooms.parts import Part, Rgb, blob_part, box_part


def make_shape(
    object_type: str, size_m: tuple[float, float, float], color: Rgb, rng: Rng
) -> tuple[Part, ...] | None:
    """Return a thing standing on the origin, front to +z; None where the class has no maker."""
    maker = MAKERS.get(object_type)
    return None if maker is None else fitted(maker(rng, color), size_m)


def _cup(rng: Rng, color: Rgb) -> list[Part]:
    if rng.random() < 0.75:
        foot = between(rng, 0.55, 1.0)
        waist = foot + (1 - foot) * 0.3
        return [lathe(hollow([(foot, 0), (waist, 0.6), (1, 2.2)]), color)]
    stem = [(0.55, 0), (0.55, 0.1), (0.12, 0.15), (0.12, 0.9), (0.7, 1.2), (0.95, 1.7)]
    return [lathe(hollow([*stem, (0.85, 2.4)]), color)]


def _mug(rng: Rng, color: Rgb) -> list[Part]:
    foot, belly = between(rng, 0.75, 1.05), between(rng, 0, 0.15)
    body = [(foot * 0.9, 0), (foot, 0.12), ((foot + 1) / 2 + belly, 1.0), (1, 2.0)]
    angle = np.linspace(-1.45, 1.45, 12)
    wide, high = between(rng, 0.45, 0.75), between(rng, 0.5, 0.75)
    handle = np.column_stack(
        [0.95 + wide * np.cos(angle), 1.05 + high * np.sin(angle), np.zeros(12)]
    )
    return [lathe(hollow(body, 0.1), color), tube(handle, between(rng, 0.09, 0.16), color)]


def _bowl(rng: Rng, color: Rgb) -> list[Part]:
    bend, deep = between(rng, 1.4, 2.6), between(rng, 0.7, 1.1)
    rows = [(0.35 + 0.65 * y ** (1 / bend), y * deep) for y in np.linspace(0, 1, 9)]
    return [lathe(hollow(rows, 0.05), color)]


def _plate(rng: Rng, color: Rgb) -> list[Part]:
    lip = between(rng, 0.5, 0.75)
    rim = [(0, 0.02), (lip - 0.06, 0), (lip, 0.03), (1, 0.14), (1, 0.17), (lip, 0.07), (0, 0.05)]
    return [lathe(rim, color)]


def _bottle(rng: Rng, color: Rgb) -> list[Part]:
    neck, shoulder = between(rng, 0.22, 0.5), 6 * between(rng, 0.45, 0.72)
    rows = [(0, 0), (1, 0), (1, shoulder), (neck + 0.15, shoulder + 0.9), (neck, shoulder + 1.3)]
    rows += [(neck, 6.2), (neck + 0.08, 6.25), (neck + 0.08, 6.6), (0, 6.6)]
    parts = [lathe(rows, color)]
    if rng.random() < 0.6:
        low = between(rng, 0.15, 0.3) * 6
        red, green, blue = (rng.random(3) * 0.5 + 0.45).tolist()
        band = [(1.02, low), (1.02, min(low + between(rng, 0.9, 1.8), shoulder))]
        parts.append(lathe(band, (red, green, blue)))
    if rng.random() < 0.5:
        cap = [(neck + 0.12, 6.1), (neck + 0.12, 6.65), (0, 6.65)]
        parts.append(lathe(cap, accent(rng, color)))
    return parts


def _spray_bottle(rng: Rng, color: Rgb) -> list[Part]:
    parts = [lathe([(0, 0), (1, 0), (0.95, 2.4), (0.35, 3.2), (0.3, 3.8)], color)]
    head = accent(rng, color)
    parts.append(box_part((-0.3, 3.8, -0.4), (0.3, 4.3, 1.1), head))
    parts.append(box_part((-0.1, 3.1, 0.5), (0.1, 3.9, 0.75), head))
    return parts


def _soap_bottle(rng: Rng, color: Rgb) -> list[Part]:
    tall, head = between(rng, 2.0, 3.2), accent(rng, color)
    parts = [lathe([(0, 0), (1, 0), (1, tall * 0.8), (0.4, tall), (0, tall)], color)]
    parts.append(lathe([(0.15, tall), (0.15, tall + 0.8), (0, tall + 0.8)], head))
    parts.append(box_part((-0.2, tall + 0.7, -0.2), (0.2, tall + 0.95, 0.9), head))
    return parts


def _vase(rng: Rng, color: Rgb) -> list[Part]:
    y = np.linspace(0, 1, 14)
    swell, wave, beat = between(rng, 0.3, 0.9), between(rng, 0, 0.6), between(rng, 2, 7)
    phase, end = between(rng, 0, 6), between(rng, 0.75, 1.0)
    radius = 0.45 + swell * 0.6 * np.abs(np.sin(np.pi * (y * end + 0.05)))
    radius = np.maximum(radius + wave * 0.25 * np.sin(beat * y + phase), 0.15)
    rows = list(zip(radius.tolist(), (y * 2.4).tolist(), strict=True))
    return [lathe(hollow(rows, 0.05), color, around=6 if rng.random() < 0.2 else AROUND)]


def _pan(rng: Rng, color: Rgb) -> list[Part]:
    body = hollow([(0.85, 0), (1, 0.1), (1.08, between(rng, 0.3, 0.5))], 0.05)
    grip = [(1.0, 0.3, 0), (1.4, 0.42, 0), (2.2, 0.5, 0), (between(rng, 2.4, 3.0), 0.5, 0)]
    return [lathe(body, color), tube(grip, 0.09, accent(rng, color))]


def _pot(rng: Rng, color: Rgb) -> list[Part]:
    high = between(rng, 0.9, 1.5)
    parts = [lathe(hollow([(0.95, 0), (1, 0.1), (1.02, high)], 0.05), color)]
    if rng.random() < 0.5:
        lid = [(1.05, high), (0.6, high + 0.15), (0.1, high + 0.2), (0.1, high + 0.4)]
        parts.append(lathe([*lid, (0, high + 0.4)], dark(color, 0.8)))
    ear, other = np.linspace(-1.3, 1.3, 8), accent(rng, color)
    for side in (-1, 1):
        points = np.column_stack(
            [side * (1 + 0.35 * np.cos(ear)), np.full(8, high * 0.8), 0.4 * np.sin(ear)]
        )
        parts.append(tube(points, 0.07, other))
    return parts


def _kettle(rng: Rng, color: Rgb) -> list[Part]:
    parts = [lathe([(0, 0), (1, 0), (1.05, 0.5), (0.7, 1.5), (0.2, 1.7), (0, 1.9)], color)]
    other = accent(rng, color)
    parts.append(tube([(0.8, 0.7, 0), (1.3, 1.1, 0), (1.5, 1.5, 0)], 0.12, color))
    angle = np.linspace(0, np.pi, 10)
    handle = np.column_stack([0.8 * np.cos(angle), 1.5 + 0.9 * np.sin(angle), np.zeros(10)])
    return [*parts, tube(handle, 0.08, other)]


def _book(rng: Rng, color: Rgb) -> list[Part]:
    page: Rgb = (0.88, 0.86, 0.78)
    parts = [
        box_part((-0.5, 0, -0.5), (0.5, 0.12, 0.5), color),
        box_part((-0.5, 0.88, -0.5), (0.5, 1, 0.5), color),
        box_part((-0.5, 0, -0.5), (-0.47, 1, 0.5), color),
        box_part((-0.48, 0.1, -0.485), (0.485, 0.9, 0.485), page),
    ]
    if rng.random() < 0.7:
        wide, deep = between(rng, 0.1, 0.4), between(rng, 0.1, 0.4)
        label = box_part((-wide, 0.99, -deep), (wide, 1.02, deep), accent(rng, color))
        parts.append(label)
    return parts


def _laptop(rng: Rng, color: Rgb) -> list[Part]:
    parts = [
        box_part((-1, 0, -0.68), (1, 0.06, 0.68), color),
        box_part((-0.88, 0.06, -0.5), (0.88, 0.068, 0.15), (0.08, 0.08, 0.09)),
        box_part((-0.25, 0.06, 0.25), (0.25, 0.066, 0.6), dark(color)),
    ]
    lean, hinge = about_x(-np.radians(between(rng, 5, 35))), (0, 0.06, -0.66)
    lid = box_part((-1, 0, -0.05), (1, 1.36, 0), color)
    dim = between(rng, 0.02, 0.6)
    screen = box_part((-0.93, 0.07, 0), (0.93, 1.29, 0.01), (dim, dim, dim * 1.2))
    return [*parts, turned(lid, lean, hinge), turned(screen, lean, hinge)]


def _remote(rng: Rng, color: Rgb) -> list[Part]:
    parts, other = [box_part((-0.5, 0, -2), (0.5, 0.35, 2), color)], accent(rng, color)
    for column in range(3):
        for row in range(int(rng.integers(4, 9))):
            x, z = -0.38 + 0.28 * column, -1.7 + 0.36 * row
            key: Rgb = other if rng.random() < 0.85 else (0.8, 0.1, 0.1)
            parts.append(box_part((x, 0.35, z), (x + 0.18, 0.42, z + 0.2), key))
    return parts


def _phone(rng: Rng, color: Rgb) -> list[Part]:
    lit = between(rng, 0.02, 0.4)
    screen = box_part((-0.9, 0.95, -1.8), (0.9, 1.02, 1.7), (lit, lit, lit * 1.3))
    return [box_part((-1, 0, -2), (1, 1, 2), color), screen]


def _box(rng: Rng, color: Rgb) -> list[Part]:
    wall, half = 0.03, 0.5
    parts = [
        box_part((-half, 0, -half), (half, wall, half), color),
        box_part((-half, 0, -half), (-half + wall, 1, half), color),
        box_part((half - wall, 0, -half), (half, 1, half), color),
        box_part((-half, 0, -half), (half, 1, -half + wall), color),
        box_part((-half, 0, half - wall), (half, 1, half), color),
    ]
    if rng.random() < 0.4:
        return [*parts, box_part((-half, 0.97, -half), (half, 1, half), dark(color, 0.92))]
    for side in (-1, 1):
        angle = between(rng, 0.1, 0.9)
        cos, sin = np.cos(angle), np.sin(angle)
        turn = np.array([[side * cos, sin * side, 0], [-sin, cos, 0], [0, 0, 1.0]])
        flap = box_part((0, -0.008, -half), (0.42, 0.008, half), dark(color, 0.95))
        parts.append(turned(flap, turn, (side * half, 1, 0)))
    return parts


def _pillow(rng: Rng, color: Rgb) -> list[Part]:
    square = (between(rng, 0.5, 0.9), between(rng, 0.25, 0.6))
    return [blob_part((1, 0.4, 1), color, squareness=square)]


def _apple(rng: Rng, color: Rgb) -> list[Part]:
    body = blob_part((1, 1, 1), color, squareness=(1, 1), dent=between(rng, 0.2, 0.4))
    stem = tube([(0, 0.8, 0), (0.03, 1.0, 0.0), (0.08, 1.1, 0)], 0.04, (0.25, 0.15, 0.06), 5)
    return [body, stem] if rng.random() < 0.6 else [body]


def _bread(rng: Rng, color: Rgb) -> list[Part]:
    square = (between(rng, 0.45, 0.8), between(rng, 0.4, 0.9))
    return [blob_part((1, 0.6, 0.6), color, squareness=square)]


def _clock(rng: Rng, color: Rgb) -> list[Part]:
    other = accent(rng, color)
    if rng.random() < 0.5:
        digits = (rng.random(3) * 0.5 + 0.45).tolist()
        parts = [box_part((-1, 0, -0.5), (1, 1, 0.5), color)]
        parts.append(box_part((-0.85, 0.12, 0.48), (0.85, 0.88, 0.51), (0.03, 0.03, 0.03)))
        for k in range(4):
            x = -0.7 + 0.38 * k
            lit: Rgb = (digits[0], digits[1], digits[2])
            parts.append(box_part((x, 0.25, 0.5), (x + 0.08, 0.75, 0.52), lit))
            parts.append(box_part((x + 0.15, 0.25, 0.5), (x + 0.23, 0.75, 0.52), lit))
        return parts
    face, turn = (0.93, 0.93, 0.9), about_x(np.pi / 2)
    parts = [
        turned(lathe([(0, 0), (1, 0), (1, 0.5), (0.93, 0.55), (0.9, 0.5)], color), turn),
        turned(lathe([(0.92, 0.5), (0, 0.5)], face), turn),
    ]
    parts = [part.moved((0, 1.2, 0)) for part in parts]
    parts.append(box_part((-0.02, 1.2, 0.52), (0.02, 1.85, 0.54), (0.05, 0.05, 0.05)))
    parts.append(box_part((0, 1.18, 0.52), (0.45, 1.22, 0.54), (0.05, 0.05, 0.05)))
    for side in (-0.6, 0.6):
        parts.append(box_part((side - 0.1, 0, 0.1), (side + 0.1, 0.4, 0.3), other))
        if rng.random() < 0.6:
            bell = blob_part((0.7, 0.5, 0.7), other, squareness=(1, 1))
            parts.append(bell.moved((side, 2.1, 0.2)))
    return parts


def _watch(rng: Rng, color: Rgb) -> list[Part]:
    angle = np.linspace(0, 2 * np.pi, 24)
    band = np.column_stack([np.cos(angle), 0.62 * np.sin(angle) + 0.62, np.zeros(24)])
    dial = lathe([(0, 0), (0.5, 0), (0.5, 0.2), (0.45, 0.22)], color)
    glass = lathe([(0.46, 0.2), (0, 0.2)], (0.9, 0.9, 0.88))
    return [tube(band, 0.12, accent(rng, color)), *(p.moved((0, 1.2, 0)) for p in (dial, glass))]


def _statue(rng: Rng, color: Rgb) -> list[Part]:
    parts = [box_part((-0.6, 0, -0.6), (0.6, 0.2, 0.6), dark(color, 0.7))]
    height = 0.2
    for _ in range(int(rng.integers(2, 6))):
        tall = between(rng, 0.4, 1.0)
        size = (between(rng, 0.3, 1.2), tall, between(rng, 0.3, 1.2))
        square = (between(rng, 0.4, 1.4), between(rng, 0.4, 1.4))
        lump = blob_part(size, color, squareness=square)
        aside = (between(rng, -0.25, 0.25), height * 0.95, between(rng, -0.25, 0.25))
        parts.append(lump.moved(aside))
        height += tall * 0.85
    return parts


def _candle(rng: Rng, color: Rgb) -> list[Part]:
    wick = lathe([(0.06, 2), (0.06, 2.3), (0, 2.3)], (0.1, 0.1, 0.1))
    return [lathe([(0, 0), (1, 0), (1, between(rng, 1.6, 2)), (0, 1.9)], color), wick]


def _roll(rng: Rng, color: Rgb) -> list[Part]:
    core = between(rng, 0.25, 0.45)
    return [lathe([(core, 0), (1, 0), (1, 2), (core, 2), (core, 0)], color)]


def _tissue_box(rng: Rng, color: Rgb) -> list[Part]:
    tissue = blob_part((0.5, 0.6, 0.3), (0.95, 0.95, 0.95), squareness=(1.5, 1.2))
    size = between(rng, 0.5, 1.0)
    return [box_part((-1, 0, -0.5), (1, size, 0.5), color), tissue.moved((0, size * 0.8, 0))]


MAKERS: dict[str, Maker] = {
    **FURNITURE,
    "Cup": _cup,
    "Mug": _mug,
    "Bowl": _bowl,
    "Plate": _plate,
    "Bottle": _bottle,
    "WineBottle": _bottle,
    "SprayBottle": _spray_bottle,
    "SoapBottle": _soap_bottle,
    "Vase": _vase,
    "Pan": _pan,
    "Pot": _pot,
    "Kettle": _kettle,
    "Book": _book,
    "Laptop": _laptop,
    "RemoteControl": _remote,
    "CellPhone": _phone,
    "Box": _box,
    "Pillow": _pillow,
    "Apple": _apple,
    "Bread": _bread,
    "AlarmClock": _clock,
    "Watch": _watch,
    "Statue": _statue,
    "Candle": _candle,
    "ToiletPaper": _roll,
    "PaperTowelRoll": _roll,
    "TissueBox": _tissue_box,
}
