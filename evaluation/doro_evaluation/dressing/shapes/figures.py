"""Teddy bears and statues: figures put together of balls, pipes and lathes."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

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

BLACK: Rgb = (0.04, 0.03, 0.03)


def ball(middle: ArrayLike, size: ArrayLike, color: Rgb, lean: float = 0.0) -> Part:
    """Return an ellipsoid about a point, of a size (x, y, z), turned about x by radians."""
    size = np.asarray(size, np.float64)
    part = blob_part(size, color).moved((0, -size[1] / 2, 0))
    return turned(part, about_x(lean), middle)


def limb(start: ArrayLike, end: ArrayLike, thick: float, color: Rgb) -> list[Part]:
    """Return an arm or a leg: a pipe with round ends."""
    points = np.linspace(np.asarray(start, np.float64), np.asarray(end, np.float64), 4)
    return [
        tube(points, thick, color, 10),
        ball(points[-1], (2.2 * thick,) * 3, color),
        ball(points[0], (2.1 * thick,) * 3, color),
    ]


def teddy(rng: Rng, color: Rgb) -> list[Part]:
    """Return a teddy bear that sits or stands, arms and legs as they come."""
    wide, head = between(rng, 0.85, 1.2), between(rng, 0.7, 1.0)
    pale = dark(color, 0.7) if rng.random() < 0.3 else _pale(color)
    parts = [ball((0, 0.62, 0), (wide, 1.2, 0.9), color)]
    if rng.random() < 0.5:
        parts.append(ball((0, 0.6, 0.2), (wide * 0.7, 0.85, 0.6), pale))
    top = 1.2 + head * 0.35
    parts.append(ball((0, top, 0.05), (head * 1.08, head * 0.95, head), color))
    parts.append(ball((0, top - 0.1, 0.05 + head * 0.42), (0.42 * head, 0.34 * head, 0.4), pale))
    parts.append(ball((0, top - 0.03, 0.2 + head * 0.46), (0.16, 0.12, 0.12), BLACK))
    ear = between(rng, 0.25, 0.42) * head
    for side in (-1, 1):
        parts.append(ball((side * head * 0.42, top + head * 0.4, 0), (ear, ear, 0.16), color))
        parts.append(
            ball((side * head * 0.42, top + head * 0.4, 0.06), (ear * 0.6, ear * 0.6, 0.1), pale)
        )
        eye = (side * head * 0.2, top + 0.1, head * 0.46)
        parts.append(ball(eye, (0.1, 0.1, 0.07), BLACK))
        out, up, ahead = between(rng, 0.5, 0.8), between(rng, -0.5, 0.35), between(rng, 0.1, 0.5)
        shoulder = (side * wide * 0.38, 1.0, 0.05)
        hand = (side * (wide * 0.38 + out * 0.6), 0.95 + up, ahead)
        parts += limb(shoulder, hand, between(rng, 0.14, 0.2), color)
    legs = between(rng, 0.17, 0.23)
    sits = rng.random() < 0.75
    for side in (-1, 1):
        hip = (side * wide * 0.28, 0.2, 0.1)
        foot = (side * wide * 0.45, 0.15, 0.95) if sits else (side * wide * 0.32, -0.55, 0.05)
        parts += limb(hip, foot, legs, color)
        if sits:
            parts.append(ball((foot[0], 0.17, 1.14), (0.36, 0.4, 0.12), pale))
    if rng.random() < 0.4:
        ribbon = accent(rng, color)
        parts.append(ball((0, 1.17, 0.1), (0.6, 0.14, 0.62), ribbon))
        parts += [ball((s * 0.2, 1.12, 0.45), (0.3, 0.2, 0.1), ribbon) for s in (-1, 1)]
    return parts


def _pale(color: Rgb) -> Rgb:
    red, green, blue = (0.5 * value + 0.42 for value in color)
    return red, green, blue


def _standing(rng: Rng, color: Rgb) -> list[Part]:
    """Return a person: in a robe or on legs, arms anywhere."""
    robe = rng.random() < 0.5
    parts = [ball((0, 2.75, 0), (0.36, 0.46, 0.4), color), lathe(_bulge(rng, 2.45, 2.6), color)]
    shoulders = between(rng, 0.36, 0.5)
    parts.append(ball((0, 2.05, 0), (2 * shoulders, 0.95, 0.45), color))
    if robe:
        hem = between(rng, 0.4, 0.75)
        rows = [(hem, 0), (hem * 0.9, 0.4), (0.34, 1.4), (0.4, 1.9), (0.1, 2.45)]
        parts.append(lathe(rows, color))
    else:
        step = between(rng, -0.4, 0.4)
        for side in (-1, 1):
            parts += limb((side * 0.18, 1.5, 0), (side * 0.22, 0.1, side * step), 0.14, color)
        parts.append(ball((0, 1.5, 0), (0.6, 0.6, 0.42), color))
    for side in (-1, 1):
        elbow = np.array([side * (shoulders + between(rng, 0, 0.35)), between(rng, 1.6, 2.3), 0.1])
        hand = elbow + rng.uniform((-0.3, -0.5, -0.1), (0.3, 0.6, 0.5))
        parts += limb((side * shoulders, 2.3, 0), elbow, 0.11, color)
        parts += limb(elbow, hand, 0.09, color)
    return parts


def _bulge(rng: Rng, low: float, high: float) -> list[tuple[float, float]]:
    return [(between(rng, 0.12, 0.18), low), (0.12, (low + high) / 2), (0.14, high)]


def _bust(rng: Rng, color: Rgb) -> list[Part]:
    """Return head and shoulders on a foot."""
    foot = between(rng, 0.35, 0.6)
    parts = [lathe([(0, 0), (foot, 0), (foot, 0.15), (0.2, 0.3), (0.22, 0.6), (0, 0.6)], color)]
    parts.append(ball((0, 0.95, 0), (between(rng, 1.2, 1.6), 0.85, 0.75), color))
    parts.append(lathe([(0.26, 1.1), (0.2, 1.4), (0.22, 1.6)], color))
    parts.append(ball((0, 1.85, 0.05), (0.6, 0.8, 0.7), color))
    parts.append(ball((0, 1.8, 0.4), (0.12, 0.2, 0.16), color))
    parts.append(ball((0, between(rng, 1.95, 2.05), -0.06), (0.68, 0.66, 0.72), color))
    return parts


def _beast(rng: Rng, color: Rgb) -> list[Part]:
    """Return an animal on four legs: horse, elephant, dog, deer, by its proportions."""
    long, tall, thick = between(rng, 1.2, 2.2), between(rng, 0.5, 1.6), between(rng, 0.5, 1.0)
    leg = between(rng, 0.08, 0.2)
    parts = [ball((0, tall + thick / 2, 0), (thick * 0.8, thick, long), color)]
    for x in (-1, 1):
        for z in (-1, 1):
            foot = (x * thick * 0.28, 0.05, z * long * 0.36 + between(rng, -0.2, 0.2))
            parts += limb((x * thick * 0.25, tall + 0.3, z * long * 0.32), foot, leg, color)
    neck = np.array([0, tall + thick * 0.7 + between(rng, 0.1, 1.0), long * 0.6])
    parts += limb((0, tall + thick * 0.6, long * 0.38), neck, leg * 1.7, color)
    nose, lean = between(rng, 0.4, 0.9), between(rng, 0, 0.6)
    parts.append(ball(neck + np.array([0, 0.05, nose * 0.3]), (0.38, 0.4, nose), color, lean))
    for side in (-1, 1):
        ends = np.array([[side * 0.12, 0.1, 0], [side * 0.2, between(rng, 0.25, 0.8), -0.05]])
        parts.append(tube(neck + ends, between(rng, 0.03, 0.1), color))
    if rng.random() < 0.3:
        bent = np.array([[0, 0, nose * 0.7], [0, -0.5, nose], [0, -0.9, nose * 0.9]])
        parts.append(tube(neck + bent, 0.1, color))
    high = tall + thick * 0.7
    tail = [(0, high, -long * 0.48), (0, (tall + high) / 2, -long * 0.58), (0, tall, -long * 0.62)]
    parts.append(tube(tail, 0.06, color))
    return parts


def _sitter(rng: Rng, color: Rgb) -> list[Part]:
    """Return a cat, an owl, a Buddha or a frog: what sits."""
    wide = between(rng, 0.8, 1.5)
    head = between(rng, 0.5, 0.8)
    parts = [ball((0, 0.6, 0), (wide, 1.3, wide * 0.85), color)]
    parts.append(ball((0, 1.2 + head / 3, 0.1), (head, head * 0.9, head), color))
    for side in (-1, 1):
        ear = (side * head * 0.33, 1.2 + head * 0.8, 0.08)
        pointed = lathe([(0.13, 0), (0, between(rng, 0.15, 0.4))], color, 8)
        parts.append(pointed.moved(ear))
        parts += limb((side * wide * 0.4, 0.9, 0.2), (side * 0.2, 0.1, wide * 0.55), 0.13, color)
        parts.append(ball((side * wide * 0.42, 0.2, 0.25), (0.5, 0.4, 0.8), color))
    return parts


def _bird(rng: Rng, color: Rgb) -> list[Part]:
    """Return a bird on a pole or a foot, wings open or not."""
    parts = [lathe([(0, 0), (0.5, 0), (0.45, 0.1), (0.06, 0.2), (0.06, 0.8)], color)]
    parts.append(ball((0, 1.1, 0), (0.6, 0.65, 1.2), color, between(rng, -0.9, 0.2)))
    parts.append(ball((0, 1.6, 0.5), (0.36, 0.38, 0.4), color))
    parts.append(turned(lathe([(0.1, 0), (0, 0.35)], color, 8), about_x(np.pi / 2), (0, 1.6, 0.65)))
    spread = between(rng, 0.2, 1.5)
    for side in (-1, 1):
        wing = ball((side * (0.25 + spread / 2), 1.25, -0.1), (0.1 + spread, 0.12, 0.7), color)
        parts.append(wing)
    return parts


def _ring(rng: Rng, color: Rgb) -> list[Part]:
    """Return a knot, a ring or a spiral on a foot."""
    at = np.linspace(0, 2 * np.pi, 60)
    turns, wave = int(rng.integers(1, 4)), between(rng, 0, 0.6)
    reach = 0.8 + wave * 0.5 * np.cos(at * (turns + 1))
    path = np.column_stack(
        [reach * np.cos(turns * at), 1.2 + reach * np.sin(turns * at), wave * np.sin(at * 3)]
    )
    foot = box_part((-0.5, 0, -0.35), (0.5, 0.25, 0.35), dark(color, 0.8))
    return [foot, tube(path, between(rng, 0.08, 0.28), color, 10)]


def _stack(rng: Rng, color: Rgb) -> list[Part]:
    """Return lumps on each other: what is meant to be art."""
    parts = [box_part((-0.6, 0, -0.6), (0.6, 0.2, 0.6), dark(color, 0.7))]
    height = 0.2
    for _ in range(int(rng.integers(2, 6))):
        tall = between(rng, 0.4, 1.0)
        size = (between(rng, 0.3, 1.2), tall, between(rng, 0.3, 1.2))
        square = (between(rng, 0.4, 1.4), between(rng, 0.4, 1.4))
        aside = (between(rng, -0.25, 0.25), height * 0.95, between(rng, -0.25, 0.25))
        parts.append(blob_part(size, color, squareness=square).moved(aside))
        height += tall * 0.85
    return parts


def _turned(rng: Rng, color: Rgb) -> list[Part]:
    """Return a turned pillar, a cup of honour, an obelisk or a pyramid."""
    if rng.random() < 0.3:
        rows = [(0.7, 0), (0.7, 0.2), (between(rng, 0.3, 0.6), 0.25), (between(rng, 0, 0.3), 3)]
        return [lathe([*rows, (0, 3.2)], color, around=4)]
    y = np.linspace(0, 1, 20)
    waves = rng.uniform(-0.3, 0.3, 5) @ np.sin(np.outer(np.arange(1, 6) * np.pi, y))
    turned_rows = np.column_stack([np.maximum(0.45 + waves, 0.08), 2.6 * y])
    parts = [lathe(np.vstack([[[0, 0]], turned_rows, [[0, 2.6]]]), color)]
    if rng.random() < 0.5:
        parts.append(ball((0, 2.8, 0), (between(rng, 0.3, 0.8),) * 3, color))
    return parts


def statue(rng: Rng, color: Rgb) -> list[Part]:
    """Return one of many kinds of statues, on a plinth or not."""
    kinds: list[Callable[[Rng, Rgb], list[Part]]] = [
        _standing, _standing, _bust, _beast, _beast, _sitter, _bird, _ring, _stack, _turned,
    ]  # fmt: skip
    parts = kinds[int(rng.integers(len(kinds)))](rng, color)
    if rng.random() < 0.35:
        low: NDArray[np.float32] = np.min([part.vertices.min(axis=0) for part in parts], axis=0)
        high: NDArray[np.float32] = np.max([part.vertices.max(axis=0) for part in parts], axis=0)
        tone = dark(color, between(rng, 0.4, 1.0))
        plinth = box_part((low[0], low[1] - 0.2, low[2]), (high[0], low[1] + 0.03, high[2]), tone)
        parts.append(plinth)
    return parts


FIGURES: dict[str, Maker] = {"TeddyBear": teddy, "Statue": statue}
