"""Geometry pinned against AI2-THOR's conventions, with numbers worked out by hand."""

from __future__ import annotations

import math

import msgspec
import numpy as np
import pytest

from doro_schemas.camera import (
    Intrinsics,
    Pose,
    backproject,
    intrinsics_from_vertical_fov,
    pose_from_ai2thor,
    project,
)

CAMERA = (1.0, 1.5, -2.0)
K300 = intrinsics_from_vertical_fov(300, 300, 90.0)


def test_vertical_fov_gives_both_focal_lengths() -> None:
    wide = intrinsics_from_vertical_fov(480, 640, 90.0)
    assert wide.fx == pytest.approx(240.0)
    assert wide.fy == pytest.approx(240.0)
    assert (wide.cx, wide.cy) == (320.0, 240.0)
    assert intrinsics_from_vertical_fov(300, 300, 60.0).fy == pytest.approx(259.8076, abs=1e-4)


@pytest.mark.parametrize(
    ("yaw_deg", "horizon_deg", "ahead"),
    [
        (0, 0, (1.0, 1.5, 0.0)),  # yaw 0 faces +z
        (90, 0, (3.0, 1.5, -2.0)),  # yaw 90 faces +x: clockwise from above
        (180, 0, (1.0, 1.5, -4.0)),
        (0, 90, (1.0, -0.5, -2.0)),  # a positive horizon looks down
        (0, 30, (1.0, 1.5 - 2 * 0.5, -2.0 + 2 * math.cos(math.pi / 6))),
    ],
)
def test_two_metres_ahead(
    yaw_deg: float, horizon_deg: float, ahead: tuple[float, float, float]
) -> None:
    pose = pose_from_ai2thor(CAMERA, yaw_deg, horizon_deg)
    point = backproject(np.array(150.0), np.array(150.0), np.array(2.0), K300, pose)
    assert point == pytest.approx(ahead, abs=1e-9)


def test_right_and_down_in_the_image() -> None:
    pose = pose_from_ai2thor(CAMERA, 0.0, 0.0)
    right = backproject(np.array(300.0), np.array(150.0), np.array(2.0), K300, pose)
    down = backproject(np.array(150.0), np.array(300.0), np.array(2.0), K300, pose)
    assert right == pytest.approx((3.0, 1.5, 0.0))  # planar depth: z stays 2, not the ray
    assert down == pytest.approx((1.0, -0.5, 0.0))


def test_ros_optical_frame_looks_along_its_rotation() -> None:
    # A camera at 1 m that looks along +x of a z-up world: optical x = -y, y = -z, z = +x.
    pose = Pose([0.0, 0.0, 1.0], [0, 0, 1, -1, 0, 0, 0, -1, 0], "ros")
    point = backproject(np.array(150.0), np.array(0.0), np.array(3.0), K300, pose)
    assert point == pytest.approx((3.0, 0.0, 4.0))


def test_project_undoes_backproject() -> None:
    rng = np.random.default_rng(3)
    u, v, depth = rng.uniform(0, 300, 50), rng.uniform(0, 300, 50), rng.uniform(0.3, 9, 50)
    pose = pose_from_ai2thor(CAMERA, 213.0, 17.0)
    back = project(backproject(u, v, depth, K300, pose), K300, pose)
    for have, want in zip(back, (u, v, depth), strict=True):
        assert have == pytest.approx(want, abs=1e-9)


@pytest.mark.parametrize(
    ("rotation", "world", "words"),
    [
        ([1, 0, 0, 0, 1, 0, 0, 0, 1], "unity", "mirrored"),
        ([1, 0, 0, 0, -1, 0, 0, 0, 1], "ros", "mirrored"),
        ([1, 0, 0, 0, -1, 0, 0, 0, 1.1], "unity", "no rotation"),
        ([1, 0, 0, 0, -1, 0, 0, 0, float("inf")], "unity", "not finite"),
        ([1, 0, 0], "unity", "9 rotation values"),
    ],
)
def test_what_is_no_pose_is_refused(rotation: list[float], world: str, words: str) -> None:
    with pytest.raises(msgspec.ValidationError, match=words):
        msgspec.convert({"position_m": [0, 0, 0], "rotation": rotation, "world": world}, Pose)


def test_intrinsics_must_be_positive() -> None:
    with pytest.raises(ValueError, match="positive focal"):
        Intrinsics(0.0, 100.0, 5.0, 5.0)
