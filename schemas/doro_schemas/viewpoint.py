"""Where to look from: a camera's place, heading and tilt, in words that people and robots use.

``yaw_deg`` is AI2-THOR's in a ``unity`` world (clockwise from above, 0 faces +z, 90 faces +x)
and REP 103's in a ``ros`` world (counter-clockwise from above, 0 faces +x, 90 faces +y).
``horizon_deg`` is AI2-THOR's in both: positive looks down.
"""

from __future__ import annotations

import math

import msgspec
import numpy as np

from doro_schemas.camera import Pose, World, pose_from_ai2thor

STRAIGHT_UP = 1e-6
"""Below this, the optical axis has no heading: the camera looks straight up or down."""


class Viewpoint(msgspec.Struct, frozen=True):
    """A camera's place and direction; an upright camera (no roll).

    Attributes:
        position_m: camera centre, world axes, 3 values, metres.
        yaw_deg, horizon_deg: direction, see the module; None: any.
    """

    position_m: list[float]
    yaw_deg: float | None = None
    horizon_deg: float | None = None

    def __post_init__(self) -> None:
        angles = [value for value in (self.yaw_deg, self.horizon_deg) if value is not None]
        if len(self.position_m) != 3 or not all(map(math.isfinite, [*self.position_m, *angles])):
            raise ValueError("a viewpoint needs 3 finite position values and finite angles")
        if self.horizon_deg is not None and abs(self.horizon_deg) > 90:
            raise ValueError(f"horizon_deg must be in -90..90, got {self.horizon_deg:g}")

    def pose(self, world: World) -> Pose:
        """Return the camera's pose; 0 for angles that are left open."""
        yaw_deg, horizon_deg = self.yaw_deg or 0.0, self.horizon_deg or 0.0
        if world == "unity":
            x, y, z = self.position_m
            return pose_from_ai2thor((x, y, z), yaw_deg, horizon_deg)
        yaw, tilt = math.radians(yaw_deg), math.radians(horizon_deg)
        forward = [
            math.cos(yaw) * math.cos(tilt),
            math.sin(yaw) * math.cos(tilt),
            -math.sin(tilt),
        ]
        right = [math.sin(yaw), -math.cos(yaw), 0.0]
        down = np.cross(forward, right)
        rotation = np.stack([right, down, forward], axis=1)
        return Pose(list(self.position_m), [float(value) for value in rotation.ravel()], world)


def viewpoint_of(pose: Pose) -> Viewpoint:
    """Return the place, heading and tilt of a pose; its roll is lost."""
    x, y, z = (float(value) for value in pose.matrix()[:, 2])
    up = y if pose.world == "unity" else z
    flat = (x, z) if pose.world == "unity" else (y, x)
    level = math.hypot(*flat)
    yaw_deg = math.degrees(math.atan2(*flat)) % 360.0 if level > STRAIGHT_UP else 0.0
    horizon_deg = math.degrees(math.atan2(-up, level))
    return Viewpoint(list(pose.position_m), round(yaw_deg, 4) % 360.0, round(horizon_deg, 4))
