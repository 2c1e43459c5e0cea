"""How materials look: highlights, mirror images of a plain room, patterns; the same for OpenGL.

What an object is made of must be visible, else nobody could learn to tell it: metal mirrors, one
sees through glass, glaze and leather shine, wood has a grain, fabric a weave, stone veins.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

WOOD, FABRIC, STONE, LEATHER = PATTERNS = (1.0, 2.0, 3.0, 4.0)


@dataclass(frozen=True)
class Surface:
    """The look of a material.

    Attributes:
        shine, exponent: strength and sharpness of the lamp's highlight.
        diffuse: share of the light that is scattered, 0..1.
        mirror: share of the room's image that is reflected, in the surface's colour for metal.
        clear: how much of what is behind is seen where one looks straight at it, 0..1.
        sheen: glow of fibres seen from the side.
        pattern: 0 none, or one of WOOD, FABRIC, STONE, LEATHER.
    """

    shine: float = 0.0
    exponent: float = 1.0
    diffuse: float = 1.0
    mirror: float = 0.0
    clear: float = 0.0
    sheen: float = 0.0
    pattern: float = 0.0

    def row(self) -> tuple[float, ...]:
        """Return the seven numbers in the order above."""
        return (
            self.shine,
            self.exponent,
            self.diffuse,
            self.mirror,
            self.clear,
            self.sheen,
            self.pattern,
        )


PLAIN = Surface()
SURFACES = {
    "metal": Surface(shine=0.5, exponent=24.0, diffuse=0.4, mirror=0.8),
    "glass": Surface(shine=0.7, exponent=90.0, mirror=0.12, clear=0.75),
    "ceramic": Surface(shine=0.34, exponent=60.0, mirror=0.06),
    "plastic": Surface(shine=0.16, exponent=30.0),
    "stone": Surface(shine=0.12, exponent=40.0, pattern=STONE),
    "leather": Surface(shine=0.16, exponent=12.0, pattern=LEATHER),
    "wood": Surface(pattern=WOOD),
    "fabric": Surface(sheen=0.35, pattern=FABRIC),
}
FLOOR_LIGHT, CEILING_LIGHT, WINDOW_LIGHT = 0.14, 0.85, 0.9


def surface_rows(part_materials: list[str | None]) -> NDArray[np.float32]:
    """Return the numbers of each part's surface, float32 (parts, 7)."""
    rows = [SURFACES.get(material or "", PLAIN).row() for material in part_materials]
    return np.asarray(rows, np.float32).reshape(-1, 7)


def smooth_step(low: float, high: float, value: NDArray[Any]) -> NDArray[Any]:
    """Return GLSL's smoothstep."""
    share = np.clip((value - low) / (high - low), 0, 1)
    result: NDArray[Any] = share * share * (3 - 2 * share)
    return result


def room_light(direction: NDArray[Any]) -> NDArray[Any]:
    """Return the brightness of a plain room in directions (n, 3): dark floor, light ceiling,
    a window on each side. (n,)
    """
    x, y, z = direction.T
    even = FLOOR_LIGHT + (CEILING_LIGHT - FLOOR_LIGHT) * smooth_step(-0.35, 0.6, y)
    window = smooth_step(0.84, 0.93, np.abs(0.8 * x + 0.6 * z))
    light: NDArray[Any] = even + WINDOW_LIGHT * window * (1 - smooth_step(0.1, 0.45, np.abs(y)))
    return light


def pattern_tone(pattern: float, point_m: NDArray[Any]) -> NDArray[Any]:
    """Return the brightness of a pattern at points (n, 3) of the material, about 1."""
    x, y, z = point_m.T
    if pattern == WOOD:
        ring = 55 * (x + 0.35 * y) + 3 * np.sin(7 * z + 3 * y) + 1.5 * np.sin(19 * z)
        tone = 1 + 0.08 * np.sin(ring) + 0.055 * np.sin(2.7 * ring + 11 * z)
    elif pattern == FABRIC:
        fine = np.sin(420 * (x + y)) * np.sin(420 * (z + y))
        tone = 1 + 0.06 * fine + 0.07 * np.sin(140 * (x + y)) * np.sin(140 * (z - y))
    elif pattern == STONE:
        vein = np.abs(np.sin(17 * (x + 0.7 * y + 0.4 * z) + 2.5 * np.sin(9 * y + 5 * z)))
        speckle = np.sin(310 * x) * np.sin(270 * y + 1) * np.sin(290 * z + 2)
        tone = 1 - 0.3 * np.power(1 - vein, 6) + 0.12 * speckle
    elif pattern == LEATHER:
        tone = 1 + 0.08 * np.sin(95 * x + 40 * y) * np.sin(88 * y - 35 * z + 1) * np.sin(91 * z)
    else:
        tone = np.ones(len(point_m))
    result: NDArray[Any] = tone
    return result


GLSL = f"""
float room_light(vec3 d) {{
    float even = {FLOOR_LIGHT} + ({CEILING_LIGHT} - {FLOOR_LIGHT}) * smoothstep(-0.35, 0.6, d.y);
    float window = smoothstep(0.84, 0.93, abs(0.8 * d.x + 0.6 * d.z));
    return even + {WINDOW_LIGHT} * window * (1.0 - smoothstep(0.1, 0.45, abs(d.y)));
}}

float pattern_tone(float pattern, vec3 p, vec3 color) {{
    if (pattern == {WOOD}) {{
        float ring = 55.0 * (p.x + 0.35 * p.y) + 3.0 * sin(7.0 * p.z + 3.0 * p.y)
            + 1.5 * sin(19.0 * p.z);
        float paint = clamp(1.3 - 0.4 * (color.r + color.g + color.b), 0.28, 1.0);
        return 1.0 + paint * (0.08 * sin(ring) + 0.055 * sin(2.7 * ring + 11.0 * p.z));
    }} else if (pattern == {FABRIC}) {{
        float fine = sin(420.0 * (p.x + p.y)) * sin(420.0 * (p.z + p.y));
        return 1.0 + 0.06 * fine + 0.07 * sin(140.0 * (p.x + p.y)) * sin(140.0 * (p.z - p.y));
    }} else if (pattern == {STONE}) {{
        float vein = abs(sin(17.0 * (p.x + 0.7 * p.y + 0.4 * p.z)
            + 2.5 * sin(9.0 * p.y + 5.0 * p.z)));
        float speckle = sin(310.0 * p.x) * sin(270.0 * p.y + 1.0) * sin(290.0 * p.z + 2.0);
        return 1.0 - 0.3 * pow(1.0 - vein, 6.0) + 0.12 * speckle;
    }} else if (pattern == {LEATHER}) {{
        return 1.0 + 0.08 * sin(95.0 * p.x + 40.0 * p.y) * sin(88.0 * p.y - 35.0 * p.z + 1.0)
            * sin(91.0 * p.z);
    }}
    return 1.0;
}}
"""
