"""Embree behind a small interface: first hits and occlusion of rays against triangles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from doro_schemas.errors import Refused
from doro_sim_feeder.rooms.parts import Part

FAR = 1e6


@dataclass(frozen=True)
class Soup:
    """All triangles of a scene.

    Attributes:
        vertices, normals: float32 (n, 3), world metres.
        uv: float32 (n, 2), 0 where a part has no texture.
        faces: int32 (m, 3).
        face_part: int32 (m,) index into ``parts``.
        face_instance: int32 (m,) instance id.
    """

    vertices: NDArray[np.float32]
    normals: NDArray[np.float32]
    uv: NDArray[np.float32]
    faces: NDArray[np.int32]
    face_part: NDArray[np.int32]
    face_instance: NDArray[np.int32]
    parts: tuple[Part, ...]


def make_soup(instances: list[tuple[int, tuple[Part, ...]]]) -> Soup:
    """Return the triangles of (instance id, parts) pairs as one mesh."""
    pairs = [(number, part) for number, parts in instances for part in parts]
    counts = [len(part.faces) for _, part in pairs]
    starts = np.cumsum([0, *(len(part.vertices) for _, part in pairs)])
    empty = [
        part.uv if part.uv is not None else np.zeros((len(part.vertices), 2)) for _, part in pairs
    ]
    return Soup(
        vertices=np.concatenate([part.vertices for _, part in pairs]).astype(np.float32),
        normals=np.concatenate([part.normals for _, part in pairs]).astype(np.float32),
        uv=np.concatenate(empty).astype(np.float32),
        faces=np.concatenate(
            [part.faces + start for (_, part), start in zip(pairs, starts[:-1], strict=True)]
        ).astype(np.int32),
        face_part=np.repeat(np.arange(len(pairs), dtype=np.int32), counts),
        face_instance=np.repeat(np.array([number for number, _ in pairs], np.int32), counts),
        parts=tuple(part for _, part in pairs),
    )


@dataclass(frozen=True)
class Hits:
    """First hits of n rays.

    Attributes:
        distance: float32 (n,), in lengths of the ray's direction; inf where nothing is hit.
        face: int32 (n,), -1 where nothing is hit.
        barycentric: float32 (n, 2), weights of the triangle's second and third corner.
    """

    distance: NDArray[np.float32]
    face: NDArray[np.int32]
    barycentric: NDArray[np.float32]


class RayCaster:
    """An Embree scene. Single-threaded and exact: the same rays give the same bits."""

    def __init__(self, soup: Soup) -> None:
        try:
            from embreex import mesh_construction, rtcore_scene  # noqa: PLC0415 - optional extra
        except ImportError as error:
            raise Refused(
                "rendering needs the package embreex: pip install 'doro-sim-feeder[render]'"
            ) from error
        self.soup = soup
        self._scene = rtcore_scene.EmbreeScene(robust=True)
        self._mesh = mesh_construction.TriangleMesh(self._scene, soup.vertices, soup.faces)

    def cast(self, origins: NDArray[Any], directions: NDArray[Any]) -> Hits:
        """Return the first hit of each ray; origins (n, 3) or (3,), directions (n, 3)."""
        directions = np.ascontiguousarray(directions, np.float32)
        origins = np.ascontiguousarray(np.broadcast_to(origins, directions.shape), np.float32)
        far = np.full(len(directions), FAR, np.float32)
        result = self._scene.run(origins, directions, dists=far, output=True)
        face = np.asarray(result["primID"], np.int32)
        distance = np.where(face >= 0, result["tfar"], np.float32(np.inf)).astype(np.float32)
        return Hits(distance, face, np.stack([result["u"], result["v"]], axis=-1))

    def occluded(
        self, origins: NDArray[Any], directions: NDArray[Any], reach: float = 0.98
    ) -> NDArray[np.bool_]:
        """Tell for each ray whether something lies within ``reach`` direction lengths."""
        directions = np.ascontiguousarray(directions, np.float32)
        origins = np.ascontiguousarray(np.broadcast_to(origins, directions.shape), np.float32)
        limit = np.full(len(directions), reach, np.float32)
        hit = self._scene.run(origins, directions, dists=limit, query="OCCLUDED")
        return np.asarray(hit) >= 0
