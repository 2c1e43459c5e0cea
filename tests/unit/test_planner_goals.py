"""The next-view planner on analytic rooms: what it asks for, and when it has enough."""

from __future__ import annotations

import math

import numpy as np
import pytest
from mapper_scene import Thing, messages, room, shoot, table

from doro_mapper.core import Mapper
from doro_mapper.planner.guide import Guide
from doro_mapper.planner.settings import PlannerSettings
from doro_mapper.settings import MapperSettings
from doro_schemas import codec
from doro_schemas.camera import Pose, pose_from_ai2thor
from doro_schemas.effects import Output
from doro_schemas.graph import ObjectGraph
from doro_schemas.messages import Exploration, ExplorationGoal, InstructionGraph
from doro_schemas.viewpoint import Viewpoint, viewpoint_of

EYE_M = 1.5


def view(x: float, z: float, yaw_deg: float, horizon_deg: float = 20.0) -> Viewpoint:
    return Viewpoint([x, EYE_M, z], yaw_deg, horizon_deg)


def small(name: str, x: float, z: float, top_m: float = 0.75, **attributes: str) -> Thing:
    return Thing(name, (x, top_m + 0.06, z), (0.12, 0.12, 0.12), attributes)


def guide_of(**options: float) -> Guide:
    settings = PlannerSettings(**options)  # type: ignore[arg-type]
    return Guide(Mapper(MapperSettings()), settings)


def explore(
    guide: Guide, things: list[Thing], poses: list[Pose], reachable: list[Viewpoint]
) -> list[Output]:
    """Start, merge the views, return all that came out."""
    outputs = list(
        guide.exploration(
            Exploration(episode="e", state="started", goals=True, reachable=reachable)
        )
    )
    for depth, graphs in messages(shoot(things, poses)):
        outputs += guide.depth_frame(depth)
        outputs += guide.frame_graphs(graphs)
    return outputs


def goals_in(outputs: list[Output]) -> list[ExplorationGoal]:
    return [output for output in outputs if isinstance(output, ExplorationGoal)]


def test_the_unseen_half_of_a_room_comes_first() -> None:
    looked, unseen = view(0, 0, 5), view(0, 0, 180)
    outputs = explore(guide_of(), room(), [view(0, 0, 0).pose("unity")], [looked, unseen])
    (goal,) = goals_in(outputs)
    assert goal.view == unseen
    assert goal.pose == unseen.pose("unity")
    assert (goal.episode, goal.frame, goal.frames_merged) == ("e", 0, 1)
    assert max(goal.parts, key=lambda part: goal.parts[part]) == "area"
    assert not goal.done


def test_nothing_is_promised_behind_a_wall() -> None:
    """Two views of places never seen; one looks at a wall from near, the other along the room."""
    wall = Thing("", (0.0, 1.25, 0.7), (3.0, 2.5, 0.1))
    seen = [view(0, -1.5, 0).pose("unity")]
    at_wall, beside = view(0, 0.2, 0, 0), view(-1.2, -1.0, 270)
    goal = goals_in(explore(guide_of(), [*room(), wall], seen, [at_wall, beside]))[-1]
    assert goal.view == beside


def test_a_thing_seen_once_is_looked_at_again() -> None:
    things = [*room(), table((0.0, 1.2)), small("cup", 0.3, 1.0, color="red")]
    poses = [view(0.0, -0.6, yaw).pose("unity") for yaw in (0, 90, 180, 270)]
    again, elsewhere = view(1.4, 1.0, 270), view(1.4, -1.0, 90)
    guide = guide_of(per_top_voxel=0.0, per_side_voxel=0.0, per_unknown_voxel=0.0)
    goal = goals_in(explore(guide, things, poses, [elsewhere, again]))[-1]
    assert goal.view == again
    assert goal.parts["tentative"] > 0.1
    assert goal.parts["area"] == 0


def test_twins_never_seen_together_are_looked_at_together() -> None:
    """Two red cups 0.5 m apart, each seen often and alone; one view left shows both."""
    cups = [small("cup", -0.25, 1.2, color="red"), small("cup", 0.25, 1.2, color="red")]
    things = [*room(), table((0.0, 1.2)), *cups]
    left = [view(-1.1, 0.6 + 0.05 * k, 40) for k in range(5)]
    poses = []
    for one in left:
        poses.append(one.pose("unity"))
    frames = messages(shoot(things, poses))
    guide = guide_of(per_top_voxel=0.0, per_side_voxel=0.0, per_unknown_voxel=0.0, unclear=0.0)
    both, single = view(0.0, 0.0, 0, 30), view(-1.0, 0.2, 0, 30)
    guide.exploration(Exploration(episode="e", state="started", reachable=[single, both]))
    for number, (depth, graphs) in enumerate(frames):
        cup = [box for box in graphs.detections if box.graph.name == "cup"]
        assert len(cup) == 2
        cup.sort(key=lambda box: box.box_px[0])
        graphs.detections[:] = [cup[number % 2]]  # the detector finds one of the two at a time
        guide.depth_frame(depth)
        guide.frame_graphs(graphs)
    goal = guide.goal()
    assert goal.view == both
    assert goal.parts["twins"] > 0.05


def test_what_the_person_asks_for_comes_first() -> None:
    bowl, cup = small("bowl", -1.8, 1.8, 0.0), small("cup", 1.8, 1.8, 0.0)
    things = [*room(), bowl, cup]
    poses = [view(0, 0, 0).pose("unity")]
    at_bowl, at_cup = view(-0.9, 0.9, 315, 40), view(0.9, 0.9, 45, 40)
    for name, expected in (("bowl", at_bowl), ("cup", at_cup)):
        guide = guide_of(per_top_voxel=0.0, per_side_voxel=0.0, per_unknown_voxel=0.0)
        guide.instruction(InstructionGraph(text=name, graph=ObjectGraph(name)))
        goal = goals_in(explore(guide, things, poses, [at_bowl, at_cup]))[-1]
        assert goal.view == expected, name


def test_done_when_all_was_looked_at_closely_and_no_view_is_taken_twice() -> None:
    """A small empty room: goals are followed until nothing promises more."""
    things = room(3.0, 3.0)
    reachable = [
        view(x, z, yaw) for x in (-0.6, 0.6) for z in (-0.6, 0.6) for yaw in range(0, 360, 45)
    ]
    guide = guide_of()
    goal = goals_in(explore(guide, things, [reachable[0].pose("unity")], reachable))[-1]
    taken = [reachable[0]]
    frame = 1
    while not goal.done:
        assert goal.view is not None
        assert goal.view not in taken
        taken.append(goal.view)
        (depth, graphs) = messages(shoot(things, [goal.view.pose("unity")]))[0]
        depth.frame = graphs.frame = frame
        frame += 1
        goal = goals_in([*guide.depth_frame(depth), *guide.frame_graphs(graphs)])[-1]
    assert 4 <= len(taken) < len(reachable)
    assert goal.gain < PlannerSettings().least_gain


def test_no_view_left_is_done() -> None:
    only = view(0, 0, 0)
    (goal,) = goals_in(explore(guide_of(), room(), [only.pose("unity")], [only]))
    assert goal.done
    assert goal.view is None


def test_without_reachable_views_goals_stand_on_the_free_floor_seen() -> None:
    obstacle = Thing("", (0.0, 0.6, 1.0), (2.4, 1.2, 0.6))
    things = [*room(), obstacle]
    poses = [view(0, -1.5, yaw, 30).pose("unity") for yaw in (0, 60, 300)]
    goal = goals_in(explore(guide_of(), things, poses, []))[-1]
    assert goal.view is not None
    x, y, z = goal.view.position_m
    assert y == pytest.approx(EYE_M)
    assert abs(x) < 2.4
    assert -2.4 < z < 2.4
    assert not (abs(x) < 1.3 and 0.6 < z < 1.4)  # not inside the obstacle
    assert goal.view.horizon_deg in PlannerSettings().horizons_deg


def test_a_robot_that_follows_its_goals_sees_the_room_behind_the_wall_and_stops() -> None:
    """No views are named: two rooms of 4 x 3 m, a doorway at one end of the wall between."""
    wall = Thing("", (-0.5, 1.25, 0.0), (3.0, 2.5, 0.1))
    things = [*room(4.0, 6.0), wall]
    guide = guide_of()
    goal = goals_in(explore(guide, things, [view(-1.0, -1.5, 0).pose("unity")], []))[-1]
    visited = []
    while not goal.done and len(visited) < 60:
        assert goal.view is not None
        assert goal.pose is not None
        visited.append(goal.view.position_m)
        (depth, graphs) = messages(shoot(things, [goal.pose]))[0]
        depth.frame = graphs.frame = len(visited)
        goal = goals_in([*guide.depth_frame(depth), *guide.frame_graphs(graphs)])[-1]
    assert goal.done
    assert 10 < len(visited) < 60
    assert {z > 0.2 for _, _, z in visited} == {True, False}  # it went through the doorway
    assert all(abs(x) < 1.9 and abs(z) < 2.9 for x, _, z in visited)


def test_travel_counts() -> None:
    """The far view promises more; where the way is dear, the near one is the goal."""
    things = room(8.0, 8.0)
    near, far = view(0.4, 0, 90), view(2.5, 0, 180)
    seen = [
        view(0, 0, 0).pose("unity"),
        view(2.5, 0, 0).pose("unity"),
        view(0, 0, 45).pose("unity"),
    ]
    for weight, wanted in ((5.0, near), (0.0, None)):
        guide = guide_of(travel_per_m=weight)
        goal = goals_in(explore(guide, things, seen, [near, far]))[-1]
        assert goal.view == wanted or wanted is None
        assert goal.distance_m >= 0


def test_goals_come_now_and_then_unless_asked_for() -> None:
    poses = [view(0, 0, 15 * k).pose("unity") for k in range(12)]
    guide = guide_of(every=5)
    guide.exploration(Exploration(episode="e", state="started"))
    counts = []
    for depth, graphs in messages(shoot(room(), poses)):
        outputs = [*guide.depth_frame(depth), *guide.frame_graphs(graphs)]
        counts.append(len(goals_in(outputs)))
    assert counts == [0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0]
    assert len(goals_in(explore(guide_of(every=0), room(), poses[:3], []))) == 3


def test_same_input_same_bytes() -> None:
    things = [*room(), table((0.0, 1.2)), small("cup", 0.3, 1.0, color="red")]
    poses = [view(0.3 * k - 1, -0.6, 40.0 * k).pose("unity") for k in range(6)]
    runs = [
        [codec.encode(goal) for goal in goals_in(explore(guide_of(), things, poses, []))]
        for _ in range(2)
    ]
    assert runs[0] == runs[1]
    assert len(runs[0]) == 6


def test_a_new_episode_forgets_the_area() -> None:
    guide = guide_of()
    seen, back = view(0, 0, 5), view(0, 0, 180)
    first = goals_in(explore(guide, room(), [view(0, 0, 0).pose("unity")], [seen, back]))[-1]
    explore(guide, room(), [back.pose("unity")] * 1, [seen, back])
    again = goals_in(explore(guide, room(), [view(0, 0, 0).pose("unity")], [seen, back]))[-1]
    assert codec.encode(first) == codec.encode(again)


def test_nothing_seen_yet_is_no_goal() -> None:
    goal = guide_of().goal()
    assert goal.view is None
    assert not goal.done


@pytest.mark.parametrize("world", ["unity", "ros"])
def test_viewpoints_and_poses_agree(world: str) -> None:
    for yaw in (0.0, 45.0, 90.0, 200.0, 359.0):
        for horizon in (-30.0, 0.0, 30.0, 85.0):
            one = Viewpoint([1.0, 2.0, 3.0], yaw, horizon)
            assert viewpoint_of(one.pose(world)) == one  # type: ignore[arg-type]
    ahead = Viewpoint([0.0, 0.0, 0.0], 90.0, 0.0).pose(world).matrix()[:, 2]  # type: ignore[arg-type]
    np.testing.assert_allclose(ahead, [1, 0, 0] if world == "unity" else [0, 1, 0], atol=1e-12)
    same = pose_from_ai2thor((1.0, 2.0, 3.0), 30.0, 10.0)
    assert Viewpoint([1.0, 2.0, 3.0], 30.0, 10.0).pose("unity") == same


def test_a_ros_world_is_planned_in_its_own_axes() -> None:
    """The same room with z up: the goal's pose is a ros pose that faces the unseen half."""
    from mapper_scene import LENS, SIZE_PX, render

    from doro_schemas.messages import DepthFrame, FrameGraphs

    unity = view(0, 0, 0).pose("unity")
    depth_m, _ = render(room(), unity)
    # unity x, y (up), z ahead -> ros x ahead, y left, z up
    here = Viewpoint([0.0, 0.0, EYE_M], 0.0, 20.0)
    looked = Viewpoint([0.0, 0.0, EYE_M], 5.0, 20.0)
    behind = Viewpoint([0.0, 0.0, EYE_M], 180.0, 20.0)
    guide = guide_of()
    guide.exploration(
        Exploration(episode="e", state="started", goals=True, reachable=[looked, behind])
    )
    size = {"height_px": SIZE_PX, "width_px": SIZE_PX}
    frame = DepthFrame(
        episode="e", frame=0, intrinsics=LENS, pose=here.pose("ros"), data=depth_m, **size
    )
    guide.depth_frame(frame)
    (goal,) = goals_in(guide.frame_graphs(FrameGraphs(episode="e", frame=0, **size)))
    assert goal.view == behind
    assert goal.pose is not None
    assert goal.pose.world == "ros"
    assert math.isclose(goal.pose.matrix()[0, 2], -math.cos(math.radians(20)), abs_tol=1e-9)
