"""Colour of ray hits: textures, materials, a soft light under the ceiling, ambient light."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from doro_sim_feeder.rooms.lighting import Lighting
from doro_sim_feeder.rooms.parts import unit
from doro_sim_feeder.rooms.raycast import Hits, RayCaster, Soup

SHADOW_BIAS_M = 0.006
LAMP_RADIUS_M = 0.16
SHADE = 0.35
# (strength, exponent) of the highlight of each material.
GLOSS = {
    "metal": (0.45, 24.0),
    "glass": (0.50, 90.0),
    "ceramic": (0.28, 60.0),
    "plastic": (0.16, 30.0),
    "stone": (0.12, 40.0),
    "leather": (0.10, 16.0),
}


@dataclass(frozen=True)
class Atlas:
    """All textures in one flat buffer, so that a pixel's albedo is one lookup."""

    texels: NDArray[np.float32]
    offset: NDArray[np.int64]
    width: NDArray[np.int64]
    height: NDArray[np.int64]
    color: NDArray[np.float32]


def make_atlas(soup: Soup) -> Atlas:
    """Return the textures of a soup's parts; a part without one has a white texel."""
    texels = [np.full((1, 3), 255, np.uint8)]
    rows, start = [], 1
    for part in soup.parts:
        if part.texture is None:
            rows.append((0, 1, 1))
            continue
        height, width = part.texture.shape[:2]
        rows.append((start, width, height))
        texels.append(part.texture.reshape(-1, 3))
        start += width * height
    table = np.asarray(rows, np.int64)
    return Atlas(
        texels=np.concatenate(texels).astype(np.float32) / np.float32(255),
        offset=table[:, 0],
        width=table[:, 1],
        height=table[:, 2],
        color=np.asarray([part.color for part in soup.parts], np.float32),
    )


class Shader:
    """Shades hits of one scene.

    Args:
        caster: the scene's rays.
        part_materials: material of each part of the soup, in its order.
        lighting: the light.
    """

    def __init__(
        self, caster: RayCaster, part_materials: list[str | None], lighting: Lighting
    ) -> None:
        self._caster = caster
        self._atlas = make_atlas(caster.soup)
        gloss = [GLOSS.get(material or "", (0.0, 1.0)) for material in part_materials]
        self._gloss = np.asarray(gloss, np.float32)
        self._wood = np.asarray([material == "wood" for material in part_materials])
        self._fabric = np.asarray([material == "fabric" for material in part_materials])
        self._lighting = lighting

    def shade(
        self, origin_m: NDArray[Any], directions: NDArray[Any], hits: Hits, lamp_angle: float
    ) -> NDArray[np.float32]:
        """Return linear-ish colour 0..1, float32 (n, 3), of rays from one origin.

        Args:
            lamp_angle: where on the round lamp the light of these rays comes from, radians;
                different angles for the samples of a pixel make its shadows soft.
        """
        soup = self._caster.soup
        face = np.maximum(hits.face, 0)
        corners = soup.faces[face]
        weight = np.column_stack([1 - hits.barycentric.sum(axis=1), hits.barycentric])[..., None]
        part = soup.face_part[face]
        distance = np.where(np.isfinite(hits.distance), hits.distance, 0)[:, None]
        point = np.asarray(origin_m, np.float32) + directions * distance
        view = unit(directions)
        flat = _facing(_face_normals(soup.vertices, corners), view)
        normal = unit((soup.normals[corners] * weight).sum(axis=1))
        normal = np.where((normal * flat).sum(axis=1, keepdims=True) < 0, -normal, normal)
        albedo = self._albedo(part, (soup.uv[corners] * weight).sum(axis=1), point)

        use = self._lighting
        lamp = np.asarray(use.lamp_m) + LAMP_RADIUS_M * np.array(
            [np.cos(lamp_angle), 0, np.sin(lamp_angle)]
        )
        to_lamp = lamp.astype(np.float32) - point
        toward = unit(to_lamp)
        facing_lamp = np.clip((normal * toward).sum(axis=1), 0, 1) * shade_of(toward[:, 1])
        shadow = self._caster.occluded(point + flat * SHADOW_BIAS_M, to_lamp)
        lit = np.where(shadow | ((flat * toward).sum(axis=1) <= 0), use.shadow, 1.0)
        head = np.clip(-(normal * view).sum(axis=1), 0, 1)
        even = use.ambient + use.sky * normal[:, 1] + use.side * normal[:, 0] + use.head * head
        even += use.bounce * np.clip(-normal[:, 1], 0, 1)
        light = even[:, None] * np.asarray(use.ambient_color, np.float32)
        light += (use.lamp * facing_lamp * lit)[:, None] * np.asarray(use.lamp_color, np.float32)
        half = np.clip((normal * unit(toward - view)).sum(axis=1), 0, 1)
        strength, exponent = self._gloss[part].T
        shine = half**exponent * (lit > 0.5) * shade_of(toward[:, 1])
        highlight = strength * (shine + 0.25 * (1 - head) ** 4)
        color = np.clip((albedo * light + highlight[:, None]) * use.exposure, 0, 1) ** use.gamma
        return np.where((hits.face >= 0)[:, None], color, 0).astype(np.float32)

    def _albedo(
        self, part: NDArray[np.int32], uv: NDArray[Any], point: NDArray[Any]
    ) -> NDArray[np.float32]:
        atlas = self._atlas
        width, height = atlas.width[part], atlas.height[part]
        column = np.floor((uv[:, 0] % 1) * width).astype(np.int64) % width
        row = np.floor(((1 - uv[:, 1]) % 1) * height).astype(np.int64) % height
        albedo = atlas.texels[atlas.offset[part] + row * width + column] * atlas.color[part]
        tone = np.ones(len(part), np.float32)
        wood = self._wood[part]
        tone[wood] = 1 + (_grain(point[wood]) - 1) * paint_of(albedo[wood])
        fabric = self._fabric[part]
        tone[fabric] = _weave(point[fabric])
        shaded: NDArray[np.float32] = albedo * tone[:, None]
        return shaded


def shade_of(up: NDArray[Any]) -> NDArray[Any]:
    """Return the share of the lamp's light by the height of its direction, (n,) -1..1.

    The lamp has a shade above it: the ceiling gets a third, else a white spot burns there.
    """
    share = np.clip((up + 0.1) / 0.4, 0, 1)
    shade: NDArray[Any] = SHADE + (1 - SHADE) * share * share * (3 - 2 * share)
    return shade


def paint_of(albedo: NDArray[Any]) -> NDArray[Any]:
    """Return how far the grain of wood of a colour (n, 3) is seen: on light paint, little."""
    seen: NDArray[Any] = np.clip(1.3 - 1.2 * albedo.mean(axis=1), 0.2, 1)
    return seen


def _face_normals(vertices: NDArray[Any], corners: NDArray[Any]) -> NDArray[Any]:
    a, b, c = (vertices[corners[:, k]] for k in range(3))
    return unit(np.cross(b - a, c - a))


def _facing(normal: NDArray[Any], view: NDArray[Any]) -> NDArray[Any]:
    """Return normals turned to the viewer: surfaces have two sides, whatever their winding."""
    turned: NDArray[Any] = np.where((normal * view).sum(axis=1, keepdims=True) > 0, -normal, normal)
    return turned


def _grain(point_m: NDArray[Any]) -> NDArray[Any]:
    """Return the brightness of wood: stretched rings in the material, about 1."""
    x, y, z = point_m.T
    ring = 55 * (x + 0.35 * y) + 3 * np.sin(7 * z + 3 * y) + 1.5 * np.sin(19 * z)
    tone: NDArray[Any] = 1 + 0.045 * np.sin(ring) + 0.035 * np.sin(2.7 * ring + 11 * z)
    return tone


def _weave(point_m: NDArray[Any]) -> NDArray[Any]:
    """Return the brightness of woven fabric, about 1."""
    x, y, z = point_m.T
    tone: NDArray[Any] = 1 + 0.07 * np.sin(420 * (x + y)) * np.sin(420 * (z + y))
    return tone
