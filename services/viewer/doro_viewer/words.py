"""Short English for graphs, for labels that people read at a glance."""

from __future__ import annotations

from doro_schemas.graph import ObjectGraph

_FIRST = ("color", "material")
_PREPOSITION = {"is-on": "on", "is-near": "near", "is-at": "at"}


def noun_phrase(graph: ObjectGraph) -> str:
    """Return class and self attributes in English order ("red plastic cup")."""
    kinds = [kind for kind in _FIRST if kind in graph.attributes]
    kinds += sorted(kind for kind in graph.attributes if kind not in _FIRST)
    return " ".join([*(graph.attributes[kind] for kind in kinds), graph.name])


def short_description(graph: ObjectGraph, relations: int = 2) -> str:
    """Return the noun phrase and its first relations ("red cup on white table")."""
    parts = [noun_phrase(graph)]
    for relation in graph.relations[:relations]:
        preposition = _PREPOSITION.get(relation.type, relation.type.removeprefix("is-"))
        if relation.inverse:
            preposition = "with"
        parts.append(f"{preposition} {noun_phrase(relation.target)}")
    return " ".join(parts)
