"""Soft mask, depth window and measurement."""

from __future__ import annotations

import math

import numpy as np
import pytest
from mapper_scene import LENS, SIZE_PX, Thing, observe, room

from doro_mapper.assignment import assign
from doro_mapper.projection import Measured, mask_by_side, measure
from doro_mapper.views import Views, camera_of
from doro_schemas.camera import Pose, backproject, bev_axes, pose_from_ai2thor

POSE = pose_from_ai2thor((0.3, 1.5, -2.0), 20.0, 30.0)
ROS = Pose([1.0, 2.0, 1.5], [0, 0, 1, -1, 0, 0, 0, -1, 0], "ros")


def measured(
    depth: np.ndarray, *boxes: list[float], pose: Pose = POSE, sigma: float = 0.25
) -> Measured:
    camera = camera_of(LENS, pose, (SIZE_PX, SIZE_PX))
    return measure(depth, np.array(boxes), camera, sigma=sigma, samples=24, max_depth_m=20.0)


def test_mask_has_peak_one_whatever_the_box_size() -> None:
    for side in (10.0, 200.0):
        centers = np.array([[[side / 2, side, side], [side / 2, side / 2, side]]])
        mask = mask_by_side(centers, np.array([[0.0, 0.0, side, side]]), 0.25).prod(axis=1)[0]
        assert mask[0] == 1.0
        assert mask[1] == pytest.approx(math.exp(-0.5 * 4))
        assert mask[2] == pytest.approx(math.exp(-0.5 * 8))


@pytest.mark.parametrize("pose", [POSE, ROS])
def test_points_are_where_the_camera_model_puts_them(pose: Pose) -> None:
    depth = np.full((SIZE_PX, SIZE_PX), 2.0, np.float32)
    result = measured(depth, [140.0, 120.0, 150.0, 130.0], pose=pose)
    u, v = np.meshgrid(np.arange(140, 150) + 0.5, np.arange(120, 130) + 0.5)
    expected = backproject(u, v, np.full(u.shape, 2.0), LENS, pose).reshape(-1, 3)
    points = result.sample_points_m
    assert np.abs(points - expected[:, list(bev_axes(pose.world))]).max() < 1e-9
    assert result.range_m[0] == pytest.approx(2.0)
    assert result.size_m[0] == pytest.approx((20 / 150, 20 / 150))


def test_nearest_window_with_enough_mass_wins_over_the_background() -> None:
    depth = np.full((SIZE_PX, SIZE_PX), 4.0, np.float32)
    depth[:, 145:155] = 2.0  # a lamp post: a third of the samples, in the middle
    result = measured(depth, [135.0, 100.0, 165.0, 200.0])
    assert result.range_m[0] == pytest.approx(2.0)


def test_depth_window_slides_to_its_best_place() -> None:
    depth = np.full((SIZE_PX, SIZE_PX), 3.0, np.float32)
    depth[:, 100:105] = [1.00, 1.03, 1.05, 1.06, 3.0]
    result = measured(depth, [100.0, 100.0, 105.0, 105.0])
    # 4 cm from the first column on hold two columns, from the second on the middle three.
    assert len(result.sample_weights) == 3 * 5
    assert 1.03 < result.range_m[0] < 1.06


def test_boxes_of_a_frame_are_measured_as_each_would_be_alone() -> None:
    rng = np.random.default_rng(4)
    depth = (2 + rng.random((SIZE_PX, SIZE_PX))).astype(np.float32)
    depth[120:] = 0.0
    corners = rng.uniform(0, 200, (12, 2))
    boxes = np.concatenate([corners, corners + rng.uniform(5, 100, (12, 2))], axis=1).tolist()
    together = measured(depth, *boxes)
    assert 6 <= len(together) < 12  # some have no depth
    for row, index in enumerate(together.index.tolist()):
        alone = measured(depth, boxes[index])
        own = together.sample_of == row
        assert (alone.sample_points_m == together.sample_points_m[own]).all()
        for name in ("center_m", "low_m", "outer_high_m", "points_m", "range_m", "at_border"):
            assert np.allclose(getattr(alone, name)[0], getattr(together, name)[row], atol=1e-12)


def test_holes_are_no_surface() -> None:
    depth = np.zeros((SIZE_PX, SIZE_PX), np.float32)
    assert len(measured(depth, [10.0, 10.0, 60.0, 60.0])) == 0
    depth[20:50, 20:50] = 1.5
    result = measured(depth, [10.0, 10.0, 60.0, 60.0])
    assert result.range_m[0] == pytest.approx(1.5)
    assert len(result.sample_weights) < 24 * 24


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
    assert result.at_border.tolist() == [border]


def test_a_box_seen_from_the_front_is_measured_exactly() -> None:
    thing = Thing("box", (0.0, 1.0, 1.0), (0.4, 0.6, 0.4))
    frame = observe([*room(), thing], pose_from_ai2thor((0.0, 1.0, -1.0), 0.0, 0.0))
    assert len(frame.seen) == 1
    result = measured(frame.depth_m, list(frame.seen[0].box_px), pose=frame.pose)
    # Map axes (x, z, y): only the front face shows, at z = 0.8.
    assert np.abs(result.center_m[0] - [0.0, 0.8, 1.0]).max() < 0.01
    assert np.abs((result.outer_high_m - result.outer_low_m)[0] - [0.4, 0.0, 0.6]).max() < 0.05


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
