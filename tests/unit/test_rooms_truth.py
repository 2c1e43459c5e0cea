"""Copies, relations and reachable cells of rendered rooms."""

from __future__ import annotations

import importlib.util

import numpy as np
import pytest

from doro_schemas.errors import Refused
from doro_sim_feeder.rooms.exploration import plan_views
from doro_sim_feeder.rooms.footprints import AGENT_RADIUS_M, CELL_M, Rect, reachable_cells
from doro_sim_feeder.rooms.instances import Instance
from doro_sim_feeder.rooms.layout import load_layout, room_names
from doro_sim_feeder.rooms.parts import box_part
from doro_sim_feeder.rooms.placement import CopySpec, spawn_copies
from doro_sim_feeder.rooms.scene import Scene, build_scene
from doro_sim_feeder.rooms.truth import true_instances

MISSING = [
    name for name in ("embreex", "procthor", "PIL") if importlib.util.find_spec(name) is None
]
pytestmark = pytest.mark.skipif(
    bool(MISSING), reason=f"the extra 'render' is not installed: no {', '.join(MISSING)}"
)


@pytest.fixture(scope="module")
def kitchen() -> Scene:
    return build_scene("FloorPlan19")


def block(name: str, low: tuple, high: tuple, **fields) -> Instance:
    return Instance(f"{name}|0", name, (box_part(low, high, (1, 1, 1)),), **fields)


def connected(cells: np.ndarray) -> bool:
    left = {tuple(cell) for cell in np.rint(cells / CELL_M).astype(int).tolist()}
    edge = [left.pop()]
    while edge:
        x, z = edge.pop()
        for cell in ((x + 1, z), (x - 1, z), (x, z + 1), (x, z - 1)):
            if cell in left:
                left.remove(cell)
                edge.append(cell)
    return not left


def test_relations_say_where_a_thing_is():
    scene = (
        block("Floor", (-5, -0.1, -5), (5, 0, 5)),
        block("DiningTable", (0, 0, 0), (1.5, 0.75, 1), color="brown"),
        block("Cup", (0.2, 0.75, 0.2), (0.3, 0.85, 0.3), color="red"),
        block("Fridge", (1.8, 0, 0), (2.5, 1.8, 0.8), color="white"),
        block("Sink", (-1.0, 0.7, 0), (-0.3, 0.9, 0.5)),
        block("Plate", (-0.7, 0.72, 0.1), (-0.5, 0.74, 0.3)),
    )
    truth = {item.object_type: item for item in true_instances(scene, {})}
    assert "Floor" not in truth

    def said(kind: str) -> list[tuple[str, str]]:
        return [(relation.type, relation.object_type) for relation in truth[kind].relations]

    assert said("Cup") == [("is-on", "DiningTable")]
    assert truth["Cup"].relations[0].attributes == {"color": "brown"}
    assert said("Plate")[0] == ("is-at", "Sink")
    assert said("DiningTable") == []
    assert said("Fridge") == [("is-near", "DiningTable")]


def test_the_known_support_wins_over_a_box_that_reaches_below():
    """A chair's box under the table's edge is no support of what stands on the table."""
    scene = (
        block("DiningTable", (0, 0, 0), (1.5, 0.75, 1)),
        block("Chair", (0.1, 0, -0.3), (0.6, 1.0, 0.4)),
        block("Cup", (0.2, 0.75, 0.2), (0.3, 0.85, 0.3), receptacles=("DiningTable|0",)),
    )
    cup = true_instances(scene, {})[2]
    assert (cup.relations[0].type, cup.relations[0].object_type) == ("is-on", "DiningTable")


def test_reachable_cells_keep_the_largest_free_part():
    room = Rect(0, 5, 0, 3)
    cells = reachable_cells(room, [Rect(3.0, 3.1, 0, 3)])
    assert len(cells) > 50
    assert cells[:, 0].max() <= 3.0 - AGENT_RADIUS_M
    assert connected(cells)


@pytest.mark.parametrize("name", ["FloorPlan4", "FloorPlan17", "FloorPlan211", "FloorPlan302"])
def test_reachable_cells_of_rooms_are_connected_and_free(name):
    scene = build_scene(name)
    assert len(scene.cells) >= 25
    assert connected(scene.cells)
    for item in scene.instances:
        if item.object_type in ("Fridge", "Sofa", "Bed", "Dresser"):
            assert item.rect().distance_m(scene.cells).min() >= AGENT_RADIUS_M - 1e-6


def test_small_things_stand_on_something(kitchen: Scene):
    """Below the lowest point of each spawned cup is a surface, at most 2 mm away."""
    scene = spawn_copies(kitchen, CopySpec("Cup", 4), seed=5)
    caster = kitchen.caster()
    cups = [item for item in scene.instances if item.copy]
    assert len(cups) == 4
    for cup in cups:
        low, high = cup.corners
        middle = np.array([[(low[0] + high[0]) / 2, low[1] + 0.01, (low[2] + high[2]) / 2]])
        gap_m = caster.cast(middle, np.array([[0.0, -1.0, 0.0]])).distance[0] - 0.01
        assert -0.013 < gap_m < 0.013


def test_twins_are_equal_and_stand_apart(kitchen: Scene):
    scene = spawn_copies(kitchen, CopySpec("Cup", 3, ("red", "red", "green")), seed=3)
    first, twin, other = (item for item in scene.instances if item.copy)
    assert first.attributes() == twin.attributes()
    assert len(first.parts[0].faces) == len(twin.parts[0].faces)
    assert (first.color, other.color) == ("red", "green")
    centers = [np.mean(item.corners, axis=0) for item in (first, twin)]
    assert np.linalg.norm(centers[0] - centers[1]) > 0.3
    assert first.receptacles != twin.receptacles


def test_views_are_a_seeded_walk_over_distinct_cells(kitchen: Scene):
    views = plan_views(kitchen.cells, None, seed=2)
    assert len({view.position_m for view in views}) == len(kitchen.cells)
    assert views == plan_views(kitchen.cells, None, seed=2)
    assert views != plan_views(kitchen.cells, None, seed=3)
    assert {view.yaw_deg % 45 for view in views} == {0}
    assert {view.horizon_deg for view in views} == {0, 30}
    assert len(plan_views(kitchen.cells, 10, seed=2)) == 10


def test_all_rooms_have_a_layout():
    names = [name for kind in ("kitchens", "living_rooms", "bedrooms") for name in room_names(kind)]
    assert len(names) == 90
    assert all(len(load_layout(name).objects) > 10 for name in names)


def test_what_cannot_be_is_refused(kitchen: Scene):
    with pytest.raises(Refused, match="no room 'FloorPlan99'"):
        load_layout("FloorPlan99")
    with pytest.raises(Refused, match="unknown colour 'mauve'"):
        CopySpec("Cup", 2, ("mauve",))
    with pytest.raises(Refused, match="no class 'Cupp'"):
        spawn_copies(kitchen, CopySpec("Cupp", 2), seed=1)
    with pytest.raises(Refused, match="1 to 20"):
        CopySpec("Cup", 0)
