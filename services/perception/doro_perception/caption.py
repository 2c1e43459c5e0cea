"""The surface form of a caption: from a graph to "a red plastic cup on the wooden table"."""

from __future__ import annotations

import re

from doro_schemas.errors import Refused
from doro_schemas.graph import ObjectGraph

PREPOSITION = {"is-on": "on", "is-near": "near", "is-at": "in"}
VALUE_BEFORE_NOUN = {"wood": "wooden"}
# English order: opinion, size, shape, ... before colour, material last.
LAST_ATTRIBUTES = ("color", "material")
# Plural or uncountable head nouns take no "a".
NO_ARTICLE = frozenset(
    {
        "binoculars",
        "blinds",
        "bread",
        "clothes",
        "foil",
        "footwear",
        "glasses",
        "headphones",
        "jeans",
        "keys",
        "pants",
        "pliers",
        "scissors",
        "stairs",
        "tongs",
    }
)
VOWEL_SOUND = re.compile(r"^(?!uni|use|usu|ute|eu|one\b|once\b)[aeiou]|^hour|^honest|^heir")


def article(phrase: str, noun: str) -> str:
    """Return "a ", "an " or nothing for a noun phrase with head noun ``noun``."""
    if noun.rsplit(" ", maxsplit=1)[-1] in NO_ARTICLE or noun == "toilet paper":
        return ""
    return "an " if VOWEL_SOUND.match(phrase) else "a "


def noun_phrase(graph: ObjectGraph) -> str:
    """Return the attributes and the noun: "red plastic cup"; relations are left aside."""
    others = sorted(key for key in graph.attributes if key not in LAST_ATTRIBUTES)
    kinds = [*others, *(key for key in LAST_ATTRIBUTES if key in graph.attributes)]
    values = [graph.attributes[kind] for kind in kinds]
    return " ".join([*(VALUE_BEFORE_NOUN.get(value, value) for value in values), graph.name])


def caption(graph: ObjectGraph, joiner: str = "") -> str:
    """Return the caption of an object and its direct landmarks.

    Args:
        graph: names and values in canonical words; a landmark's own relations are not said.
        joiner: word between two relations, for example "and"; empty for none.

    Raises:
        Refused: a relation type that has no English form here.
    """
    phrase = noun_phrase(graph)
    parts = []
    for relation in graph.relations:
        preposition = PREPOSITION.get(relation.type)
        if preposition is None:
            raise Refused(
                f"relation type '{relation.type}' of '{graph.name}' has no words in a caption:"
                f" known are {', '.join(PREPOSITION)}; send it with perception.emit = 'graphs'"
            )
        parts.append(f"{preposition} the {noun_phrase(relation.target)}")
    said = (f" {joiner} " if joiner else " ").join(parts)
    return f"{article(phrase, graph.name)}{phrase} {said}".rstrip()
