"""Textures of large surfaces and of materials: wood, planks, tiles, stone, wallpaper, carpet."""

from __future__ import annotations

import itertools
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from doro_sim_feeder.rooms.parts import Rgb

Rng = np.random.Generator
Texture = NDArray[np.uint8]
Floats = NDArray[np.float64]
SIDE_PX = 160
WOODS: tuple[Rgb, ...] = (
    (0.72, 0.53, 0.33), (0.55, 0.36, 0.2), (0.36, 0.2, 0.1), (0.82, 0.67, 0.46),
    (0.46, 0.27, 0.14), (0.3, 0.13, 0.07), (0.62, 0.4, 0.17), (0.2, 0.13, 0.09),
    (0.5, 0.2, 0.09), (0.65, 0.5, 0.38),
)  # fmt: skip
WALLS: tuple[Rgb, ...] = (
    (0.9, 0.89, 0.86), (0.82, 0.78, 0.68), (0.62, 0.58, 0.5), (0.75, 0.75, 0.76),
    (0.85, 0.72, 0.5), (0.55, 0.62, 0.68), (0.66, 0.72, 0.62), (0.78, 0.62, 0.56),
    (0.22, 0.13, 0.32), (0.45, 0.2, 0.17), (0.2, 0.3, 0.38), (0.93, 0.88, 0.72),
)  # fmt: skip


def near(rgb: Rgb, rng: Rng, spread: float = 0.04) -> Rgb:
    """Return a tone near a colour."""
    moved = np.asarray(rgb) * rng.uniform(0.8, 1.15) + rng.normal(0, spread, 3)
    red, green, blue = np.clip(moved, 0.02, 0.97).tolist()
    return red, green, blue


def wood_tone(rng: Rng) -> Rgb:
    """Return the colour of some wood."""
    return near(WOODS[int(rng.integers(len(WOODS)))], rng, 0.02)


def _smooth(rng: Rng, rows: int, columns: int) -> Floats:
    """Return smooth noise about 0 that repeats at the edges, (SIDE_PX, SIDE_PX)."""
    coarse = rng.normal(0, 1, (rows, columns))
    wrapped = np.pad(coarse, 2, mode="wrap")
    scale = (SIDE_PX * (columns + 4) // columns, SIDE_PX * (rows + 4) // rows)
    large = cv2.resize(wrapped, scale, interpolation=cv2.INTER_CUBIC)
    top, left = 2 * scale[1] // (rows + 4), 2 * scale[0] // (columns + 4)
    return np.asarray(large[top : top + SIDE_PX, left : left + SIDE_PX], np.float64)


def _image(rgb: Rgb, tone: Floats) -> Texture:
    image = np.asarray(rgb) * 255 * tone[..., None]
    return np.clip(image, 0, 255).astype(np.uint8)


def wood(rng: Rng, rgb: Rgb) -> Texture:
    """Return wood with its grain along one axis."""
    strong = float(rng.uniform(0.03, 0.16))
    grain = _smooth(rng, 40, 3) + 0.6 * _smooth(rng, 80, 2) + 0.8 * _smooth(rng, 9, 2)
    tone = 1 + strong * np.clip(grain, -2, 2) / 1.5
    image = _image(rgb, tone)
    return image if rng.random() < 0.5 else np.ascontiguousarray(image.transpose(1, 0, 2))


def planks(rng: Rng, rgb: Rgb) -> Texture:
    """Return a floor of boards of one wood, each in a tone of its own."""
    image = wood(rng, rgb)
    count = int(rng.integers(3, 9))
    edges = np.linspace(0, SIDE_PX, count + 1).astype(int)
    toned: NDArray[Any] = image.astype(np.float64)
    vary, gap = float(rng.uniform(0.02, 0.14)), float(rng.uniform(0.55, 0.95))
    for low, high in itertools.pairwise(edges.tolist()):
        split = int(rng.integers(SIDE_PX))
        toned[:split, low:high] *= 1 + rng.normal(0, vary)
        toned[split:, low:high] *= 1 + rng.normal(0, vary)
        toned[:, low] *= gap
        toned[split, low:high] *= gap
    done: Texture = np.clip(toned, 0, 255).astype(np.uint8)
    return done


def tiles(rng: Rng, rgb: Rgb) -> Texture:
    """Return tiles with joints, of one colour or in two."""
    across, down = (int(n) for n in rng.choice([1, 2, 2, 3, 4, 5], 2))
    tone = 1 + 0.03 * _smooth(rng, 6, 6)
    image: NDArray[Any] = np.asarray(rgb) * 255 * tone[..., None]
    other = np.asarray(near(rgb, rng, 0.15)) * 255
    two = rng.random() < 0.25
    wide, high = SIDE_PX // across, SIDE_PX // down
    joint = np.clip(np.asarray(rgb) * rng.uniform(0.6, 1.25) * 255, 0, 255)
    for row in range(down):
        for column in range(across):
            block = image[row * high : (row + 1) * high, column * wide : (column + 1) * wide]
            block *= 1 + rng.normal(0, 0.03)
            if two and (row + column) % 2:
                block[:] = other
    thick = int(rng.integers(1, 4))
    for k in range(max(across, down)):
        image[k * high % SIDE_PX : k * high % SIDE_PX + thick] = joint
        image[:, k * wide % SIDE_PX : k * wide % SIDE_PX + thick] = joint
    done: Texture = np.clip(image, 0, 255).astype(np.uint8)
    return done


def stone(rng: Rng, rgb: Rgb) -> Texture:
    """Return granite with its grains, or marble with its veins."""
    if rng.random() < 0.6:
        grains = _smooth(rng, 80, 80) + 0.7 * _smooth(rng, 30, 30)
        tone = 1 + float(rng.uniform(0.05, 0.3)) * np.clip(grains, -2, 2)
        return _image(rgb, tone)
    veins = np.abs(_smooth(rng, 5, 5) + 0.3 * _smooth(rng, 14, 14))
    return _image(rgb, 1 - float(rng.uniform(0.1, 0.4)) * np.exp(-veins * 9))


def plaster(rng: Rng, rgb: Rgb) -> Texture:
    """Return a painted wall: nearly even."""
    rough = float(rng.uniform(0, 0.02))
    return _image(rgb, 1 + rough * (_smooth(rng, 60, 60) + _smooth(rng, 5, 5)))


def carpet(rng: Rng, rgb: Rgb) -> Texture:
    """Return a soft, speckled floor."""
    return _image(rgb, 1 + float(rng.uniform(0.03, 0.12)) * rng.normal(0, 1, (SIDE_PX, SIDE_PX)))


def floor(rng: Rng) -> tuple[Texture, float, str]:
    """Return a floor as houses have it: texture, span in metres, material for its shine."""
    kind = rng.random()
    if kind < 0.5:
        return planks(rng, wood_tone(rng)), float(rng.uniform(0.6, 1.6)), _shine(rng)
    if kind < 0.75:
        return (
            tiles(rng, near(WALLS[int(rng.integers(8))], rng)),
            float(rng.uniform(0.5, 1.6)),
            ("ceramic" if rng.random() < 0.6 else _shine(rng)),
        )
    if kind < 0.9:
        return carpet(rng, near(WALLS[int(rng.integers(len(WALLS)))], rng)), 0.5, ""
    bright: Rgb = tuple(rng.uniform(0.1, 0.95, 3).tolist())
    return plaster(rng, bright), 2.0, _shine(rng)


def _shine(rng: Rng) -> str:
    return str(rng.choice(["", "plastic", "ceramic"]))


def wall(rng: Rng) -> tuple[Texture, float, str]:
    """Return a wall as houses have it: texture, span in metres, material for its shine."""
    rgb = near(WALLS[int(rng.integers(len(WALLS)))], rng)
    kind = rng.random()
    if kind < 0.75:
        return plaster(rng, rgb), 2.0, str(rng.choice(["", "", "plastic"]))
    if kind < 0.92:
        return tiles(rng, rgb), float(rng.uniform(0.3, 1.0)), "ceramic"
    return planks(rng, rgb), float(rng.uniform(0.8, 2.0)), ""
