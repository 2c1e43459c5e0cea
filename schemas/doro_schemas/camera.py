"""The camera model: pinhole intrinsics, poses, and AI2-THOR's and ROS's conventions.

Camera axes are always optical: x right, y down, z forward, metres. A pose takes a
point from the camera into the world, ``P_world = R @ P_camera + t``. Two worlds are
known: ``unity`` (AI2-THOR: left-handed, x right, y up, z forward) and ``ros``
(right-handed, z up). Optical axes are right-handed, so ``det R`` is -1 in ``unity``
and +1 in ``ros``.
"""

from __future__ import annotations

import math
from typing import Any, Literal

import msgspec
import numpy as np
from numpy.typing import NDArray

World = Literal["unity", "ros"]
HANDEDNESS: dict[str, float] = {"unity": -1.0, "ros": 1.0}
ORTHONORMAL_TOLERANCE = 1e-3


def _dot(a: list[float], b: list[float]) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


class Intrinsics(msgspec.Struct, frozen=True):
    """Pinhole intrinsics in pixels; pixel (u, v) has its centre at (u+0.5, v+0.5)."""

    fx: float
    fy: float
    cx: float
    cy: float

    def __post_init__(self) -> None:
        values = (self.fx, self.fy, self.cx, self.cy)
        if not all(map(math.isfinite, values)) or self.fx <= 0 or self.fy <= 0:
            raise ValueError(f"intrinsics must be finite with positive focal lengths, got {values}")


class Pose(msgspec.Struct, frozen=True):
    """Absolute camera pose.

    Attributes:
        position_m: camera centre in the world, 3 values, metres.
        rotation: camera-to-world rotation, 9 values, row major.
        world: handedness and up axis of the world.
    """

    position_m: list[float]
    rotation: list[float]
    world: World = "unity"

    def __post_init__(self) -> None:
        if len(self.position_m) != 3 or len(self.rotation) != 9:
            raise ValueError("a pose needs 3 position values and 9 rotation values")
        if not all(map(math.isfinite, [*self.position_m, *self.rotation])):
            raise ValueError("the pose has a value that is not finite (NaN or infinity)")
        # Plain floats: a pose is checked with every depth frame, and 9 numbers are too few
        # to be worth numpy's overhead.
        x, y, z = self.rotation[:3], self.rotation[3:6], self.rotation[6:]
        products = (
            _dot(x, x) - 1,
            _dot(y, y) - 1,
            _dot(z, z) - 1,
            _dot(x, y),
            _dot(y, z),
            _dot(z, x),
        )
        if max(map(abs, products)) > ORTHONORMAL_TOLERANCE:
            raise ValueError("the pose is no rotation: its rows are not orthonormal")
        cross = [
            x[1] * y[2] - x[2] * y[1],
            x[2] * y[0] - x[0] * y[2],
            x[0] * y[1] - x[1] * y[0],
        ]
        if _dot(cross, z) * HANDEDNESS[self.world] < 0:
            raise ValueError(
                f"the pose is mirrored: in a '{self.world}' world the determinant of the"
                f" rotation must be {HANDEDNESS[self.world]:+.0f}"
            )

    def matrix(self) -> NDArray[np.float64]:
        """Return the rotation as a (3, 3) float64 array."""
        return np.asarray(self.rotation, dtype=np.float64).reshape(3, 3)


def intrinsics_from_vertical_fov(height_px: int, width_px: int, fov_deg: float) -> Intrinsics:
    """Return the intrinsics of an AI2-THOR camera, whose field of view is vertical."""
    focal_px = (height_px / 2) / math.tan(math.radians(fov_deg) / 2)
    return Intrinsics(fx=focal_px, fy=focal_px, cx=width_px / 2, cy=height_px / 2)


def pose_from_ai2thor(
    camera_position: dict[str, float] | tuple[float, float, float],
    yaw_deg: float,
    horizon_deg: float,
) -> Pose:
    """Return the pose of an AI2-THOR camera.

    Args:
        camera_position: ``cameraPosition`` of the event's metadata (not the agent's).
        yaw_deg: agent rotation.y, clockwise from above; 0 faces +z, 90 faces +x.
        horizon_deg: cameraHorizon, positive looks down.
    """
    if isinstance(camera_position, dict):
        camera_position = (camera_position["x"], camera_position["y"], camera_position["z"])
    yaw, horizon = math.radians(yaw_deg), math.radians(horizon_deg)
    right = np.array([math.cos(yaw), 0.0, -math.sin(yaw)])
    up = np.array(
        [math.sin(yaw) * math.sin(horizon), math.cos(horizon), math.cos(yaw) * math.sin(horizon)]
    )
    forward = np.array(
        [math.sin(yaw) * math.cos(horizon), -math.sin(horizon), math.cos(yaw) * math.cos(horizon)]
    )
    rotation = np.stack([right, -up, forward], axis=1)
    return Pose(
        position_m=[float(value) for value in camera_position],
        rotation=[float(value) for value in rotation.ravel()],
        world="unity",
    )


def backproject(
    u_px: NDArray[Any],
    v_px: NDArray[Any],
    depth_m: NDArray[Any],
    intrinsics: Intrinsics,
    pose: Pose,
) -> NDArray[np.float64]:
    """Return world points, (..., 3) metres, of pixel positions with planar depth.

    Paper, Section IV-B, with the factor the paper lacks: ``P = d K^-1 [u v 1]^T``.

    Args:
        u_px, v_px: continuous pixel coordinates (a pixel's centre is at +0.5).
        depth_m: distance along the optical axis, not along the ray.
    """
    x = (u_px - intrinsics.cx) / intrinsics.fx * depth_m
    y = (v_px - intrinsics.cy) / intrinsics.fy * depth_m
    camera = np.stack([x, y, np.broadcast_to(depth_m, x.shape)], axis=-1).astype(np.float64)
    world: NDArray[np.float64] = camera @ pose.matrix().T + np.asarray(pose.position_m)
    return world


def project(
    points_m: NDArray[Any], intrinsics: Intrinsics, pose: Pose
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return (u_px, v_px, depth_m) of world points (..., 3); depth <= 0 lies behind."""
    camera = (np.asarray(points_m, dtype=np.float64) - np.asarray(pose.position_m)) @ pose.matrix()
    depth = camera[..., 2]
    safe = np.where(np.abs(depth) < 1e-9, 1e-9, depth)
    u = camera[..., 0] / safe * intrinsics.fx + intrinsics.cx
    v = camera[..., 1] / safe * intrinsics.fy + intrinsics.cy
    return u, v, depth


def bev_axes(world: World) -> tuple[int, int, int]:
    """Return the indices of (first ground axis, second ground axis, height axis)."""
    return (0, 2, 1) if world == "unity" else (0, 1, 2)
