"""Canonical words: the one table in which two words mean the same thing.

DESIGN, "Conventions of meaning": couch/sofa, gray/grey, wooden/wood, tv/television and
fridge/refrigerator are the same; cup/mug, sofa/arm chair, watch/alarm clock and dark
blue/light blue are not. A hypernym is satisfied by its kinds, not the reverse.
"""

from __future__ import annotations

import functools
import re

CACHED = 8192

SAME_NAME = {
    "couch": "sofa",
    "settee": "sofa",
    "tv": "television",
    "tele": "television",
    "telly": "television",
    "tv monitor": "television",
    "tvmonitor": "television",
    "tv set": "television",
    "television set": "television",
    "fridge": "refrigerator",
    "armchair": "arm chair",
    "cellphone": "cell phone",
    "mobile phone": "cell phone",
    "smartphone": "cell phone",
    "smart phone": "cell phone",
    "remote": "remote control",
    "tv remote": "remote control",
    "tv remote control": "remote control",
    "television remote": "remote control",
    "laptop computer": "laptop",
    "trash can": "garbage can",
    "trashcan": "garbage can",
    "dustbin": "garbage can",
    "dust bin": "garbage can",
    "trash bin": "garbage can",
    "garbage bin": "garbage can",
    "rubbish bin": "garbage can",
    "waste bin": "garbage can",
    "houseplant": "house plant",
    "potted plant": "house plant",
    "pottedplant": "house plant",
    "pot plant": "house plant",
    "coffee maker": "coffee machine",
    "coffeemaker": "coffee machine",
    "bath tub": "bathtub",
    "book shelf": "bookshelf",
    "book case": "bookcase",
    "bed side table": "bedside table",
    "counter": "counter top",
    "countertop": "counter top",
    "nightstand": "night stand",
    "diningtable": "dining table",
    "motorbike": "motorcycle",
    "aeroplane": "airplane",
}
SAME_VALUE = {
    "grey": "gray",
    "greyish": "grayish",
    "silvery": "silver",
    "aluminium": "aluminum",
    "wooden": "wood",
    "metallic": "metal",
    "golden": "gold",
    "woolen": "wool",
    "woollen": "wool",
    "leathery": "leather",
    "glassy": "glass",
    "plastics": "plastic",
}
IRREGULAR_PLURAL = {
    "knives": "knife",
    "shelves": "shelf",
    "bookshelves": "bookshelf",
    "loaves": "loaf",
    "leaves": "leaf",
    "scarves": "scarf",
    "halves": "half",
    "wolves": "wolf",
    "mice": "mouse",
    "geese": "goose",
    "buses": "bus",
    "gases": "gas",
    "lenses": "lens",
    "canvases": "canvas",
    "axes": "axe",
    "quizzes": "quiz",
    "heroes": "hero",
    "mangoes": "mango",
    "tvs": "tv",
    "people": "person",
    "men": "man",
    "women": "woman",
    "children": "child",
    "feet": "foot",
    "teeth": "tooth",
    "cacti": "cactus",
    "cookies": "cookie",
    "brownies": "brownie",
    "movies": "movie",
    "hoodies": "hoodie",
    "smoothies": "smoothie",
    "veggies": "veggie",
}
PAIRS = frozenset(
    """
    scissors glasses sunglasses goggles pants jeans trousers shorts tights leggings pajamas skis
    tongs pliers binoculars headphones
    """.split()  # noqa: SIM905 - a list of quoted words is harder to read and to extend
)
"""Things that are a pair, named in the plural: "a pair of scissors"."""

NO_SINGULAR = PAIRS | frozenset(
    """
    glass dress brass grass canvas bus gas lens compass mattress cactus chess news series clothes
    apparatus walrus plus less thermos trellis iris tennis christmas stairs blinds keys
    """.split()  # noqa: SIM905
)

DRINKS = frozenset(["wine", "drinking", "shot", "champagne", "water", "beer", "cocktail", "juice"])
"""Glasses to drink from; other "glasses" are a pair of them and have no singular."""


def singular(word: str) -> str:
    """Return the singular of one English noun; a word that is none comes back as it is."""
    if word in IRREGULAR_PLURAL:
        return IRREGULAR_PLURAL[word]
    if word in NO_SINGULAR or len(word) < 4 or not word.endswith("s"):
        return word
    if word.endswith(("ss", "us", "is")):
        return word
    if word.endswith("ies") and len(word) > 5:
        return word[:-3] + "y"
    if re.search(r"(ss|sh|ch|x|zz|to)es$", word):
        return word[:-2]
    return word[:-1]


@functools.lru_cache(maxsize=CACHED)
def canonical_name(name: str) -> str:
    """Return the canonical class name: lower case, singular head noun, one synonym.

    The head is the last word, or the last one before "of" ("chest of drawers").
    """
    head, of, rest = re.sub(r"[\s_]+", " ", name.strip().lower()).partition(" of ")
    words = head.split(" ")
    drinking = words[-1] == "glasses" and (of or (words[-2:-1] and words[-2] in DRINKS))
    words[-1] = "glass" if drinking else singular(words[-1])
    text = " ".join(words) + of + rest
    return SAME_NAME.get(text, text)


def canonical_value(value: str) -> str:
    """Return the canonical form of an attribute's value ("dark grey" -> "dark gray")."""
    words = re.sub(r"[\s_-]+", " ", value.strip().lower()).split(" ")
    return " ".join(SAME_VALUE.get(word, word) for word in words)


def split_camel_case(object_type: str) -> str:
    """Return AI2-THOR's objectType as words: ``"CoffeeTable"`` -> ``"coffee table"``.

    ``"TVStand"`` -> ``"tv stand"``.
    """
    return re.sub(r"(?<=[a-z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", " ", object_type).lower()


@functools.lru_cache(maxsize=CACHED)
def name_satisfies(said: str, seen: str) -> bool:
    """Tell whether a thing called ``seen`` is what ``said`` names.

    Equal canonical names satisfy; so does a kind of the thing said, where the kind's
    name ends in it as whole words ("lamp" by "desk lamp"), never the reverse.
    """
    want, have = canonical_name(said), canonical_name(seen)
    return want == have or have.endswith(" " + want)
