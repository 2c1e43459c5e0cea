"""Colour of ray hits: textures, materials, a soft light under the ceiling, ambient light."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from doro_sim_feeder.rooms.lighting import Lighting
from doro_sim_feeder.rooms.parts import unit
from doro_sim_feeder.rooms.raycast import Hits, RayCaster, Soup
from doro_sim_feeder.rooms.surfaces import PATTERNS, WOOD, pattern_tone, room_light, surface_rows

SHADOW_BIAS_M = 0.006
LAMP_RADIUS_M = 0.16
SHADE = 0.35


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
        self._surface = surface_rows(part_materials)
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
        shine = half ** self._surface[part, 1] * (lit > 0.5) * shade_of(toward[:, 1])
        shown = self._reflected(part, albedo, light, view, normal)
        shown += (self._surface[part, 0] * (shine + 0.25 * (1 - head) ** 4))[:, None]
        color = np.clip(shown * use.exposure, 0, 1) ** use.gamma
        return np.where((hits.face >= 0)[:, None], color, 0).astype(np.float32)

    def _reflected(
        self,
        part: NDArray[np.int32],
        albedo: NDArray[Any],
        light: NDArray[Any],
        view: NDArray[Any],
        normal: NDArray[Any],
    ) -> NDArray[Any]:
        """Return what a surface scatters, lets through, mirrors and glows, (n, 3)."""
        diffuse, mirror, clear, sheen = self._surface[part, 2:6].T[..., None]
        around = np.asarray(self._lighting.ambient_color, np.float32)
        facing = (normal * view).sum(axis=1, keepdims=True)
        head, tint = np.clip(-facing, 0, 1), np.sqrt(albedo)
        behind = around * room_light(view)[:, None] * (0.35 + 0.65 * albedo)
        shown: NDArray[Any] = albedo * light * diffuse * (1 - clear * head) + behind * clear * head
        image = room_light(view - 2 * facing * normal)[:, None]
        shown += around * mirror * image * np.where(diffuse < 1, tint, 1)
        shown += sheen * (1 - head) ** 2 * light * tint
        return shown

    def _albedo(
        self, part: NDArray[np.int32], uv: NDArray[Any], point: NDArray[Any]
    ) -> NDArray[np.float32]:
        atlas = self._atlas
        width, height = atlas.width[part], atlas.height[part]
        column = np.floor((uv[:, 0] % 1) * width).astype(np.int64) % width
        row = np.floor(((1 - uv[:, 1]) % 1) * height).astype(np.int64) % height
        albedo = atlas.texels[atlas.offset[part] + row * width + column] * atlas.color[part]
        tone = np.ones(len(part), np.float32)
        pattern = self._surface[part, 6]
        for kind in PATTERNS:
            of_kind = pattern == kind
            tone[of_kind] = pattern_tone(kind, point[of_kind])
        wood = pattern == WOOD
        tone[wood] = 1 + (tone[wood] - 1) * paint_of(albedo[wood])
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
    seen: NDArray[Any] = np.clip(1.3 - 1.2 * albedo.mean(axis=1), 0.28, 1)
    return seen


def _face_normals(vertices: NDArray[Any], corners: NDArray[Any]) -> NDArray[Any]:
    a, b, c = (vertices[corners[:, k]] for k in range(3))
    return unit(np.cross(b - a, c - a))


def _facing(normal: NDArray[Any], view: NDArray[Any]) -> NDArray[Any]:
    """Return normals turned to the viewer: surfaces have two sides, whatever their winding."""
    turned: NDArray[Any] = np.where((normal * view).sum(axis=1, keepdims=True) > 0, -normal, normal)
    return turned
