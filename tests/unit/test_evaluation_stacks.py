"""Judging stacks: counted once, linked by the shared rule."""

from __future__ import annotations

import msgspec
import pytest

from doro_evaluation.chain import Room
from doro_evaluation.counting.stacks import figures_of, judge_room, true_stacks, without_relations
from doro_schemas.graph import ObjectGraph, Relation
from doro_schemas.messages import FrameGraphs, GraphBox, Instance, SimDetection, SimDetections
from doro_sim_feeder.rooms.truth import TrueInstance, TrueRelation

BOX_PX = [10.0, 10.0, 60.0, 60.0]


def true(
    name: str, kind: str, bottom: float, height: float, below: str, *, color: str = "red"
) -> TrueInstance:
    return TrueInstance(
        number=1,
        object_id=name,
        object_type=kind,
        attributes={"color": color},
        center_m=[1.0, bottom + height / 2, 2.0],
        size_m=[0.25, height, 0.25],
        receptacle=below,
        relations=[TrueRelation("is-on", below, "DiningTable", {})],
        copy=True,
    )


PLATE = true("plate", "Plate", 0.75, 0.02, "table")
BOWL = true("bowl", "Bowl", 0.77, 0.09, "plate", color="blue")
BOOK = true("book", "Book", 0.75, 0.04, "table")


def a_room(*truth: TrueInstance, views: int = 5) -> Room:
    frames = tuple(
        SimDetections(
            frame=k,
            height_px=300,
            width_px=300,
            detections=[SimDetection(one.object_id, one.object_type, BOX_PX) for one in truth],
        )
        for k in range(views)
    )
    return Room("stacks-FloorPlan1", "FloorPlan1", "e", (), frames, tuple(truth))


def found(kind: str, true_one: TrueInstance, holder: tuple[str, str, str] | None) -> Instance:
    relations = []
    if holder is not None:
        relation, name, color = holder
        attributes = {"color": color} if color else {}
        relations = [Relation(relation, ObjectGraph(name, attributes))]
    graph = ObjectGraph(kind, true_one.attributes, relations)
    return Instance(f"{kind}-1", graph, true_one.center_m, true_one.size_m)


def test_a_chain_goes_from_below_to_the_top() -> None:
    apple = true("apple", "Apple", 0.8, 0.1, "bowl")
    chains = true_stacks(a_room(apple, BOOK, BOWL, PLATE))
    assert [[one.object_id for one in chain] for chain in chains] == [["plate", "bowl", "apple"]]


def test_right_means_counted_once_and_held_by_the_thing_below() -> None:
    room = a_room(PLATE, BOWL)
    plate = found("plate", PLATE, ("is-on", "dining table", ""))
    (one,) = judge_room(room, [plate, found("bowl", BOWL, ("is-on", "plate", "red"))], "gt", "m")
    assert (one.right, one.counted, one.linked, one.supported, one.why) == (
        True, True, True, True, "",
    )  # fmt: skip
    assert figures_of([one])["stacks/ours/gt/m/right"] == 1


@pytest.mark.parametrize(
    ("holder", "why"),
    [
        (("is-on", "dining table", ""), "is-on dining table in place of is-on red plate"),
        (("is-at", "plate", ""), "is-at plate in place of is-on red plate"),
        (("is-on", "plate", "green"), "is-on green plate in place of is-on red plate"),
        (None, "nothing in place of is-on red plate"),
    ],
)
def test_another_holder_is_wrong(holder: tuple[str, str, str] | None, why: str) -> None:
    plate = found("plate", PLATE, ("is-on", "dining table", ""))
    (one,) = judge_room(a_room(PLATE, BOWL), [plate, found("bowl", BOWL, holder)], "gt", "m")
    assert one.counted
    assert not one.right
    assert why in one.why


def test_two_for_one_are_not_counted_right() -> None:
    plate = found("plate", PLATE, ("is-on", "dining table", ""))
    bowl = found("bowl", BOWL, ("is-on", "plate", ""))
    (twice,) = judge_room(a_room(PLATE, BOWL), [plate, bowl, bowl], "gt", "m")
    (none,) = judge_room(a_room(PLATE, BOWL), [plate], "gt", "m")
    assert not twice.counted
    assert twice.linked
    assert "2 bowl of 1" in twice.why
    assert not none.counted
    assert not none.linked


@pytest.mark.parametrize(("apart_m", "right"), [(0.02, True), (0.2, False)])
def test_things_a_centimetre_apart_are_told_apart_by_their_looks(
    apart_m: float, right: bool
) -> None:
    middle = true("b2", "Book", 0.79, 0.02, "book", color="blue")
    top = true("b3", "Book", 0.79 + apart_m, 0.02, "b2", color="green")
    low = found("book", BOOK, ("is-on", "dining table", ""))
    blue = found("book", middle, ("is-on", "book", "red"))
    green = found("book", top, ("is-on", "book", "blue"))
    swapped = [
        msgspec.structs.replace(blue, position_m=green.position_m),
        msgspec.structs.replace(green, position_m=blue.position_m),
    ]
    (one,) = judge_room(a_room(BOOK, middle, top), [low, *swapped], "gt", "m")
    assert one.counted
    assert one.linked is right


def test_what_is_seen_too_seldom_is_not_tried() -> None:
    assert judge_room(a_room(PLATE, BOWL, views=2), [], "gt", "m") == []


def test_graphs_can_be_stripped_of_relations() -> None:
    graph = ObjectGraph("cup", {"color": "red"}, [Relation("is-on", ObjectGraph("table"))])
    frame = FrameGraphs(
        frame=0, height_px=9, width_px=9, detections=[GraphBox([0, 0, 5, 5], 1.0, graph, "a cup")]
    )
    (stripped,) = without_relations([frame])
    assert stripped.detections[0].graph == ObjectGraph("cup", {"color": "red"})
    assert frame.detections[0].graph.relations
