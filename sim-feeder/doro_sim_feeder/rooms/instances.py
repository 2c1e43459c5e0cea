"""One thing of a rendered room."""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace

import numpy as np

from doro_schemas.spatial import Box3
from doro_sim_feeder.rooms.footprints import Rect
from doro_sim_feeder.rooms.parts import Floats, Part, bounds

# What a room is made of: rendered and given an id, but no object that anyone talks about.
BACKGROUND = frozenset({"Floor", "Wall", "Ceiling", "Structure"})


@dataclass(frozen=True)
class Instance:
    """A thing as rendered.

    Attributes:
        parts: its triangles, world metres.
        color, material: true self attributes of what is rendered; None where none applies.
        receptacles: ids of what it stands on or in.
        copy: spawned, not of the room's own layout.
        piled: put on or into another thing on purpose: the first of ``receptacles`` holds it.
    """

    object_id: str
    object_type: str
    parts: tuple[Part, ...]
    color: str | None = None
    material: str | None = None
    yaw_deg: float = 0.0
    pickupable: bool = False
    receptacles: tuple[str, ...] = ()
    copy: bool = False
    piled: bool = False

    @functools.cached_property
    def corners(self) -> tuple[Floats, Floats]:
        """Corners (low, high) of the rendered box, float32 (3,), world metres."""
        return bounds(self.parts)

    def box(self) -> Box3:
        """Return the rendered box in (ground, ground, up) order."""
        low, high = (corner.astype(np.float64) for corner in self.corners)
        center, size = (low + high) / 2, high - low
        return Box3(
            (float(center[0]), float(center[2]), float(center[1])),
            (float(size[0]), float(size[2]), float(size[1])),
        )

    def rect(self) -> Rect:
        """Return the footprint of the rendered box."""
        low, high = self.corners
        return Rect(float(low[0]), float(high[0]), float(low[2]), float(high[2]))

    def raised(self, height_m: float) -> Instance:
        return replace(self, parts=tuple(part.moved((0, height_m, 0)) for part in self.parts))

    def attributes(self) -> dict[str, str]:
        """Return the true self attributes by type."""
        pairs = (("color", self.color), ("material", self.material))
        return {name: value for name, value in pairs if value is not None}
