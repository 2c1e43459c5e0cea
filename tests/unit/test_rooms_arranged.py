"""Chairs round a table, stacks and high counts: what is made, that it rests, that it repeats."""

from __future__ import annotations

import importlib.util
from collections import Counter

import numpy as np
import pytest

from doro_schemas.errors import Refused
from doro_schemas.spatial import relation_between
from doro_sim_feeder.rooms.evaluation_set import plan_set
from doro_sim_feeder.rooms.layout import load_layout
from doro_sim_feeder.rooms.more_sets import MORE_PARTS, plan_all, plan_part, rooms_of_test
from doro_sim_feeder.rooms.scene import Scene, build_scene
from doro_sim_feeder.rooms.truth import true_instances

MISSING = [
    name for name in ("embreex", "procthor", "PIL") if importlib.util.find_spec(name) is None
]
pytestmark = pytest.mark.skipif(
    bool(MISSING), reason=f"the extra 'render' is not installed: no {', '.join(MISSING)}"
)
ROOM = "FloorPlan22"


@pytest.fixture(scope="module")
def room() -> Scene:
    return build_scene(ROOM)


def test_the_papers_set_is_not_changed_by_the_other_parts() -> None:
    assert plan_part("paper") == plan_set()
    assert len(plan_set()) == 107
    names = [row.name for row in plan_all()]
    assert len(names) == len(set(names)) == 107 + 34 + 10 + 10 + 34 + 15 + 26
    with pytest.raises(Refused, match="no part 'moon'"):
        plan_part("moon")


def test_nothing_is_tuned_on_test_rooms() -> None:
    tested = set(rooms_of_test(7))
    assert len(tested) == 34
    for part in MORE_PARTS:
        rooms = {row.room for row in plan_part(part)}
        if part.endswith("-tune"):
            assert not rooms & tested, part
        else:
            assert rooms <= tested, part


def test_extra_rooms_have_enough_items_of_three_and_more() -> None:
    totals: Counter[int] = Counter()
    for row in plan_part("extra"):
        own = Counter(item.object_type for item in load_layout(row.room).objects)
        totals.update(own[kind] + count for kind, count in row.more)  # type: ignore[attr-defined]
    assert set(totals) == {3, 4, 5}
    assert totals[4] >= 50
    assert totals[5] >= 50
    assert plan_part("extra") == plan_part("extra")


def test_rooms_for_tuning_have_pairs_too() -> None:
    rows = plan_part("copies-tune")
    totals: Counter[int] = Counter()
    for row in rows:
        own = Counter(item.object_type for item in load_layout(row.room).objects)
        totals.update(own[kind] + count for kind, count in row.more)  # type: ignore[attr-defined]
    assert set(totals) == {2, 3, 4, 5}
    assert min(totals.values()) >= 20


def test_four_identical_chairs_face_the_table_and_touch_nothing(room: Scene) -> None:
    from doro_sim_feeder.rooms.chairs import chairs_round_table
    from doro_sim_feeder.rooms.contact import Around, Body

    scene = chairs_round_table(room, 307)
    chairs = [item for item in scene.instances if item.object_type == "Chair"]
    assert len(chairs) == 4
    assert len({(item.color, item.material) for item in chairs}) == 1
    sizes = [sorted(item.box().size_m) for item in chairs]
    assert np.ptp(np.array(sizes), axis=0).max() < 0.01
    middle = np.mean([item.box().center_m[:2] for item in chairs], axis=0)
    table = min(
        (item for item in scene.instances if item.object_type == "DiningTable"),
        key=lambda item: float(np.linalg.norm(np.asarray(item.box().center_m[:2]) - middle)),
    )
    for chair in chairs:
        away = np.asarray(table.box().center_m[:2]) - np.asarray(chair.box().center_m[:2])
        yaw = np.radians(chair.yaw_deg)
        assert float(np.array([np.sin(yaw), np.cos(yaw)]) @ away) > 0.8 * np.linalg.norm(away)
        assert np.linalg.norm(away) < 1.3
        others = [item for item in scene.instances if item is not chair]
        body = Body(chair.parts)
        contact = Around(others, body.low, body.high).contact(chair.object_id, body)
        assert contact.holds()
    again = chairs_round_table(room, 307)
    assert [i.object_id for i in again.instances] == [i.object_id for i in scene.instances]


def test_piles_rest_and_hold_by_the_shared_rule(room: Scene) -> None:
    from doro_sim_feeder.rooms.contact import contacts
    from doro_sim_feeder.rooms.stacks import add_stacks

    scene = add_stacks(room, 11, 0, 2)
    copies = {item.object_id: item for item in scene.instances if item.copy}
    piled = [item for item in copies.values() if item.piled]
    assert piled
    for item in piled:
        below = copies[item.receptacles[0]]
        assert relation_between(item.box(), below.box()) in ("is-on", "is-at")
    assert all(one.holds() for one in contacts(scene.instances))
    truth = {one.object_id: one for one in true_instances(scene.instances, {})}
    for item in piled:
        held = truth[item.object_id].relations[0]
        assert held.type in ("is-on", "is-at")
        assert held.object_id == item.receptacles[0]
