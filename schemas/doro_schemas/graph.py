"""The object graph: one tree for what was said, what was seen and what is mapped.

Paper, Section IV-A: the root is the class of the object, self attributes hang on
it with their values, relational attributes lead to further object nodes.
"""

from __future__ import annotations

from collections.abc import Iterator

import msgspec

MAX_DEPTH = 8


class Relation(msgspec.Struct, frozen=True, omit_defaults=True):
    """A relational attribute: ``type`` (is-on, is-near, is-at) and the landmark.

    Attributes:
        type: the relation's type.
        target: the landmark.
        inverse: the relation runs from the landmark to the object: "the tray with the sponge
            on it" is a tray with ``is-on`` sponge, inverse, since the sponge is on the tray.
            Contents without a preposition ("a box with a cup") are inverse ``is-at``. On the
            wire the field stands only where it is true.
    """

    type: str
    target: ObjectGraph
    inverse: bool = False


class ObjectGraph(msgspec.Struct, frozen=True, omit_defaults=False):
    """An object and what is said of it.

    Attributes:
        name: class of the object; lower case, singular, no determiner ("cup").
        attributes: self attributes by type, for example ``{"color": "red"}``.
        relations: relational attributes, in the order of the text.
    """

    name: str
    attributes: dict[str, str] = {}
    relations: list[Relation] = []

    def __post_init__(self) -> None:
        if not self.name.strip():
            raise ValueError("an object graph needs a name, and this one is empty")
        if any(not key or not value for key, value in self.attributes.items()):
            raise ValueError(f"'{self.name}' has an attribute without a type or value")


def walk(graph: ObjectGraph) -> Iterator[ObjectGraph]:
    """Yield the nodes of a graph in pre-order: the object, then its landmarks."""
    yield graph
    for relation in graph.relations:
        yield from walk(relation.target)


def without_relations(graph: ObjectGraph) -> ObjectGraph:
    """Return the graph's identity in the map: class and self attributes."""
    return ObjectGraph(name=graph.name, attributes=dict(sorted(graph.attributes.items())))


def identity(graph: ObjectGraph) -> str:
    """Return the canonical text of class + self attributes, equal for equal things."""
    own = " ".join(f"{key}={value}" for key, value in sorted(graph.attributes.items()))
    return f"{graph.name}[{own}]"
