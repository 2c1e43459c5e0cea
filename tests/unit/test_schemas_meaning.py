"""The shared words and the shared geometric rule."""

from __future__ import annotations

import pytest

from doro_schemas.graph import ObjectGraph, Relation, identity, walk
from doro_schemas.spatial import Box3, relation_between
from doro_schemas.vocabulary import (
    canonical_name,
    canonical_value,
    name_satisfies,
    split_camel_case,
)


@pytest.mark.parametrize(
    ("said", "canonical"),
    [
        ("Couch", "sofa"),
        ("couches", "sofa"),
        ("TV", "television"),
        ("fridge", "refrigerator"),
        ("wine glasses", "wine glass"),
        ("knives", "knife"),
        ("reading glasses", "reading glasses"),
        ("boxes", "box"),
        ("potatoes", "potato"),
        ("berries", "berry"),
        ("glass", "glass"),
        ("scissors", "scissors"),
        ("  remote  ", "remote control"),
        ("cup", "cup"),
        ("mug", "mug"),
        ("vases", "vase"),
        ("buses", "bus"),
    ],
)
def test_canonical_names(said: str, canonical: str) -> None:
    assert canonical_name(said) == canonical


@pytest.mark.parametrize(
    ("said", "canonical"), [("Dark Grey", "dark gray"), ("wooden", "wood"), ("red", "red")]
)
def test_canonical_values(said: str, canonical: str) -> None:
    assert canonical_value(said) == canonical


@pytest.mark.parametrize(
    ("said", "seen", "satisfied"),
    [
        ("lamp", "desk lamp", True),
        ("desk lamp", "lamp", False),
        ("table", "dining tables", True),
        ("cup", "mug", False),
        ("sofa", "couch", True),
        ("sofa", "arm chair", False),
        ("pan", "saucepan", False),
    ],
)
def test_a_hypernym_is_satisfied_by_its_kinds_not_the_reverse(
    said: str, seen: str, satisfied: bool
) -> None:
    assert name_satisfies(said, seen) is satisfied


def test_object_types_become_words() -> None:
    assert split_camel_case("CoffeeTable") == "coffee table"
    assert split_camel_case("TVStand") == "tv stand"
    assert split_camel_case("Mug") == "mug"


def box(center: tuple[float, float, float], size: tuple[float, float, float]) -> Box3:
    return Box3(center, size)


TABLE = box((0.0, 0.0, 0.375), (1.2, 0.8, 0.75))
MUG = (0.1, 0.1, 0.1)


@pytest.mark.parametrize(
    ("center", "relation"),
    [
        ((0.0, 0.0, 0.80), "is-on"),
        ((0.0, 0.0, 0.84), "is-on"),  # 4 cm of air: depth noise
        ((0.0, 0.0, 1.20), "is-near"),  # on a shelf above it
        ((0.0, 0.0, 1.60), None),
        ((0.0, 0.0, 0.05), "is-at"),  # under it
        ((0.9, 0.0, 0.70), "is-near"),
        ((1.3, 0.0, 0.70), None),
    ],
)
def test_a_mug_and_a_table(center: tuple[float, float, float], relation: str | None) -> None:
    assert relation_between(box(center, MUG), TABLE) == relation


def test_an_apple_in_a_bowl_is_in_it() -> None:
    bowl = box((0.0, 0.0, 0.8), (0.3, 0.3, 0.1))
    assert relation_between(box((0.0, 0.0, 0.81), (0.08, 0.08, 0.08)), bowl) == "is-at"


def test_identity_does_not_hang_on_the_order_of_attributes() -> None:
    one = ObjectGraph("cup", {"color": "red", "material": "glass"})
    other = ObjectGraph("cup", {"material": "glass", "color": "red"})
    assert identity(one) == identity(other)
    assert identity(one) != identity(ObjectGraph("cup", {"color": "red"}))


def test_walk_is_pre_order() -> None:
    on, near = ObjectGraph("table"), ObjectGraph("sink")
    graph = ObjectGraph("cup", {}, [Relation("is-on", on), Relation("is-near", near)])
    assert [node.name for node in walk(graph)] == ["cup", "table", "sink"]
