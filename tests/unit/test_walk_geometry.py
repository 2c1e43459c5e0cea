"""Real AI2-THOR walks: points of one frame must lie on the surfaces that the next one saw."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from doro_schemas.camera import backproject, project
from doro_schemas.messages import DepthFrame
from doro_sim_feeder.folder import FrameFolder

WALKS = Path(__file__).resolve().parents[3] / "shared/data/ai2thor_walks/house_idx_10"
MEDIAN_LIMIT_M = 0.005

pytestmark = pytest.mark.skipif(not WALKS.exists(), reason="the recorded walks are not here")


def differences_m(first: DepthFrame, second: DepthFrame) -> NDArray[np.float64]:
    """Return signed depth differences (metres) of the first frame's points in the second.

    Points that the second frame does not see, or where either depth is clipped, are left
    out, and so are depth edges, where one pixel off is another surface.
    """
    depth = first.depth_m()
    v, u = np.mgrid[2 : first.height_px - 2 : 5, 2 : first.width_px - 2 : 5]
    known = depth[v, u] > 0
    u, v = u[known], v[known]
    points = backproject(u + 0.5, v + 0.5, depth[v, u], first.intrinsics, first.pose)
    u2, v2, expected = project(points, second.intrinsics, second.pose)
    inside = (expected > 0.1) & (u2 >= 1) & (u2 < 639) & (v2 >= 1) & (v2 < 639)
    column, row = u2[inside].astype(int), v2[inside].astype(int)
    seen = second.depth_m()
    around = np.stack([seen[row + i, column + j] for i in (-1, 0, 1) for j in (-1, 0, 1)])
    error = seen[row, column] - expected[inside]
    smooth = (around.min(0) > 0) & (np.ptp(around, axis=0) < 0.1) & (np.abs(error) < 0.15)
    return np.asarray(error[smooth], dtype=np.float64)


def pairs(
    folder: FrameFolder, tasks: list[str], *, turning: bool = False
) -> list[NDArray[np.float64]]:
    """Return the differences of each pair of consecutive views that overlap.

    Turning pairs look along another direction: they are what a wrong camera shows in.
    """
    found = []
    for task in tasks:
        frames = [one for one in folder.messages([task]) if isinstance(one, DepthFrame)]
        for first, second in pairwise(frames):
            if turning and first.pose.rotation == second.pose.rotation:
                continue
            errors = differences_m(first, second)
            if first.pose != second.pose and len(errors) >= 500:
                found.append(errors)
    return found


def test_overlapping_frames_agree() -> None:
    folder = FrameFolder(WALKS)
    medians = [float(np.median(np.abs(errors))) for errors in pairs(folder, folder.tasks)]
    assert len(medians) >= 150
    assert float(np.median(medians)) < MEDIAN_LIMIT_M
    assert max(medians) < 0.02  # one step of their depth, which comes in 2 cm


def test_frames_of_other_directions_agree() -> None:
    """Rounding to 2 cm steps alone gives 6 mm of absolute difference here, and no bias."""
    folder = FrameFolder(WALKS)
    turning = pairs(folder, folder.tasks, turning=True)
    assert len(turning) >= 40
    assert float(np.median([abs(float(np.median(errors))) for errors in turning])) < 0.002
    assert float(np.median([float(np.median(np.abs(errors))) for errors in turning])) < 0.008


@pytest.mark.parametrize(("name", "change"), [("horizon_deg", 2.0), ("fov_deg", 5.0)])
def test_a_wrong_camera_would_be_noticed(name: str, change: float) -> None:
    """The check is sharp: two degrees of horizon or five of field of view fail it."""
    folder = FrameFolder(WALKS)
    if name == "fov_deg":
        folder._index["fov_vertical_deg"] += change
    for frame in folder._frames if name == "horizon_deg" else []:
        frame["cameraHorizon_deg_INFERRED"] += change
    turning = pairs(folder, folder.tasks, turning=True)
    assert float(np.median([float(np.median(np.abs(errors))) for errors in turning])) > 0.012


def test_walks_report() -> None:
    """All walks import: sizes, order, depth that is clipped at 5 m."""
    folder = FrameFolder(WALKS)
    depth = [one for one in folder.messages() if isinstance(one, DepthFrame)]
    assert len(depth) == 196
    assert [one.frame for one in depth] == list(range(196))
    assert max(float(one.depth_m().max()) for one in depth[:20]) < 5.0
