"""Cups, bottles, vases and pots; fruit, bread, rolls."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from doro_evaluation.dressing.shapes.papers import cover
from doro_evaluation.dressing.shapes.solids import (
    AROUND,
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
    shell = lathe(hollow(body, 0.1), color)
    ear = tube(handle, between(rng, 0.09, 0.16), color)
    if rng.random() < 0.3:
        band = lathe([(1.03 + belly, between(rng, 0.3, 0.9)), (1.04 + belly, 1.6)], (1.0, 1.0, 1.0))
        return [shell, ear, replace(band, texture=cover(rng, color))]
    return [shell, ear]


def _bowl(rng: Rng, color: Rgb) -> list[Part]:
    bend, deep = between(rng, 1.4, 2.6), between(rng, 0.7, 1.1)
    rows = [(0.35 + 0.65 * y ** (1 / bend), y * deep) for y in np.linspace(0, 1, 9)]
    return [lathe(hollow(rows, 0.05), color)]


def _plate(rng: Rng, color: Rgb) -> list[Part]:
    """Return a plate: flat or deep, its rim in another colour or with rings."""
    lip, high = between(rng, 0.5, 0.8), between(rng, 0.08, 0.28)
    around = 4 if rng.random() < 0.1 else 40
    under = [(0, 0.02), (lip - 0.06, 0), (lip, 0.03), (1, high)]
    parts = [lathe(under, color, around)]
    rim = color if rng.random() < 0.55 else accent(rng, color)
    parts.append(lathe([(1, high), (1, high + 0.03), (lip, 0.07)], rim, around))
    parts.append(lathe([(lip, 0.07), (0, 0.05)], color, around))
    if rng.random() < 0.3:
        at = between(rng, 0.2, 0.9) * lip
        parts.append(lathe([(at, 0.072), (at - 0.05, 0.072)], accent(rng, color), around))
    return parts


def _bottle(rng: Rng, color: Rgb) -> list[Part]:
    """Return a bottle: long or short neck, waist or none, label and cap or not."""
    neck, tall = between(rng, 0.2, 0.6), between(rng, 3.5, 7.0)
    shoulder = tall * between(rng, 0.4, 0.8)
    slope = (tall - shoulder) * between(rng, 0.15, 0.7)
    waist, foot = between(rng, 0.8, 1.05), between(rng, 0.85, 1.0)
    y = np.linspace(0, 1, 8)
    fall = neck + (1 - neck) * (0.5 + 0.5 * np.cos(np.pi * y)) ** between(rng, 0.6, 1.5)
    rows = [(0, 0), (foot, 0), (foot + 0.02, 0.1), (waist, shoulder * 0.5), (1, shoulder * 0.95)]
    rows += list(zip(fall.tolist(), (shoulder + slope * y).tolist(), strict=True))
    lip = neck + between(rng, 0, 0.1)
    rows += [(neck, tall - 0.3), (lip, tall - 0.25), (lip, tall), (0, tall)]
    around = 4 if rng.random() < 0.08 else AROUND
    parts = [lathe(rows, color, around)]
    if rng.random() < 0.65:
        low = between(rng, 0.08, 0.3) * shoulder
        top = min(low + between(rng, 0.9, 2.4), shoulder * 0.93)
        wide = max(waist, foot) + 0.03
        band = lathe([(wide, low), (wide, top)], (1.0, 1.0, 1.0), around)
        tone = (0.93, 0.91, 0.85) if rng.random() < 0.5 else accent(rng, color)
        parts.append(replace(band, texture=cover(rng, tone)))
    if rng.random() < 0.6:
        cap = [(lip + 0.03, tall - 0.5), (lip + 0.03, tall + 0.05), (0, tall + 0.05)]
        parts.append(lathe(cap, accent(rng, color)))
    return parts


def _spray_bottle(rng: Rng, color: Rgb) -> list[Part]:
    """Return a bottle with a trigger: straight, with a waist, or a cone; perhaps a label."""
    waist, top = between(rng, 0.55, 1.0), between(rng, 0.3, 0.45)
    tall = between(rng, 2.2, 3.2)
    body = [(0, 0), (1, 0), (1, 0.3), (waist, tall * 0.6), (between(rng, 0.6, 1.0), tall * 0.75)]
    parts = [lathe([*body, (top, tall), (top, tall + 0.4)], color)]
    if rng.random() < 0.5:
        band = lathe([(1.03, 0.3), ((1 + waist) / 2 + 0.05, tall * 0.45)], (1.0, 1.0, 1.0))
        parts.append(replace(band, texture=cover(rng, accent(rng, color))))
    head, up, ahead = accent(rng, color), tall + 0.4, between(rng, 0.8, 1.4)
    parts.append(box_part((-0.3, up, -between(rng, 0.3, 0.7)), (0.3, up + 0.55, ahead), head))
    parts.append(lathe([(0.16, 0), (0.12, 0.2)], dark(head), 8).moved((0, up + 0.1, ahead)))
    lean = about_x(-between(rng, 0.0, 0.5))
    trigger = box_part((-0.1, -0.9, 0), (0.1, 0, 0.2), head)
    return [*parts, turned(trigger, lean, (0, up + 0.1, 0.45))]


def _soap_bottle(rng: Rng, color: Rgb) -> list[Part]:
    tall, head = between(rng, 2.0, 3.2), accent(rng, color)
    parts = [lathe([(0, 0), (1, 0), (1, tall * 0.8), (0.4, tall), (0, tall)], color)]
    parts.append(lathe([(0.15, tall), (0.15, tall + 0.8), (0, tall + 0.8)], head))
    parts.append(box_part((-0.2, tall + 0.7, -0.2), (0.2, tall + 0.95, 0.9), head))
    return parts


def _vase(rng: Rng, color: Rgb) -> list[Part]:
    """Return a vase: any smooth line turned, round or with edges, twisted, with a ring or ears."""
    y = np.linspace(0, 1, 18)
    waves = rng.uniform(-0.32, 0.32, 4) @ np.sin(np.outer(np.arange(1, 5) * np.pi, y))
    foot, mouth = between(rng, 0.3, 0.8), between(rng, 0.2, 0.9)
    radius = np.maximum(foot + (mouth - foot) * y + waves + 0.25 * np.sin(np.pi * y), 0.13)
    rows = list(zip(radius.tolist(), (y * between(rng, 1.6, 3.2)).tolist(), strict=True))
    around = int(rng.choice([AROUND, AROUND, AROUND, 40, 6, 8]))
    body = lathe(hollow(rows, 0.05), color, around)
    if rng.random() < 0.15:
        reach, top = rows[-1]
        lid = [(reach * 1.05, top), (reach, top + 0.2), (0.15, top + 0.3), (0.15, top + 0.45)]
        return [body, lathe([*lid, (0, top + 0.5)], color if rng.random() < 0.5 else dark(color))]
    if rng.random() < 0.3:
        tone = accent(rng, color)
        k = int(rng.integers(3, 14))
        ring = [(rows[k][0] + 0.015, rows[k][1]), (rows[k + 2][0] + 0.015, rows[k + 2][1])]
        return [body, lathe(ring, tone, around)]
    if rng.random() < 0.15:
        ears = []
        for side in (-1, 1):
            at = np.linspace(-1.2, 1.2, 9)
            x = side * (float(radius[11]) + 0.35 * np.cos(at) - 0.1)
            up = rows[11][1] + 0.4 * np.sin(at)
            ears.append(tube(np.column_stack([x, up, np.zeros(9)]), 0.07, color))
        return [body, *ears]
    if rng.random() < 0.2:
        points = body.vertices.astype(np.float64)
        angle = np.arctan2(points[:, 2], points[:, 0])
        ribs = 1 + 0.06 * np.sin(int(rng.integers(6, 14)) * angle + points[:, 1])
        points[:, [0, 2]] *= ribs[:, None]
        return [replace(body, vertices=points.astype(np.float32))]
    return [body]


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
    """Return a kettle for the stove, its handle above, or an electric one, its handle beside."""
    other, tall = accent(rng, color), between(rng, 1.2, 2.6)
    belly, top = between(rng, 0.95, 1.15), between(rng, 0.4, 0.8)
    rows = [(0, 0), (1, 0), (belly, tall * 0.3), (top, tall * 0.85), (0.2, tall), (0, tall)]
    parts = [lathe(rows, color), blob_part((0.3, 0.25, 0.3), other).moved((0, tall, 0))]
    spout = [(0.8, tall * 0.4, 0), (1.25, tall * 0.65, 0), (1.45, tall * 0.85, 0)]
    parts.append(tube(spout, between(rng, 0.1, 0.16), color))
    if rng.random() < 0.5:
        angle = np.linspace(0, np.pi, 10)
        up = tall * 0.8 + between(rng, 0.6, 1.1) * np.sin(angle)
        handle = np.column_stack([0.8 * np.cos(angle), up, np.zeros(10)])
    else:
        angle = np.linspace(-1.3, 1.3, 10)
        reach = -0.7 - between(rng, 0.4, 0.7) * np.cos(angle)
        handle = np.column_stack([reach, tall * (0.5 + 0.35 * np.sin(angle)), np.zeros(10)])
        parts.append(lathe([(1.02, 0), (1.02, 0.12), (0.9, 0.14)], other))
    return [*parts, tube(handle, between(rng, 0.06, 0.12), other)]


def _apple(rng: Rng, color: Rgb) -> list[Part]:
    """Return an apple: narrower below, a dent and a stem above, perhaps a leaf."""
    body = blob_part((1, between(rng, 0.85, 1), 1), color, dent=between(rng, 0.15, 0.4))
    points = body.vertices.astype(np.float64)
    points[:, [0, 2]] *= 1 - between(rng, 0.0, 0.3) * (1 - points[:, 1:2])
    body = replace(body, vertices=points.astype(np.float32))
    if rng.random() < 0.3:
        return [body]
    stem = tube([(0, 0.75, 0), (0.03, 0.95, 0.0), (0.08, 1.08, 0)], 0.03, (0.25, 0.15, 0.06), 5)
    if rng.random() < 0.3:
        leaf = blob_part((0.4, 0.03, 0.2), (0.15, 0.4, 0.1)).moved((0.25, 1.0, 0))
        return [body, stem, leaf]
    return [body, stem]


def _bread(rng: Rng, color: Rgb) -> list[Part]:
    square = (between(rng, 0.45, 0.8), between(rng, 0.4, 0.9))
    return [blob_part((1, 0.6, 0.6), color, squareness=square)]


def _candle(rng: Rng, color: Rgb) -> list[Part]:
    wick = lathe([(0.06, 2), (0.06, 2.3), (0, 2.3)], (0.1, 0.1, 0.1))
    return [lathe([(0, 0), (1, 0), (1, between(rng, 1.6, 2)), (0, 1.9)], color), wick]


def _roll(rng: Rng, color: Rgb) -> list[Part]:
    core = between(rng, 0.25, 0.45)
    return [lathe([(core, 0), (1, 0), (1, 2), (core, 2), (core, 0)], color)]


VESSELS: dict[str, Maker] = {
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
    "Apple": _apple,
    "Bread": _bread,
    "Candle": _candle,
    "ToiletPaper": _roll,
    "PaperTowelRoll": _roll,
}
