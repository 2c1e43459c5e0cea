"""Closed word classes that reading a dependency tree needs; English."""

from __future__ import annotations

from doro_nlu.spelling import VALUES
from doro_nlu.words import COMPANIONS as _COMPANIONS
from doro_nlu.words import FETCH_VERBS as FETCH
from doro_nlu.words import PRONOUNS as ONES
from doro_nlu.words import THIRD

__all__ = ["FETCH", "ONES", "THIRD", "kind_of_relation", "kind_of_value"]


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


NOUNS = ("NOUN", "PROPN")
WRAPPERS = _words(
    "want like need wish mind try help let go come please manage happen remember know tell see"
    " wonder"
)
"""Verbs around the request: "I would like you to bring ..."."""

WANTS = _words("want like need wish mind")
SOUGHT = {
    "look": ("for", "at"), "search": ("for",), "point": ("at", "to"), "reach": ("for",),
    "ask": ("for",), "hunt": ("for",), "go": ("for",), "dispose": ("of",),
}  # fmt: skip
"""Verbs whose object stands behind a preposition."""

PLACED = _words("be find look where see locate")
"""Predicates whose "on the table" says where the thing is, beside those that fetch."""

CONTAINERS = _words(
    """
    bottle glass bar roll box bowl can piece slice pair chest set loaf sheet bunch pack packet jar
    bag mug cup plate stack pot carton head block tube stick handful bit deck
    """
)
"""Nouns that with "of" name one thing: "glass of water"."""

COMPANIONS = _COMPANIONS
HOLDING = _words("hold contain carry have")
PARTS = _words("handle leg wheel edge button cap sleeve arm stripe dot pattern label door screen")
"""Parts: "with a black handle" is said of the thing itself."""

LIGHT = _words("front top left right side middle corner edge back end center centre bottom")
CLOSE = _words("close closest nearest next adjacent")
ADVERBS = _words("right directly just immediately currently still")
TOWARDS = _words("to into onto towards toward for")
SHADES = _words("dark light bright pale deep sky navy neon pastel royal forest hot")
MATERIALS = VALUES["material"] - {"and"}
COLORS = VALUES["color"] - {"and", "colored", "coloured", "color", "colour", "clear"}
_FRUIT = _words("orange rose peach plum lime salmon olive mint mustard cream rust coral")
LEXICAL = frozenset(
    [
        "paper towel", "paper towels", "wine glass", "paper roll", "glass cleaner", "straw hat",
        "paper clip", "tin opener", "paper plane", "glass case", "stone age", "iron board",
    ]
)  # fmt: skip
"""Compounds in which the material names no material."""

_NEAR = _words(
    "near beside by next between behind against opposite facing across around along close closest"
    " nearest"
)
_ON = _words("on upon atop")
_AT = _words("at in inside from off out under below above down underneath beneath within over")


def kind_of_value(word: str, *, is_compound: bool) -> str:
    """Return ``color``, ``material`` or "" for a modifier."""
    if word in COLORS and not (is_compound and word in _FRUIT):
        return "color"
    return "material" if word in MATERIALS else ""


def kind_of_relation(connector: str) -> str:
    """Return the type that a connector stands for, by the guide's rules 4 to 6, or ""."""
    words = connector.split(" ")
    if words[0] == "from" and len(words) > 1:
        return kind_of_relation(" ".join(words[1:])) or "is-at"
    if words[0] in _NEAR or any(word in ("front", "left", "right", "behind") for word in words):
        return "is-on" if "side" in words and words[0] == "on" else "is-near"
    if words[0] in _ON:
        return "is-near" if "hand" in words else "is-on"
    return "is-at" if words[0] in _AT else ""
