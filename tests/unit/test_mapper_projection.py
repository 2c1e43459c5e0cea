"""Soft mask, depth window and measurement."""

from __future__ import annotations

import math

import numpy as np
import pytest
from mapper_scene import LENS, SIZE_PX, Thing, observe, room

from doro_mapper.assignment import assign
from doro_mapper.projection import Measurement, Samples, depth_window, measure, soft_mask
from doro_mapper.views import Views, camera_of
from doro_schemas.camera import Pose, backproject, bev_axes, pose_from_ai2thor

POSE = pose_from_ai2thor((0.3, 1.5, -2.0), 20.0, 30.0)
ROS = Pose([1.0, 2.0, 1.5], [0, 0, 1, -1, 0, 0, 0, -1, 0], "ros")


def measured(
    depth: np.ndarray, box: list[float], pose: Pose = POSE, sigma: float = 0.25
) -> tuple[Measurement, Samples] | None:
    camera = camera_of(LENS, pose, (SIZE_PX, SIZE_PX))
    return measure(depth, box, camera, pose, sigma=sigma, samples=24, max_depth_m=20.0)


def test_mask_has_peak_one_whatever_the_box_size() -> None:
    for side in (10.0, 200.0):
        axis = np.array([side / 2, side])
        mask = soft_mask(axis, axis, [0.0, 0.0, side, side], 0.25)
        assert mask[0, 0] == 1.0
        assert mask[0, 1] == pytest.approx(math.exp(-0.5 * 4))
        assert mask[1, 1] == pytest.approx(math.exp(-0.5 * 8))


@pytest.mark.parametrize("pose", [POSE, ROS])
def test_points_are_where_the_camera_model_puts_them(pose: Pose) -> None:
    depth = np.full((SIZE_PX, SIZE_PX), 2.0, np.float32)
    result = measured(depth, [140.0, 120.0, 150.0, 130.0], pose)
    assert result is not None
    u, v = np.meshgrid(np.arange(140, 150) + 0.5, np.arange(120, 130) + 0.5)
    expected = backproject(u, v, np.full(u.shape, 2.0), LENS, pose).reshape(-1, 3)
    points = result[1].points_m
    assert np.abs(points - expected[:, list(bev_axes(pose.world))]).max() < 1e-9
    assert result[0].range_m == pytest.approx(2.0)
    assert result[0].size_m == pytest.approx((20 / 150, 20 / 150))


def test_nearest_window_with_enough_mass_wins_over_the_background() -> None:
    depth = np.full((SIZE_PX, SIZE_PX), 4.0, np.float32)
    depth[:, 145:155] = 2.0  # a lamp post: a third of the samples, in the middle
    result = measured(depth, [135.0, 100.0, 165.0, 200.0])
    assert result is not None
    assert result[0].range_m == pytest.approx(2.0)


def test_depth_window_slides_to_its_best_place() -> None:
    depth = np.array([1.00, 1.03, 1.05, 1.06, 3.0])
    near, far = depth_window(depth, np.array([1.0, 1.0, 5.0, 5.0, 1.0]), 0.03)
    assert (near, far) == (1.03, 1.06)


def test_holes_are_no_surface() -> None:
    depth = np.zeros((SIZE_PX, SIZE_PX), np.float32)
    assert measured(depth, [10.0, 10.0, 60.0, 60.0]) is None
    depth[20:50, 20:50] = 1.5
    result = measured(depth, [10.0, 10.0, 60.0, 60.0])
    assert result is not None
    assert result[0].range_m == pytest.approx(1.5)
    assert len(result[1].points_m) < 24 * 24


@pytest.mark.parametrize(
    ("box", "border"),
    [
        ([0.0, 50.0, 30.0, 90.0], True),
        ([50.0, 280.0, 70.0, 300.0], True),
        ([50.0, 50.0, 70.0, 70.0], False),
    ],
)
def test_boxes_at_the_border_are_marked(box: list[float], border: bool) -> None:
    result = measured(np.full((SIZE_PX, SIZE_PX), 2.0, np.float32), box)
    assert result is not None
    assert result[0].at_border is border


def test_a_box_seen_from_the_front_is_measured_exactly() -> None:
    thing = Thing("box", (0.0, 1.0, 1.0), (0.4, 0.6, 0.4))
    frame = observe([*room(), thing], pose_from_ai2thor((0.0, 1.0, -1.0), 0.0, 0.0))
    assert len(frame.seen) == 1
    result = measured(frame.depth_m, list(frame.seen[0].box_px), frame.pose)
    assert result is not None
    place = result[0]
    # Map axes (x, z, y): only the front face shows, at z = 0.8.
    assert np.abs(place.center_m - [0.0, 0.8, 1.0]).max() < 0.01
    assert np.abs(place.outer_high_m - place.outer_low_m - [0.4, 0.0, 0.6]).max() < 0.05


def test_views_know_what_is_occluded_behind_and_outside() -> None:
    views = Views(8)
    wall = np.full((SIZE_PX, SIZE_PX), 2.0, np.float32)
    wall[:, :60] = 0.0
    pose = pose_from_ai2thor((0.0, 1.0, 0.0), 0.0, 0.0)
    views.add(camera_of(LENS, pose, (SIZE_PX, SIZE_PX)), wall)
    points = np.array(
        [[0, 1.5, 1], [0, 2.05, 1], [0, 3, 1], [0, -1, 1], [5, 1, 1], [-0.9, 1, 1]], float
    )
    seen, depth = views.visible(points, np.array([0]), 0.1)
    assert seen[0].tolist() == [True, True, False, False, False, False]
    assert depth[0].tolist() == pytest.approx([1.5, 2.05, 3, -1, 1, 1])


def test_views_forget_the_oldest_beyond_their_bound() -> None:
    views = Views(3)
    for step in range(5):
        pose = pose_from_ai2thor((float(step), 1.0, 0.0), 0.0, 0.0)
        depth = np.full((SIZE_PX, SIZE_PX), 2.0, np.float32)
        assert views.add(camera_of(LENS, pose, (SIZE_PX, SIZE_PX)), depth) == step
    assert (views.count, views.oldest, views.total) == (3, 2, 5)
    assert views.position_m(4).tolist() == [4.0, 0.0, 1.0]
    assert sorted(views.slots([2, 3, 4]).tolist()) == [0, 1, 2]


def test_assignment_is_optimal() -> None:
    from itertools import permutations

    rng = np.random.default_rng(1)
    for trial in range(200):
        rows, columns = (int(x) for x in rng.integers(1, 6, 2))
        cost = np.minimum(rng.normal(size=(rows, columns)).round(1), 0 if trial % 3 else 9)
        pairs = assign(cost)
        short, long = sorted((rows, columns))
        wide = cost if rows <= columns else cost.T
        best = min(
            sum(wide[i, p[i]] for i in range(short)) for p in permutations(range(long), short)
        )
        assert len(pairs) == short == len({c for _, c in pairs}) == len({r for r, _ in pairs})
        assert sum(cost[r, c] for r, c in pairs) == pytest.approx(best)
