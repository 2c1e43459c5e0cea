"""Printed textures: pictures, landscapes behind windows, fabrics, screens. Seeded noise art."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from doro_sim_feeder.rooms.parts import Part

Rng = np.random.Generator
Texture = NDArray[np.uint8]
SIDE_PX = 96


def _colors(rng: Rng, count: int) -> NDArray[np.float64]:
    return rng.uniform(10, 245, (count, 3))


def picture(rng: Rng) -> Texture:
    """Return a picture as it hangs on walls: shapes, strokes, a landscape or smooth colours."""
    draw = rng.random()
    if draw < 0.3:
        return landscape(rng)
    if draw < 0.5:
        coarse = rng.uniform(0, 255, (int(rng.integers(2, 7)), int(rng.integers(2, 7)), 3))
        big = cv2.resize(coarse, (SIDE_PX, SIDE_PX), interpolation=cv2.INTER_CUBIC)
        return np.clip(big, 0, 255).astype(np.uint8)
    image: NDArray[Any] = np.empty((SIDE_PX, SIDE_PX, 3), np.uint8)
    image[:] = _colors(rng, 1)[0]
    for _ in range(int(rng.integers(2, 14))):
        color = _colors(rng, 1)[0].tolist()
        at, size = rng.integers(0, SIDE_PX, 2), rng.integers(4, 40, 2)
        kind = rng.integers(4)
        if kind == 0:
            cv2.rectangle(image, at.tolist(), (at + size).tolist(), color, -1)
        elif kind == 1:
            angle = float(rng.uniform(0, 180))
            cv2.ellipse(image, at.tolist(), size.tolist(), angle, 0, 360, color, -1)
        elif kind == 2:
            points = rng.integers(0, SIDE_PX, (int(rng.integers(3, 6)), 2)).astype(np.int32)
            cv2.fillPoly(image, [points], color)
        else:
            end = rng.integers(0, SIDE_PX, 2)
            cv2.line(image, at.tolist(), end.tolist(), color, int(rng.integers(1, 7)))
    if rng.random() < 0.4:
        image = cv2.GaussianBlur(image, (0, 0), float(rng.uniform(0.5, 3)))
    return image.astype(np.uint8)


def landscape(rng: Rng) -> Texture:
    """Return sky over ground with blobs of green, as seen through a window."""
    rows = np.linspace(0, 1, SIDE_PX)[:, None, None]
    sky = np.array([150, 190, 235]) * rng.uniform(0.75, 1.1) + rows * rng.uniform(-20, 60)
    image = np.broadcast_to(sky, (SIDE_PX, SIDE_PX, 3)).copy()
    horizon = int(SIDE_PX * rng.uniform(0.45, 0.85))
    image[horizon:] = np.array([95, 120, 60]) * rng.uniform(0.6, 1.4)
    for _ in range(int(rng.integers(0, 9))):
        green = (np.array([55, 95, 40]) * rng.uniform(0.4, 1.5)).tolist()
        at = (int(rng.integers(SIDE_PX)), horizon - int(rng.integers(0, 25)))
        size = rng.integers(5, 24, 2).tolist()
        cv2.ellipse(image, at, size, 0, 0, 360, green, -1)
    return np.clip(image + rng.normal(0, 3, image.shape), 0, 255).astype(np.uint8)


def screen(rng: Rng) -> Texture:
    """Return what a screen shows: nothing, windows, or a picture."""
    if rng.random() < 0.45:
        image = np.empty((SIDE_PX, SIDE_PX, 3), np.uint8)
        image[:] = rng.uniform(3, 45)
        return image
    if rng.random() < 0.4:
        return picture(rng)
    image = np.empty((SIDE_PX, SIDE_PX, 3), np.uint8)
    image[:] = _colors(rng, 1)[0]
    for _ in range(int(rng.integers(2, 9))):
        x, y = rng.integers(0, SIDE_PX - 8, 2)
        wide, high = rng.integers(4, 50, 2)
        image[y : y + high, x : x + wide] = _colors(rng, 1)[0]
    return image


def cloth(rng: Rng, rgb: tuple[float, float, float]) -> Texture:
    """Return a fabric of which ``rgb`` is the main colour: plain, stripes, checks, spots."""
    image = np.empty((SIDE_PX, SIDE_PX, 3), np.float64)
    image[:] = np.asarray(rgb) * 255
    other = _colors(rng, 1)[0] if rng.random() < 0.4 else image[0, 0] * rng.uniform(0.5, 1.4)
    step = int(rng.integers(6, 33))
    lines = (np.arange(SIDE_PX) % step) < max(1, int(step * rng.uniform(0.1, 0.35)))
    kind = rng.integers(5)
    if kind == 1:
        image[lines] = other
    elif kind == 2:
        image[lines] = image[lines] * 0.6 + other * 0.4
        image[:, lines] = image[:, lines] * 0.6 + other * 0.4
    elif kind == 3:
        for _ in range(int(rng.integers(4, 20))):
            at = rng.integers(0, SIDE_PX, 2).tolist()
            cv2.circle(image, at, int(rng.integers(2, 10)), other.tolist(), -1)
    image *= 1 + rng.normal(0, rng.uniform(0, 0.1), image.shape[:2])[..., None]
    return np.clip(image, 0, 255).astype(np.uint8)


def covering(rng: Rng) -> Texture:
    """Return a floor, wall or rug: planks, tiles, paper or a pattern around one colour."""
    base = np.clip(rng.uniform(0.25, 0.95) + rng.normal(0, 0.08, 3), 0.05, 0.98)
    red, green, blue = base.tolist()
    return cloth(rng, (red, green, blue))


def mapped(part: Part, texture: Texture, span_m: float) -> Part:
    """Return a part with a texture laid on from the side that each vertex looks to."""
    axis = np.abs(part.normals).argmax(axis=1)
    v = part.vertices
    uv = np.where(
        (axis == 0)[:, None], v[:, [2, 1]], np.where((axis == 1)[:, None], v[:, [0, 2]], v[:, :2])
    )
    uv = (uv / span_m).astype(np.float32)
    return replace(part, uv=uv, texture=texture, color=(1.0, 1.0, 1.0))


def stretched(part: Part, texture: Texture) -> Part:
    """Return a flat part with a texture stretched over it once."""
    low, high = part.vertices.min(axis=0), part.vertices.max(axis=0)
    size = np.maximum(high - low, 1e-6)
    share = (part.vertices - low) / size
    thin = int(size.argmin())
    uv = share[:, [2, 1]] if thin == 0 else share[:, [0, 2]] if thin == 1 else share[:, :2]
    # A texel past the edge would repeat the other side.
    uv = (uv * 0.98 + 0.01).astype(np.float32)
    return replace(part, uv=uv, texture=texture, color=(1.0, 1.0, 1.0))
