"""Wavefront OBJ and MTL: text in, parts out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from doro_sim_feeder.rooms.parts import Part, Rgb, unit, vertex_normals

TextureLoader = Callable[[str], "NDArray[np.uint8] | None"]
Corner = tuple[int, int, int]


@dataclass
class Material:
    """What is used of an MTL material: diffuse colour, opacity, texture file."""

    color: Rgb = (0.75, 0.75, 0.75)
    opacity: float = 1.0
    texture: str = ""


def parse_mtl(text: str) -> dict[str, Material]:
    """Return the materials of an MTL file by name."""
    materials: dict[str, Material] = {}
    current = Material()
    for line in text.splitlines():
        words = line.split()
        if not words:
            continue
        if words[0] == "newmtl":
            current = materials.setdefault(" ".join(words[1:]), Material())
        elif words[0] == "Kd":
            current.color = (float(words[1]), float(words[2]), float(words[3]))
        elif words[0] == "d":
            current.opacity = float(words[-1])
        elif words[0] == "map_Kd":
            current.texture = " ".join(words[1:])
    return materials


class _Reader:
    """Collects vertices and the triangles of each material."""

    def __init__(self) -> None:
        self.points: list[list[float]] = []
        self.uv: list[list[float]] = []
        self.normals: list[list[float]] = []
        self.groups: dict[str, list[Corner]] = {}
        self.libraries: list[str] = []
        self._material = ""

    def line(self, line: str) -> None:
        key, _, rest = line.strip().partition(" ")
        if key == "v":
            self.points.append([float(word) for word in rest.split()[:3]])
        elif key == "vt":
            self.uv.append([float(word) for word in rest.split()[:2]])
        elif key == "vn":
            self.normals.append([float(word) for word in rest.split()[:3]])
        elif key == "usemtl":
            self._material = rest.strip()
        elif key == "mtllib":
            self.libraries.append(rest.strip())
        elif key == "f":
            corners = [self._corner(word) for word in rest.split()]
            group = self.groups.setdefault(self._material, [])
            for k in range(1, len(corners) - 1):
                group += [corners[0], corners[k], corners[k + 1]]

    def _corner(self, word: str) -> Corner:
        fields = [*word.split("/"), "", ""]
        return (
            _index(fields[0], len(self.points)),
            _index(fields[1], len(self.uv)),
            _index(fields[2], len(self.normals)),
        )


def _index(field: str, count: int) -> int:
    """Return a 0-based index of OBJ's 1-based or negative one; -1 where there is none."""
    if not field:
        return -1
    number = int(field)
    return number - 1 if number > 0 else count + number


def parse_obj(
    text: str, load_library: Callable[[str], str], load_texture: TextureLoader
) -> tuple[Part, ...]:
    """Return one part per material of an OBJ file, in the file's own units and axes."""
    reader = _Reader()
    for line in text.splitlines():
        reader.line(line)
    materials: dict[str, Material] = {}
    for library in reader.libraries:
        materials |= parse_mtl(load_library(library))
    points = np.asarray(reader.points, np.float64)
    uv = np.asarray(reader.uv, np.float64).reshape(-1, 2)
    normals = np.asarray(reader.normals, np.float64).reshape(-1, 3)
    parts = []
    for name, corners in reader.groups.items():
        used, faces = np.unique(np.asarray(corners, np.int64), axis=0, return_inverse=True)
        faces = faces.reshape(-1, 3)
        vertices = points[used[:, 0]]
        has_normals = len(normals) > 0 and bool((used[:, 2] >= 0).all())
        normal = unit(normals[used[:, 2]]) if has_normals else vertex_normals(vertices, faces)
        material = materials.get(name, Material())
        texture = load_texture(material.texture) if material.texture and len(uv) else None
        corner_uv = uv[np.maximum(used[:, 1], 0)].astype(np.float32) if len(uv) else None
        parts.append(
            Part(
                vertices=vertices.astype(np.float32),
                faces=faces.astype(np.int32),
                normals=normal.astype(np.float32),
                uv=corner_uv if texture is not None else None,
                color=_opaque(material) if texture is None else (1.0, 1.0, 1.0),
                texture=texture,
            )
        )
    return tuple(parts)


def _opaque(material: Material) -> Rgb:
    """Return the colour that stands for a see-through material: pale, as clear glass looks."""
    if material.opacity >= 0.95:
        return material.color
    red, green, blue = (0.55 + 0.35 * value for value in material.color)
    return (red, green, blue)
