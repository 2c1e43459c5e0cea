"""How a room is lit; the same light in both renderers."""

from __future__ import annotations

import msgspec

from doro_sim_feeder.rooms.footprints import Rect
from doro_sim_feeder.rooms.scene import CEILING_LAMP_M

Rgb = tuple[float, float, float]


class Lighting(msgspec.Struct, frozen=True, kw_only=True):
    """The light of a room.

    Attributes:
        lamp_m: the lamp, world metres.
        lamp_color, ambient_color: RGB factors.
        lamp, ambient, sky, side, head, bounce, shadow: strengths of the lamp, of even light,
            of light from above and from +x, from the camera, from the floor upwards, and the
            share of the lamp that reaches shadows by bouncing.
        exposure, gamma: of the camera.
    """

    lamp_m: tuple[float, float, float]
    lamp_color: Rgb = (1.0, 1.0, 1.0)
    ambient_color: Rgb = (1.0, 1.0, 1.0)
    lamp: float = 0.58
    ambient: float = 0.44
    sky: float = 0.06
    side: float = 0.05
    head: float = 0.12
    bounce: float = 0.22
    shadow: float = 0.12
    exposure: float = 1.0
    gamma: float = 1 / 1.15


def ceiling_lighting(room: Rect) -> Lighting:
    """Return the default light: one lamp under the middle of the ceiling."""
    return Lighting(
        lamp_m=((room.x_low + room.x_high) / 2, CEILING_LAMP_M, (room.z_low + room.z_high) / 2)
    )
