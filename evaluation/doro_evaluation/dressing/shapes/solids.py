"""Solids that household shapes are made of: lathes, tubes, and what is done to them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from doro_sim_feeder.rooms.parts import Part, Rgb, bounds, unit, vertex_normals

Rng = np.random.Generator
Maker = Callable[[Rng, Rgb], list[Part]]
AROUND = 24
NEUTRAL: tuple[Rgb, ...] = (
    (0.07, 0.07, 0.07), (0.88, 0.88, 0.86), (0.5, 0.5, 0.51), (0.35, 0.2, 0.11), (0.7, 0.7, 0.71),
)  # fmt: skip


def lathe(profile: ArrayLike, color: Rgb, around: int = AROUND) -> Part:
    """Return the surface of (radius, height) points turned about the vertical axis."""
    points = np.asarray(profile, np.float64)
    angle = np.linspace(0, 2 * np.pi, around + 1)
    ring = np.stack([np.cos(angle), np.sin(angle)])
    vertices = np.stack(
        [
            np.outer(points[:, 0], ring[0]),
            np.repeat(points[:, 1:2], around + 1, 1),
            np.outer(points[:, 0], ring[1]),
        ],
        axis=-1,
    ).reshape(-1, 3)
    along = np.linspace(0, 1, len(points))
    uv = np.stack(np.meshgrid(angle / (2 * np.pi), along), axis=-1).reshape(-1, 2)
    return _grid(vertices, len(points), around + 1, color, uv)


def tube(points: ArrayLike, radius: float, color: Rgb, around: int = 8) -> Part:
    """Return a bent pipe along points (n, 3)."""
    path = np.asarray(points, np.float64)
    ahead = unit(np.gradient(path, axis=0))
    aside = np.where(np.abs(ahead[:, 2:]) < 0.9, [[0.0, 0, 1]], [[1.0, 0, 0]])
    first = unit(np.cross(ahead, aside))
    second = np.cross(ahead, first)
    angle = np.linspace(0, 2 * np.pi, around + 1)[None, :, None]
    ring = np.cos(angle) * first[:, None] + np.sin(angle) * second[:, None]
    vertices = (path[:, None] + radius * ring).reshape(-1, 3)
    return _grid(vertices, len(path), around + 1, color, None)


def _grid(
    vertices: NDArray[np.float64],
    rows: int,
    columns: int,
    color: Rgb,
    uv: NDArray[np.float64] | None,
) -> Part:
    start = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    quads = start[:, None] + np.array([0, 1, columns + 1, columns])
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    return Part(
        vertices=vertices.astype(np.float32),
        faces=faces.astype(np.int32),
        normals=vertex_normals(vertices, faces).astype(np.float32),
        uv=None if uv is None else uv.astype(np.float32),
        color=color,
    )


def turned(part: Part, matrix: NDArray[np.float64], offset: ArrayLike = (0, 0, 0)) -> Part:
    """Return a part turned by a matrix (3, 3), then moved."""
    return replace(
        part,
        vertices=(part.vertices @ matrix.T + np.asarray(offset)).astype(np.float32),
        normals=(part.normals @ matrix.T).astype(np.float32),
    )


def about_x(angle: float) -> NDArray[np.float64]:
    """Return the rotation about x by an angle in radians."""
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([[1, 0, 0], [0, cos, -sin], [0, sin, cos]])


def fitted(parts: list[Part], size_m: tuple[float, float, float]) -> tuple[Part, ...]:
    """Return the parts stretched into a size, standing on the origin."""
    low, high = bounds(tuple(parts))
    scale = np.asarray(size_m) / np.maximum(high - low, 1e-6)
    origin = np.array([(low[0] + high[0]) / 2, low[1], (low[2] + high[2]) / 2])
    return tuple(
        replace(
            part,
            vertices=((part.vertices - origin) * scale).astype(np.float32),
            normals=unit(part.normals / scale).astype(np.float32),
        )
        for part in parts
    )


def between(rng: Rng, low: float, high: float) -> float:
    """Return a number drawn from a range."""
    return float(rng.uniform(low, high))


def dark(color: Rgb, share: float = 0.35) -> Rgb:
    """Return a darker tone of a colour."""
    return (color[0] * share, color[1] * share, color[2] * share)


def accent(rng: Rng, color: Rgb) -> Rgb:
    """Return a colour for the lesser parts: a dark tone, a plain one, or any other."""
    kind = rng.random()
    if kind < 0.4:
        return dark(color)
    if kind < 0.75:
        return NEUTRAL[int(rng.integers(len(NEUTRAL)))]
    red, green, blue = (rng.random(3) * 0.8 + 0.1).tolist()
    return (red, green, blue)


def hollow(profile: Sequence[tuple[float, float]], wall: float = 0.06) -> NDArray[np.float64]:
    """Return the closed profile of a vessel: bottom, outside, inside."""
    outer = np.asarray(profile, np.float64)
    inner = outer[::-1].copy()
    inner[:, 0] = np.maximum(inner[:, 0] - wall, 0)
    inner[:, 1] = np.maximum(inner[:, 1], wall)
    return np.vstack([[[0, outer[0, 1]]], outer, inner, [[0, inner[-1, 1]]]])
