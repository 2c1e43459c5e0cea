"""Triangle parts, the pieces that objects are made of, and simple shapes made of them."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Rgb = tuple[float, float, float]
Floats = NDArray[np.float32]


def stable_number(text: str) -> int:
    """Return a number that depends on the text alone (``hash()`` differs between runs)."""
    return int.from_bytes(hashlib.blake2b(text.encode(), digest_size=4).digest(), "big")


@dataclass(frozen=True)
class Part:
    """Triangles of one surface.

    Attributes:
        vertices: float32 (n, 3) metres.
        faces: int32 (m, 3).
        normals: float32 (n, 3), unit length.
        uv: float32 (n, 2) texture coordinates, v up; None without a texture.
        color: albedo 0..1, of a texture's part (1, 1, 1).
        texture: uint8 (h, w, 3), repeated; None for a plain colour.
    """

    vertices: Floats
    faces: NDArray[np.int32]
    normals: Floats
    uv: Floats | None
    color: Rgb
    texture: NDArray[np.uint8] | None = None

    def area_m2(self) -> float:
        a, b, c = (self.vertices[self.faces[:, k]] for k in range(3))
        return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)

    def moved(self, offset_m: ArrayLike) -> Part:
        return replace(self, vertices=self.vertices + np.asarray(offset_m, np.float32))


def bounds(parts: tuple[Part, ...]) -> tuple[Floats, Floats]:
    """Return the corners (low, high) of the parts' axis-aligned box, float32 (3,)."""
    low = np.min([part.vertices.min(axis=0) for part in parts], axis=0)
    high = np.max([part.vertices.max(axis=0) for part in parts], axis=0)
    return low, high


def yaw_matrix(yaw_deg: float) -> NDArray[np.float64]:
    """Return Unity's rotation about y: yaw 90 takes +z to +x."""
    yaw = np.radians(yaw_deg)
    cos, sin = np.cos(yaw), np.sin(yaw)
    return np.array([[cos, 0, sin], [0, 1, 0], [-sin, 0, cos]])


def place(parts: tuple[Part, ...], yaw_deg: float, position_m: ArrayLike) -> tuple[Part, ...]:
    """Return the parts turned about the vertical axis and moved."""
    turn = yaw_matrix(yaw_deg).T
    offset = np.asarray(position_m, np.float64)
    return tuple(
        replace(
            part,
            vertices=(part.vertices @ turn + offset).astype(np.float32),
            normals=(part.normals @ turn).astype(np.float32),
        )
        for part in parts
    )


def unit(vectors: NDArray[Any]) -> NDArray[Any]:
    """Return the vectors with length 1; zero vectors stay zero."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    scaled: NDArray[Any] = vectors / np.maximum(length, 1e-12)
    return scaled


def box_part(
    low_m: ArrayLike,
    high_m: ArrayLike,
    color: Rgb,
    texture: NDArray[np.uint8] | None = None,
    texture_m: float = 1.0,
) -> Part:
    """Return a box; a texture covers ``texture_m`` metres and repeats."""
    low, high = np.asarray(low_m, np.float64), np.asarray(high_m, np.float64)
    vertices: list[NDArray[np.float64]] = []
    normals: list[NDArray[np.float64]] = []
    uv: list[NDArray[np.float64]] = []
    faces: list[tuple[int, int, int]] = []
    for axis in range(3):
        first, second = (other for other in range(3) if other != axis)
        if axis == 0:
            first, second = second, first  # v runs upwards on the walls along z
        for side, corner in ((-1, low), (1, high)):
            base = len(vertices)
            for a, b in ((0, 0), (1, 0), (1, 1), (0, 1)):
                point = np.empty(3)
                point[axis] = corner[axis]
                point[first] = (low, high)[a][first]
                point[second] = (low, high)[b][second]
                vertices.append(point)
                normals.append(np.eye(3)[axis] * side)
                uv.append(point[[first, second]] / texture_m)
            faces += [(base, base + 1, base + 2), (base, base + 2, base + 3)]
    return Part(
        vertices=np.asarray(vertices, np.float32),
        faces=np.asarray(faces, np.int32),
        normals=np.asarray(normals, np.float32),
        uv=np.asarray(uv, np.float32) if texture is not None else None,
        color=color if texture is None else (1.0, 1.0, 1.0),
        texture=texture,
    )


def blob_part(
    size_m: ArrayLike, color: Rgb, *, squareness: tuple[float, float] = (1.0, 1.0), dent: float = 0
) -> Part:
    """Return a superellipsoid standing on the origin: fruit (with a dent), an egg, a pillow.

    Args:
        squareness: exponents in height and in the ground plane; 1 is an ellipsoid.
        dent: depth of the dents at the poles, as a share of half the height.
    """
    size = np.asarray(size_m, np.float64)
    around, up = np.meshgrid(np.linspace(-np.pi, np.pi, 29), np.linspace(-0.5, 0.5, 17) * np.pi)

    def power(value: NDArray[np.float64], exponent: float) -> NDArray[np.float64]:
        result: NDArray[np.float64] = np.sign(value) * np.abs(value) ** exponent
        return result

    ring = power(np.cos(up), squareness[0])
    x, z = ring * power(np.cos(around), squareness[1]), ring * power(np.sin(around), squareness[1])
    y = power(np.sin(up), squareness[0])
    y = y - dent * np.sign(y) * np.exp(-(x**2 + z**2) / 0.08)
    y = (y - y.min()) / (y.max() - y.min())
    vertices = np.stack([x * size[0] / 2, y * size[1], z * size[2] / 2], axis=-1).reshape(-1, 3)
    columns = around.shape[1]
    start = (np.arange(16)[:, None] * columns + np.arange(columns - 1)).ravel()
    quads = start[:, None] + np.array([0, 1, columns + 1, columns])
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    normals = vertex_normals(vertices, faces)
    outward = np.sign((normals * (vertices - [0, size[1] / 2, 0])).sum(1, keepdims=True))
    return Part(
        vertices=vertices.astype(np.float32),
        faces=faces.astype(np.int32),
        normals=(normals * np.where(outward == 0, 1, outward)).astype(np.float32),
        uv=None,
        color=color,
    )


def vertex_normals(vertices: NDArray[Any], faces: NDArray[Any]) -> NDArray[np.float64]:
    """Return area-weighted vertex normals, float64 (n, 3)."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    face = np.cross(b - a, c - a)
    total = np.zeros(vertices.shape, np.float64)
    for k in range(3):
        np.add.at(total, faces[:, k], face)
    return unit(total)
