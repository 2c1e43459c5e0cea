"""The planner's space: what depth makes free, solid and looked at, and its bounds."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from mapper_scene import LENS, SIZE_PX, Thing, render, room
from numpy.typing import NDArray

from doro_mapper.planner.settings import PlannerSettings
from doro_mapper.planner.space import Space, distances, noticed
from doro_mapper.planner.views import ways
from doro_mapper.views import camera_of, thumbnail
from doro_schemas.camera import Pose, pose_from_ai2thor

EYE_M = 1.5


def pose(x: float, z: float, yaw_deg: float, horizon_deg: float = 20.0) -> Pose:
    return pose_from_ai2thor((x, EYE_M, z), yaw_deg, horizon_deg)


def look(space: Space, things: list[Thing], *poses: Pose) -> None:
    for one in poses:
        depth_m, _ = render(things, one)
        space.add(camera_of(LENS, one, (SIZE_PX, SIZE_PX)), thumbnail(depth_m))


def at(space: Space, *points_m: tuple[float, float, float]) -> NDArray[np.float32]:
    """Return the opacity at points (x, z, height)."""
    return space.opacity[space.index(np.array(points_m, float))]


def test_free_before_a_surface_solid_at_it_unknown_behind() -> None:
    space = Space(PlannerSettings())
    look(space, [*room(), Thing("", (0, 0.5, 1.0), (1.0, 1.0, 0.4))], pose(0, -1.5, 0))
    before, surface, behind, wall = at(
        space, (0, 0, 0.5), (0, 0.85, 0.5), (0, 1.45, 0.3), (0, 2.49, 1.5)
    )
    assert (before, surface, wall) == (0, 1, 1)
    assert 0 < behind < 1
    assert space.floor_m == pytest.approx(0.0, abs=0.05)


def test_what_was_looked_at_from_near_is_worth_less() -> None:
    """Value of a table's edge falls with each look, most from near."""
    settings = PlannerSettings()
    things = [*room(), Thing("", (0, 0.35, 1.5), (1.0, 0.7, 1.0))]
    point = np.array([[0.05, 1.05, 0.65]])
    values = []
    for start in (-2.3, -0.1):
        space = Space(settings)
        look(space, things, pose(0, start, 0, 30))
        values.append(float(space.value[space.index(point)][0]))
    assert values[1] < 0.6 * values[0] < 0.6 * settings.per_top_voxel
    look(space, things, pose(0, -0.1, 0, 30))
    assert float(space.value[space.index(point)][0]) < 0.5 * values[1]


def test_a_thing_is_noticed_by_its_pixels() -> None:
    chance = noticed(0.1, np.array([0.5, 1.0, 2.5, 5.0]), 150.0, 6.0)
    assert all(a > b for a, b in pairwise(chance))
    assert chance[2] == pytest.approx(math.exp(-1))  # 6 px at 2.5 m
    np.testing.assert_allclose(noticed(0.1, np.array([5.0]), 300.0, 6.0), chance[2])


def test_a_wall_hides_and_a_gap_does_not() -> None:
    space = Space(PlannerSettings())
    wall = Thing("", (-1.2, 1.25, 0.5), (2.2, 2.5, 0.1))
    look(space, [*room(), wall], pose(0, -1.5, 0, 0), pose(1.2, 1.5, 200, 0))
    eyes = np.array([[-1.2, -1.0, 1.5], [1.2, -1.0, 1.5]])
    things = np.array([[-1.2, 1.4, 1.2], [1.2, 1.4, 1.2]])
    clear = space.clear(eyes, things, np.array([0.3, 0.3]), 24)
    assert clear[0, 0] == 0
    assert clear[1, 1] == 1


def test_the_floor_seen_can_be_walked_and_furniture_cannot() -> None:
    space = Space(PlannerSettings())
    block = Thing("", (0.0, 0.5, 0.6), (1.0, 1.0, 1.0))
    views = [
        pose(x, z, yaw, 30) for x, z in ((-1.6, -1.6), (1.6, 1.6)) for yaw in range(0, 360, 45)
    ]
    look(space, [*room(), block], *views)
    cameras = [camera_of(LENS, one, (SIZE_PX, SIZE_PX)) for one in views]
    walkable = space.walkable(cameras[-1].position_m, 0.2)
    cells = np.argwhere(walkable)
    places = space.origin_m[:2] + (cells + 0.5) * space.edge_m
    assert len(places) > 100
    assert np.abs(places).max() < 2.5
    assert not ((np.abs(places[:, 0]) < 0.5) & (np.abs(places[:, 1] - 0.6) < 0.5)).any()
    way = ways(space, cameras, PlannerSettings())
    goal = np.floor((np.array([-1.6, -1.6]) - space.origin_m[:2]) / space.edge_m).astype(int)
    assert 5.5 < way[tuple(goal)] < 8.0


def test_distances_go_round_walls_and_stop_where_nothing_leads() -> None:
    free = np.ones((5, 5), np.bool_)
    free[2, :4] = False
    way = distances(free, (0, 0))
    assert way[4, 0] == 4 + 4 + 4
    free[2, 4] = False
    assert np.isinf(distances(free, (0, 0))[4]).all()


def test_memory_is_bounded_however_far_the_robot_goes() -> None:
    settings = PlannerSettings(reach_m=6.0)
    space = Space(settings)
    flat = np.full((SIZE_PX, SIZE_PX), 2.0, np.float32)
    most = math.ceil(2 * (settings.reach_m + 2.5) / settings.voxel_m)
    for step in range(120):
        one = pose(float(step), 0.5 * step, 0.0)
        space.add(camera_of(LENS, one, (SIZE_PX, SIZE_PX)), thumbnail(flat))
        assert max(space.shape[:2]) <= most
        assert space.shape[2] == 16
    assert space.value.size == math.prod(space.shape) + 1
