"""Piles, containers, and which landmarks nobody would name."""

from __future__ import annotations

import numpy as np
import pytest

from doro_mapper.finder import Found
from doro_mapper.relations import captioned_relations, relations_of, spatial_relations
from doro_mapper.settings import MapperSettings
from doro_mapper.sightings import Sighting
from doro_mapper.votes import Votes
from doro_schemas.graph import ObjectGraph, Relation

Corner = tuple[float, float, float]
DESK = ("desk", (0.0, 0.0, 0.0), (1.6, 0.8, 0.80))
"""Its box reaches 5 cm above its top, as boxes of furniture do."""


def box(name: str, low_m: Corner, high_m: Corner, level_m: float | None = None) -> Found:
    """Return a found thing; ``level_m``: height of its centre over all views."""
    low, high = np.array(low_m), np.array(high_m)
    center = (low + high) / 2
    center[2] = center[2] if level_m is None else level_m
    return Found(name, center, low, high, 3, 0, Votes())


def related(things: list[tuple[Found, str]]) -> list[list[Relation]]:
    """Return the measured relations; a thing's colour tells it from others of its class."""
    return spatial_relations([found for found, _ in things], graphs_of(things), 3)


def graphs_of(things: list[tuple[Found, str]]) -> list[ObjectGraph]:
    return [ObjectGraph(found.name, {"color": color}) for found, color in things]


def holders(things: list[tuple[Found, str]]) -> list[str]:
    """Return by thing "relation colour", "" where nothing carries or holds it."""
    held = [
        [f"{r.type} {r.target.attributes['color']}" for r in own if r.type != "is-near"]
        for own in related(things)
    ]
    assert all(len(own) <= 1 for own in held)
    return [own[0] if own else "" for own in held]


def pairs(things: list[tuple[Found, str]]) -> list[list[tuple[str, str]]]:
    return [[(r.type, r.target.name) for r in own] for own in related(things)]


def test_books_on_books_make_a_chain() -> None:
    """Each lower book's box reaches up to the top of the pile, as its view shows what is on it."""
    things = [
        (box("book", (0.30, 0.30, 0.75), (0.60, 0.52, 0.86)), "red"),
        (box("book", (0.31, 0.31, 0.75), (0.60, 0.51, 0.87)), "green"),
        (box("book", (0.32, 0.33, 0.80), (0.58, 0.51, 0.87)), "blue"),
        (box("mug", (0.40, 0.36, 0.86), (0.50, 0.45, 0.97)), "white"),
        (box(*DESK), "brown"),
    ]
    chain = ["is-on brown", "is-on red", "is-on green", "is-on blue", ""]
    assert holders(things) == chain
    assert holders(things[::-1]) == chain[::-1]


def test_plates_of_one_box_are_told_apart_by_their_centres() -> None:
    """Three plates nested within a centimetre: the centres over all views keep their order."""
    flat = ((0.30, 0.30, 0.75), (0.55, 0.55, 0.785))
    things = [
        (box("plate", *flat, level_m=0.767), "red"),
        (box("plate", *flat, level_m=0.771), "blue"),
        (box("plate", *flat, level_m=0.769), "green"),
        (box(*DESK), "brown"),
    ]
    assert holders(things) == ["is-on brown", "is-on green", "is-on red", ""]


def test_books_side_by_side_lie_on_the_desk() -> None:
    things = [
        (box("book", (0.30, 0.30, 0.75), (0.55, 0.50, 0.79)), "red"),
        (box("book", (0.52, 0.30, 0.75), (0.77, 0.50, 0.82)), "green"),
        (box(*DESK), "brown"),
    ]
    assert holders(things) == ["is-on brown", "is-on brown", ""]


@pytest.mark.parametrize(
    ("above", "below", "held"),
    [
        # The rim hides the lower half of the apple; the bowl's box takes in the apple.
        (("apple", 0.83, 0.88), ("bowl", 0.75, 0.875), "is-at"),
        (("apple", 0.755, 0.865), ("plate", 0.75, 0.84), "is-on"),
        (("apple", 0.79, 0.89), ("book", 0.75, 0.84), "is-on"),
        (("bowl", 0.80, 0.88), ("bowl", 0.75, 0.86), "is-on"),
    ],
)
def test_only_a_container_has_things_in_it(
    above: tuple[str, float, float], below: tuple[str, float, float], held: str
) -> None:
    same = above[0] == below[0]
    (left, right) = (0.31, 0.48) if same else (0.35, 0.45)
    things = [
        (box(above[0], (left, left, above[1]), (right, right, above[2])), "red"),
        (box(below[0], (0.30, 0.30, below[1]), (0.50, 0.50, below[2])), "blue"),
        (box(*DESK), "brown"),
    ]
    assert holders(things) == [f"{held} blue", "is-on brown", ""]


def test_what_fills_a_box_lies_on_it() -> None:
    things = [
        (box("book", (0.30, 0.30, 1.00), (0.60, 0.55, 1.04)), "red"),
        (box("box", (0.28, 0.28, 0.75), (0.65, 0.62, 1.03)), "white"),
        (box(*DESK), "brown"),
    ]
    assert holders(things) == ["is-on white", "is-on brown", ""]


def test_nothing_is_near_or_in_its_own_class() -> None:
    chairs = [
        (box("chair", (0, 0, 0), (0.5, 0.5, 0.9)), "red"),
        (box("chair", (0.6, 0, 0), (1.1, 0.5, 0.9)), "blue"),
    ]
    boxes = [
        (box("box", (0, 3, 0), (0.8, 3.8, 0.6)), "red"),
        (box("box", (0.2, 3.2, 0.02), (0.6, 3.6, 0.5)), "blue"),
    ]
    assert pairs(chairs + boxes) == [[], [], [], []]
    table = (box("table", (0, 0.6, 0), (1.5, 1.5, 0.7)), "brown")
    near = [("is-near", "table")]
    assert pairs([*chairs, table]) == [near, near, [("is-near", "chair"), ("is-near", "chair")]]


def test_a_thing_is_never_in_what_is_smaller_on_the_ground() -> None:
    table = (box("side table", (0.0, 0.0, 0.0), (0.5, 0.5, 0.5)), "brown")
    statue = (box("statue", (0.1, 0.1, 0.0), (0.4, 0.4, 0.9)), "gray")
    assert ("is-at", "statue") not in pairs([table, statue])[0]


def test_furniture_is_not_near_small_things() -> None:
    chair = (box("chair", (0, 0, 0), (0.5, 0.5, 0.9)), "red")
    cup = (box("cup", (0.6, 0.1, 0.75), (0.7, 0.2, 0.85)), "white")
    keys = (box("key chain", (0.6, 0.3, 0.75), (0.65, 0.35, 0.77)), "gray")
    lamp = (box("floor lamp", (0.0, 0.6, 0.0), (0.3, 0.9, 1.6)), "black")
    by_chair = [("is-near", "chair")]
    assert pairs([chair, cup, keys]) == [[], by_chair, [*by_chair, ("is-near", "cup")]]
    assert pairs([chair, cup, keys, lamp])[0] == [("is-near", "floor lamp")]


def test_small_twins_are_told_apart_by_things_of_their_size() -> None:
    """Furniture comes first; what else is about as large follows, keys never."""
    cups = [
        (box("cup", (0.2, 0.2, 0.75), (0.3, 0.3, 0.85)), "white"),
        (box("cup", (1.3, 0.2, 0.75), (1.4, 0.3, 0.85)), "white"),
    ]
    around = [
        (box("plate", (0.35, 0.2, 0.75), (0.6, 0.45, 0.78)), "blue"),
        (box("bowl", (1.1, 0.2, 0.75), (1.28, 0.38, 0.85)), "green"),
        (box("key chain", (1.41, 0.2, 0.75), (1.44, 0.23, 0.77)), "gray"),
        (box("chair", (-0.5, 0.0, 0.0), (0.0, 0.5, 0.9)), "black"),
        (box(*DESK), "brown"),
    ]
    own = pairs(cups + around)[:2]
    assert own[0] == [("is-on", "desk"), ("is-near", "chair"), ("is-near", "plate")]
    assert own[1] == [("is-on", "desk"), ("is-near", "bowl")]


def told(thing: Found, *stated: tuple[Relation, int]) -> Found:
    """Return the thing with ``views`` views whose caption states each relation."""
    serial = 0
    for relation, views in stated:
        for _ in range(views):
            graph = ObjectGraph(thing.name, {}, [relation])
            sighting = Sighting(serial, "cam0", serial, (0, 0, 9, 9), 1.0, "", graph)
            thing.votes.add(sighting)
            serial += 1
    thing.hits = serial
    return thing


def test_captions_give_one_holder_and_no_landmark_of_the_own_class() -> None:
    bowl, desk = Relation("is-at", ObjectGraph("bowl")), Relation("is-on", ObjectGraph("desk"))
    apple = told(box("apple", (0, 0, 0), (0.1, 0.1, 0.1)), (desk, 4), (bowl, 6))
    assert captioned_relations(apple, 0.3) == [bowl]
    beside = Relation("is-near", ObjectGraph("apple"))
    apple = told(box("apple", (0, 0, 0), (0.1, 0.1, 0.1)), (desk, 4), (beside, 4))
    assert captioned_relations(apple, 0.3) == [desk]


def test_a_captioned_look_picks_the_holder_among_things_of_one_class() -> None:
    """Captions say purple; the boxes say orange, which lies below: captions win."""
    purple = ObjectGraph("book", {"color": "purple"})
    pile = [
        (box("book", (0.30, 0.30, 0.75), (0.60, 0.52, 0.88), level_m=0.83), "orange"),
        (box("book", (0.31, 0.31, 0.75), (0.60, 0.51, 0.87), level_m=0.82), "purple"),
    ]
    mug = box("mug", (0.40, 0.36, 0.86), (0.50, 0.45, 0.97))
    things = [(mug, "white"), *pile]
    graphs = graphs_of(things)

    def held(thing: Found) -> list[Relation]:
        found = [thing, *(one for one, _ in pile)]
        return relations_of(found, graphs, MapperSettings())[0]

    assert held(mug) == [Relation("is-on", graphs[1])]
    assert held(told(mug, (Relation("is-on", purple), 3))) == [Relation("is-on", graphs[2])]
    # A look that nothing there has is a caption's mistake: the map knows its things better.
    green = ObjectGraph("book", {"color": "green"})
    mug = box("mug", (0.40, 0.36, 0.86), (0.50, 0.45, 0.97))
    assert held(told(mug, (Relation("is-on", green), 3))) == [Relation("is-on", graphs[1])]


def test_what_is_on_a_desk_is_not_on_the_chair_that_stands_under_it() -> None:
    desk = (box("desk", (0.0, 0.0, 0.0), (1.6, 0.8, 0.9)), "brown")
    chair = (box("chair", (0.3, 0.3, 0.0), (0.9, 1.0, 0.76)), "black")
    laptop = (box("laptop", (0.5, 0.55, 0.73), (0.8, 0.85, 1.0)), "gray")
    assert holders([desk, chair, laptop]) == ["", "is-at brown", "is-on brown"]
    twin = (box("chair", (0.35, 0.35, 0.4), (0.85, 0.95, 0.9)), "red")
    assert pairs([desk, chair, twin])[2] == [("is-at", "desk")]  # never near one of its own class
    away = (box("chair", (0.3, 1.2, 0.0), (0.9, 1.9, 0.76)), "black")
    coat = (box("pillow", (0.4, 1.3, 0.45), (0.8, 1.7, 0.6)), "white")
    assert holders([desk, away, coat]) == ["", "", "is-on black"]


def test_what_lies_in_a_bowl_in_the_sink_lies_in_the_bowl() -> None:
    sink = (box("sink", (0.0, 0.0, 0.5), (0.6, 0.5, 0.9)), "gray")
    bowl = (box("bowl", (0.15, 0.1, 0.6), (0.45, 0.4, 0.78)), "blue")
    egg = (box("egg", (0.27, 0.22, 0.69), (0.33, 0.28, 0.73)), "white")
    assert holders([sink, bowl, egg]) == ["", "is-at gray", "is-at blue"]


def test_what_lies_past_the_seen_edge_of_a_counter_lies_on_it() -> None:
    counter = (box("counter top", (0.0, 0.6, 0.65), (1.8, 1.26, 1.07)), "black")
    mug = (box("mug", (1.52, 0.42, 0.92), (1.61, 0.54, 1.02)), "red")
    assert holders([counter, mug]) == ["", "is-on black"]
    for low_m, high_m in (
        ((1.52, 0.22, 0.92), (1.61, 0.34, 1.02)),  # too far from the edge
        ((1.52, 0.42, 0.70), (1.61, 0.54, 0.80)),  # too low
        ((1.52, 0.42, 1.20), (1.61, 0.54, 1.30)),  # too high
    ):
        assert holders([counter, (box("mug", low_m, high_m), "red")]) == ["", ""]
    bag = (box("box", (1.5, 0.3, 0.0), (1.8, 0.55, 0.95)), "brown")
    assert holders([counter, bag]) == ["", ""]  # it stands on the floor


def test_what_lies_past_two_edges_lies_on_the_nearest() -> None:
    left = (box("dresser", (0.0, 0.0, 0.0), (1.0, 0.5, 0.9)), "white")
    right = (box("dresser", (1.25, 0.0, 0.0), (2.2, 0.5, 0.9)), "black")
    vase = (box("vase", (1.04, 0.1, 0.88), (1.14, 0.2, 1.2)), "red")
    assert holders([left, right, vase]) == ["", "", "is-on white"]
    moved = (box("vase", (1.12, 0.1, 0.88), (1.2, 0.2, 1.2)), "red")
    assert holders([left, right, moved]) == ["", "", "is-on black"]
