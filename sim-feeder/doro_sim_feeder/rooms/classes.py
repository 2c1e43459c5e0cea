"""The 21 classes of the evaluation, in one table.

The paper (Section V) names cup, laptop, sofa, book, pillow, chair and plant, mixes small,
medium and large, convex and non-convex things, and leaves out what always occurs exactly once
(television, fridge). The other fourteen are chosen by the same rule from iTHOR's types in
kitchens, living rooms and bedrooms: things of which a household has several, that can be
picked up or moved, that are told apart by colour, material or place, and that have a shape of
their own here (a mesh, or a superellipsoid for apple and pillow). Left out: fixtures (cabinet,
drawer, sink, window), what a kitchen has one of (toaster, microwave, kettle), cutlery and other
things of a centimetre or two, which depth at 300 px does not resolve (fork, key chain, pen).
"""

from __future__ import annotations

from typing import Literal

import msgspec

Size = Literal["small", "medium", "large"]
KITCHEN, LIVING, BEDROOM = "kitchens", "living_rooms", "bedrooms"


class EvaluatedClass(msgspec.Struct, frozen=True):
    """A class of the evaluation.

    Attributes:
        object_type: AI2-THOR's name; words and synonyms come from ``doro_schemas.vocabulary``.
        kinds: kinds of rooms in which copies are spawned: those where iTHOR has the class, and
            chairs, plants and books wherever people keep them.
        most: largest number of instances in a room of the set; large things need floor.
        named: the paper names it.
    """

    object_type: str
    size: Size
    convex: bool
    kinds: tuple[str, ...]
    most: int = 5
    named: bool = False


_K, _L, _KL, _ALL = (KITCHEN,), (LIVING,), (KITCHEN, LIVING), (KITCHEN, LIVING, BEDROOM)
_LB = (LIVING, BEDROOM)

CLASSES: tuple[EvaluatedClass, ...] = (
    EvaluatedClass("Cup", "small", True, _K, named=True),
    EvaluatedClass("Mug", "small", False, (KITCHEN, BEDROOM)),
    EvaluatedClass("Bowl", "small", False, _ALL),
    EvaluatedClass("Plate", "small", True, _KL),
    EvaluatedClass("Bottle", "small", True, _K),
    EvaluatedClass("Apple", "small", True, _K),
    EvaluatedClass("Vase", "small", True, _ALL),
    EvaluatedClass("Book", "small", True, _ALL, named=True),
    EvaluatedClass("CellPhone", "small", True, _ALL),
    EvaluatedClass("RemoteControl", "small", True, _LB),
    EvaluatedClass("Statue", "small", False, _ALL),
    EvaluatedClass("Laptop", "medium", False, _LB, named=True),
    EvaluatedClass("Pillow", "medium", True, _LB, named=True),
    EvaluatedClass("Box", "medium", True, _LB),
    EvaluatedClass("DeskLamp", "medium", False, _LB),
    EvaluatedClass("HousePlant", "medium", False, _ALL, named=True),
    EvaluatedClass("Stool", "medium", False, _ALL, most=4),
    EvaluatedClass("Chair", "large", False, _ALL, named=True),
    EvaluatedClass("SideTable", "large", False, _ALL, most=4),
    EvaluatedClass("ArmChair", "large", False, _LB, most=4),
    EvaluatedClass("Sofa", "large", False, _LB, most=3, named=True),
)
BY_TYPE = {item.object_type: item for item in CLASSES}
