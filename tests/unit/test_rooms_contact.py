"""Gaps and penetration are measured exactly; spawned copies neither float nor cut in."""

from __future__ import annotations

import importlib.util

import numpy as np
import pytest

from doro_schemas.errors import Refused
from doro_sim_feeder.rooms.contact import ALLOWED_M, Around, Body, contacts
from doro_sim_feeder.rooms.copies import STACKED, CopySpec, wishes
from doro_sim_feeder.rooms.instances import Instance
from doro_sim_feeder.rooms.parts import blob_part, box_part, place
from doro_sim_feeder.rooms.placement import place_copies, spawn_copies
from doro_sim_feeder.rooms.scene import build_scene

MISSING = [
    name for name in ("embreex", "procthor", "PIL") if importlib.util.find_spec(name) is None
]
pytestmark = pytest.mark.skipif(
    bool(MISSING), reason=f"the extra 'render' is not installed: no {', '.join(MISSING)}"
)
TABLE = Instance("Table", "DiningTable", (box_part((-1, 0, -1), (1, 0.75, 1), (1, 1, 1)),))


def cube(bottom_m: float, x_m: float = 0.0, side_m: float = 0.1) -> Instance:
    low = (x_m, bottom_m, 0.0)
    part = box_part(low, tuple(value + side_m for value in low), (1, 0, 0))
    return Instance("Cube", "Box", (part,), copy=True)


@pytest.mark.parametrize("gap_m", [0.0005, 0.005, 0.03])
def test_the_gap_below_a_thing_is_its_drop(gap_m: float):
    contact = contacts((TABLE, cube(0.75 + gap_m)))[0]
    assert contact.gap_m == pytest.approx(gap_m, abs=1e-5)
    assert contact.penetration_m == 0
    assert contact.holds() == (gap_m <= ALLOWED_M)


@pytest.mark.parametrize(("sunk_m", "shift_m"), [(0.0008, 0.001), (0.004, 0.005), (0.015, 0.02)])
def test_penetration_is_the_smallest_shift_that_frees(sunk_m: float, shift_m: float):
    contact = contacts((TABLE, cube(0.75 - sunk_m)))[0]
    assert contact.penetration_m == shift_m
    assert contact.holds() == (shift_m <= ALLOWED_M)


def test_penetration_from_the_side_and_too_deep():
    wall = Instance("Block", "Fridge", (box_part((0.5, 0.76, -1), (1, 2, 1), (1, 1, 1)),))
    beside = contacts((TABLE, wall, cube(0.7505, x_m=0.4025)))[0]
    assert beside.penetration_m == 0.003
    assert contacts((TABLE, wall, cube(0.9, x_m=0.45, side_m=0.3)))[0].penetration_m == np.inf


def test_nothing_below_is_an_endless_drop():
    assert contacts((cube(1.0),))[0].gap_m == np.inf


def test_a_ball_comes_to_rest_on_what_reaches_highest():
    """A sphere over a thin post: the post's top touches it, not its own vertices."""
    post = Instance(
        "Post", "Structure", (box_part((-0.02, 0, -0.02), (0.02, 0.8, 0.02), (1,) * 3),)
    )
    ball = Body(place((blob_part((0.4, 0.4, 0.4), (1, 0, 0)),), 0, (0.0, 1.0, 0.0)))
    drop_m = Around([TABLE, post], ball.low, ball.high).drop_m(ball)
    assert drop_m == pytest.approx(0.2, abs=0.003)


@pytest.mark.parametrize(
    ("room", "object_type", "count", "seed"),
    [
        ("FloorPlan19", "Cup", 5, 1),
        ("FloorPlan4", "Plate", 5, 2),
        ("FloorPlan211", "Pillow", 4, 1),
        ("FloorPlan205", "Book", 4, 3),
        ("FloorPlan205", "Chair", 3, 4),
        ("FloorPlan320", "Laptop", 2, 5),
        ("FloorPlan219", "HousePlant", 4, 6),
    ],
)
def test_copies_are_supported_and_cut_into_nothing(room, object_type, count, seed):
    scene = spawn_copies(build_scene(room), CopySpec(object_type, count, arrange="mixed"), seed)
    found = contacts(scene.instances)
    assert len(found) == count
    assert [contact for contact in found if not contact.holds()] == []


def test_mixed_copies_stand_apart_close_together_and_on_each_other():
    base = build_scene("FloorPlan4")
    close = stacked = 0
    for seed in (1, 3, 5):
        scene = spawn_copies(base, CopySpec("Plate", 5, arrange="mixed"), seed)
        copies = [item for item in scene.instances if item.copy]
        names = {item.object_id for item in copies}
        stacked += sum(item.receptacles[0] in names for item in copies)
        centers = [np.mean(item.corners, axis=0) for item in copies]
        for k, one in enumerate(centers):
            apart = [float(np.hypot(*(one - other)[[0, 2]])) for other in centers[k + 1 :]]
            close += sum(0.1 < distance < 0.6 for distance in apart)
    assert close >= 1
    assert stacked >= 1


def test_looks_have_twins_and_other_materials():
    looks = [
        [wish.look for wish in wishes(CopySpec("Cup", 5), np.random.default_rng(seed))]
        for seed in range(20)
    ]
    assert sum(len(set(one)) < 5 for one in looks) >= 5
    assert any(
        a.color == b.color and a.material != b.material for one in looks for a in one for b in one
    )
    assert sum(len({look.color for look in one}) >= 2 for one in looks) >= 18
    mixed = wishes(CopySpec("Cup", 9, arrange="mixed"), np.random.default_rng(1))
    stances = {wish.stance for wish in mixed}
    assert stances == {"apart", "close"}
    assert "Cup" not in STACKED


def test_copies_without_a_place_are_told_by_name():
    scene, spec = build_scene("FloorPlan226"), CopySpec("Sofa", 6)
    spawned = place_copies(scene, spec, seed=1)
    placed = [item for item in spawned.scene.instances if item.copy]
    assert spawned.missing
    assert len(placed) + len(spawned.missing) == 6
    assert {one.name for one in spawned.missing} <= {f"copy{k}" for k in range(6)}
    assert "no flat surface of its size" in spawned.missing[0].reason
    with pytest.raises(Refused, match=r"no room for \d of 6 copies of Sofa"):
        spawn_copies(scene, spec, seed=1)
