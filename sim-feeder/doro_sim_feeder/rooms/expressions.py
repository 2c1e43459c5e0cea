"""Instructions about what is in a room: referring expressions in verb templates (paper, V-A).

For each class present, three types as in the paper: a self attribute, a self attribute and a
relation, the name only. They say what is true of a visible instance. Beside these stand
instructions about what is not so (a value that no instance has; a class that is absent), so
that all four states occur. What follows from them is decided elsewhere, on the same truth.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import msgspec
import numpy as np

from doro_schemas.graph import ObjectGraph, Relation
from doro_schemas.vocabulary import canonical_name, name_satisfies, split_camel_case
from doro_sim_feeder.rooms.appearance import NATURAL_COLOR, PALETTE
from doro_sim_feeder.rooms.classes import BY_TYPE, CLASSES
from doro_sim_feeder.rooms.parts import stable_number
from doro_sim_feeder.rooms.truth import TrueInstance

Kind = Literal["self", "self_relation", "name"]
Variant = Literal["true", "other_value", "absent"]
KINDS: tuple[Kind, ...] = ("self", "self_relation", "name")
CARRYING = (
    "pick up {}", "take {}", "bring {}", "bring me {}", "get {}", "get me {}", "fetch {}",
    "fetch me {}", "grab {}", "give me {}", "hand me {}", "find {}",
)  # fmt: skip
# "go to" is not among them: what it names is a destination, not an object to be brought.
GOING = ("find {}", "look for {}", "find me {}", "show me {}")
RELATION_WORDS = {
    "is-on": ("on", "on top of"),
    "is-near": ("near", "next to", "beside"),
    "is-at": ("in", "inside"),
}
ADJECTIVES = {"wood": "wooden"}


class Expression(msgspec.Struct, frozen=True):
    """An instruction and what it says.

    Attributes:
        kind: the paper's type; variant: whether it is true of an instance.
        text: the instruction; task: its verb phrase.
        graph: the true input graph.
        about: object_id of the instance that it was made from; empty for ``absent``.
    """

    id: str
    object_type: str
    kind: Kind
    variant: Variant
    text: str
    task: str
    graph: ObjectGraph
    about: str


def visible(instances: Sequence[TrueInstance]) -> list[TrueInstance]:
    """Return what is seen in at least one view (``MIN_VISIBLE_PX`` pixels or more)."""
    return [item for item in instances if item.views > 0]


def name_of(object_type: str) -> str:
    """Return a class as a person says it: ``"HousePlant"`` -> ``"house plant"``."""
    return canonical_name(split_camel_case(object_type))


def true_graph(item: TrueInstance) -> ObjectGraph:
    """Return all that is true of an instance as its object graph."""
    return ObjectGraph(
        name=name_of(item.object_type),
        attributes=item.attributes,
        relations=[
            Relation(r.type, ObjectGraph(name_of(r.object_type), r.attributes))
            for r in item.relations
        ],
    )


def expressions(episode: str, instances: Sequence[TrueInstance]) -> list[Expression]:
    """Return the instructions for a room, the same for the same episode and truth."""
    seen = visible(instances)
    made: list[Expression] = []
    absent = []
    for row in CLASSES:
        of_class = [item for item in seen if item.object_type == row.object_type]
        rng = np.random.default_rng(stable_number(f"{episode}|{row.object_type}"))
        if of_class:
            made += _Maker(episode, row.object_type, rng).true_ones(of_class, seen)
        elif not any(_is_kind_of(row.object_type, item) for item in instances):
            absent.append(row.object_type)
    if absent:
        rng = np.random.default_rng(stable_number(f"{episode}|absent"))
        kind = absent[int(rng.integers(len(absent)))]
        made += _Maker(episode, kind, rng).absent_ones()
    return made


def _is_kind_of(object_type: str, item: TrueInstance) -> bool:
    """Tell whether an instance may be called by a class's name (an arm chair is a chair)."""
    return name_satisfies(name_of(object_type), name_of(item.object_type))


class _Maker:
    """Makes the instructions about one class in one room."""

    def __init__(self, episode: str, object_type: str, rng: np.random.Generator) -> None:
        self._episode, self._type, self._rng = episode, object_type, rng

    def true_ones(self, of_class: list[TrueInstance], seen: list[TrueInstance]) -> list[Expression]:
        """Return one instruction of each type, and one with a value that no instance has."""
        found = []
        for kind in KINDS:
            item = of_class[self._draw(len(of_class))]
            attributes = {} if kind == "name" else self._attribute(item)
            relations = self._relation(item) if kind == "self_relation" else []
            if (kind != "name" and not attributes) or (kind == "self_relation" and not relations):
                continue  # nothing to say it with: an instance without attributes or landmark
            graph = ObjectGraph(name_of(self._type), attributes, relations)
            found.append(self._said(kind, "true", graph, item.object_id))
        false = self._false_color([item for item in seen if _is_kind_of(self._type, item)])
        if false:
            graph = ObjectGraph(name_of(self._type), {"color": false})
            about = of_class[self._draw(len(of_class))].object_id
            found.append(self._said("self", "other_value", graph, about))
        return found

    def absent_ones(self) -> list[Expression]:
        """Return instructions for a class that is not in the room."""
        color = str(self._rng.choice(list(PALETTE)))
        graphs: list[tuple[Kind, ObjectGraph]] = [
            ("name", ObjectGraph(name_of(self._type))),
            ("self", ObjectGraph(name_of(self._type), {"color": color})),
        ]
        return [self._said(kind, "absent", graph, "") for kind, graph in graphs]

    def _draw(self, count: int) -> int:
        return int(self._rng.integers(count))

    def _attribute(self, item: TrueInstance) -> dict[str, str]:
        names = sorted(item.attributes)
        if not names:
            return {}
        name = names[self._draw(len(names))]
        return {name: item.attributes[name]}

    def _relation(self, item: TrueInstance) -> list[Relation]:
        usable = [r for r in item.relations if r.type in RELATION_WORDS]
        if not usable:
            return []
        one = usable[self._draw(len(usable))]
        return [Relation(one.type, ObjectGraph(name_of(one.object_type)))]

    def _false_color(self, may_be_meant: list[TrueInstance]) -> str:
        own = [item.attributes.get("color") for item in may_be_meant]
        if self._type in NATURAL_COLOR or None in own:
            return ""
        others = [name for name in PALETTE if name not in own]
        return others[self._draw(len(others))] if others else ""

    def _said(self, kind: Kind, variant: Variant, graph: ObjectGraph, about: str) -> Expression:
        templates = GOING if BY_TYPE[self._type].size == "large" else CARRYING
        template = templates[self._draw(len(templates))]
        phrase = self._phrase(graph)
        return Expression(
            id=f"{self._episode}/{self._type}/{kind}/{variant}",
            object_type=self._type,
            kind=kind,
            variant=variant,
            text=template.format(phrase),
            task=template.removesuffix(" {}").removesuffix(" me"),
            graph=graph,
            about=about,
        )

    def _phrase(self, graph: ObjectGraph) -> str:
        values = [graph.attributes[key] for key in ("color", "material") if key in graph.attributes]
        noun = " ".join([*(ADJECTIVES.get(value, value) for value in values), graph.name])
        article = ("an" if noun[0] in "aeiou" else "a") if self._draw(2) else "the"
        words = [article, noun]
        for relation in graph.relations:
            choices = RELATION_WORDS[relation.type]
            words += [choices[self._draw(len(choices))], "the", relation.target.name]
        return " ".join(words)
