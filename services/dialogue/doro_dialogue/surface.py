"""English for object graphs: the paper's annotated edges walked in pre-order (Section IV-C).

Self attributes stand left of the noun, relations right of it; is-on becomes "on top of",
is-near "near", is-at "in", color and material become nothing but their values. An inverse relation
is said as "with the sponge on it", "with the apple".
"""

from __future__ import annotations

from collections.abc import Sequence

from doro_dialogue.facts import (
    ATTRIBUTE_ORDER,
    IS_AT,
    IS_ON,
    MATERIAL,
    Attribute,
    Fact,
    facts_of,
    name_of,
    value_of,
    words,
)
from doro_schemas.graph import ObjectGraph, Relation
from doro_schemas.vocabulary import IRREGULAR_PLURAL, PAIRS

RELATION_WORDS = {"is-on": "on top of", "is-near": "near", "is-at": "in"}
FLAT = words("table desk top counter island floor wall window door")
"""Landmarks that nothing is in: "from the table" comes back as "at the table"."""

NUMBERS = (
    *("no", "one", "two", "three", "four", "five", "six"),
    *("seven", "eight", "nine", "ten", "eleven", "twelve"),
)
SET = words("clothes blinds stairs keys chess")
UNCOUNTED = words("bread lettuce soap water milk coffee tea food furniture cutlery paper clothing")
SAME_PLURAL = words("series news apparatus")
ADJECTIVE = {"wood": "wooden", "wool": "woolen", "gold": "golden"}
PLURAL_OF = {one: many for many, one in IRREGULAR_PLURAL.items()}


def count_word(count: int) -> str:
    """Return a number in words up to twelve, in digits above."""
    return NUMBERS[count] if count < len(NUMBERS) else str(count)


def plural(name: str) -> str:
    """Return the plural of a class name ("wine glass", "roll of toilet paper", "knife")."""
    head, of, rest = name.partition(" of ")
    *before, word = head.split(" ")
    return " ".join([*before, _plural_word(word)]) + of + rest


def is_plural(name: str) -> bool:
    """Tell whether a class name is a plural by itself ("scissors")."""
    return name.rsplit(" ", maxsplit=1)[-1] in PAIRS | SET


def counted(graph: ObjectGraph, count: int = 1, *, other: bool = False, alike: bool = True) -> str:
    """Return "one red cup on top of the table", "two identical red cups", "one other cup"."""
    before = [count_word(count)]
    if other:
        before.append("other")
    if alike and count > 1 and graph.attributes:
        before.append("identical")
    return _phrase(before, graph, count)


def definite(graph: ObjectGraph) -> str:
    """Return "the red cup on top of the table"."""
    return " ".join(["the", *_adjectives(graph), _name(graph), *_right(graph)])


def indefinite(graph: ObjectGraph) -> str:
    """Return "a red cup", "an orange cup", "any bread", "a pair of scissors"."""
    if _name(graph).split(" ")[-1] in UNCOUNTED:
        return " ".join(["any", *_adjectives(graph), _name(graph), *_right(graph)])
    body = _phrase([], graph, 1)
    return f"{_article(body)} {body}"


def without_article(graph: ObjectGraph) -> str:
    """Return "red cup on top of the table", for use after "no"."""
    return " ".join([*_adjectives(graph), _name(graph), *_right(graph)])


def predicate(facts: Sequence[Fact]) -> str:
    """Return what follows "it is": "blue, made of wood and on top of the desk"."""
    return listed([_predicate(fact) for fact in facts])


def listed(parts: Sequence[str], last: str = " and ") -> str:
    """Return a list of words in English: "a", "a and b", "a, b and c"."""
    return last.join([", ".join(parts[:-1]), parts[-1]]) if len(parts) > 1 else "".join(parts)


def _phrase(before: list[str], graph: ObjectGraph, count: int) -> str:
    """Join determiners, adjectives, noun and relations; pairs and sets get their measure."""
    name = _name(graph)
    measure = "pair" if name.split(" ")[-1] in PAIRS else "set" if is_plural(name) else ""
    if measure:
        before = [*before, measure if count == 1 else measure + "s", "of"]
    noun = name if measure or count == 1 else plural(name)
    return " ".join([*before, *_adjectives(graph), noun, *_right(graph)])


def _name(graph: ObjectGraph) -> str:
    return name_of(graph.name)


def _adjectives(graph: ObjectGraph) -> list[str]:
    """Return the self attributes in English order: others, then color, then material."""
    known = [key for key in ATTRIBUTE_ORDER if key in graph.attributes]
    others = sorted(key for key in graph.attributes if key not in ATTRIBUTE_ORDER)
    values = [(key, value_of(graph.attributes[key])) for key in (*others, *known)]
    return [ADJECTIVE.get(value, value) if key == MATERIAL else value for key, value in values]


def _right(graph: ObjectGraph) -> list[str]:
    """Return the relations; several are joined, so that the second is not the landmark's."""
    relations = [fact for fact in facts_of(graph) if isinstance(fact, Relation)]
    return [listed([_relation(relation) for relation in relations])] if relations else []


def _relation(relation: Relation) -> str:
    if relation.inverse:
        where = " on it" if relation.type == IS_ON else ""
        return f"with {definite(relation.target)}{where}"
    open_type = relation.type.removeprefix("is-").replace("-", " ")
    if relation.type == IS_AT and _name(relation.target).split(" ")[-1] in FLAT:
        return f"at {definite(relation.target)}"
    return f"{RELATION_WORDS.get(relation.type, open_type)} {definite(relation.target)}"


def _predicate(fact: Fact) -> str:
    if isinstance(fact, Attribute):
        value = value_of(fact.value)
        return f"made of {value}" if fact.type == MATERIAL else value
    return f"the one {_relation(fact)}" if fact.inverse else _relation(fact)


def _plural_word(word: str) -> str:
    if word in PLURAL_OF:
        return PLURAL_OF[word]
    if word in SAME_PLURAL:
        return word
    if word.endswith("y") and word[-2:-1] not in "aeiou":
        return word[:-1] + "ies"
    if word.endswith(("s", "sh", "ch", "x", "z")) or word in ("tomato", "potato"):
        return word + "es"
    return word + "s"


def _article(phrase: str) -> str:
    silent = phrase.startswith(("hour", "honest", "heir"))
    spoken = phrase.startswith(("one", "uni", "use", "eu"))
    return "an" if (phrase[:1] in "aeiou" and not spoken) or silent else "a"
