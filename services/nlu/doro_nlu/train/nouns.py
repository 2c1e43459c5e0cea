"""Names of things: known words, compounds, measures ("glass of water") and invented words."""

from __future__ import annotations

from random import Random

from doro_nlu.train import lexicon as lex


def _words(text: str) -> list[str]:
    return text.split()


THINGS = tuple(dict.fromkeys(lex.AI2THOR + lex.COCO + lex.HOUSEHOLD))
COMMON = tuple(dict.fromkeys(lex.AI2THOR + lex.COCO))
_ONSETS = _words(
    """
    b bl br c ch cl d dr f fl g gl gr h j k l m n p pl pr qu r s sh sk sl sm sn sp st t
    tr v w z
    """
)
_VOWELS = _words(
    """
    a e i o u oo ee ea ai ou
    """
)
_CODAS = ["", "", *_words("b ck d f g l ll m n nd nk p r rt sh t x zz")]
_ENDINGS = ["", "", "", "er", "le", "ow", "et", "in", "on", "um", "ack", "a", "o"]


AMBIGUOUS = (
    "orange", "peach", "plum", "lime", "rose", "olive", "iron", "glass", "paper", "cloth", "tin",
    "cork", "china", "mint", "mustard", "salmon", "light", "glasses", "rubber", "straw", "stone",
    "papers", "oranges", "peaches", "top", "felt", "plastic bag", "silverware", "orange juice",
)  # fmt: skip
"""Things whose names are values elsewhere ("an orange")."""
_OF_ADJECTIVES = ("cold", "hot", "heated", "fresh", "sliced", "cooked", "chilled", "warm")


def invented(rng: Random) -> str:
    """Return a word that is none, so that unknown names work as names."""
    word = "".join(
        rng.choice(_ONSETS) + rng.choice(_VOWELS) + rng.choice(_CODAS)
        for _ in range(rng.choice((1, 1, 2, 2, 3)))
    )
    return word + rng.choice(_ENDINGS)


def compound(rng: Random) -> str:
    """Return a plausible noun-noun compound ("garden chair", "blork holder")."""
    first = invented(rng) if rng.random() < 0.2 else rng.choice(lex.COMPOUND_MODIFIERS)
    head = invented(rng) if rng.random() < 0.12 else rng.choice(lex.COMPOUND_HEADS)
    return f"{first} {head}" if first != head else head


def plural(name: str) -> str:
    """Return the plural of a name (of its head, which is the last word)."""
    if name in lex.PLURAL_ONLY or name.endswith("s"):
        return name
    if " of " in name:
        head, _, rest = name.partition(" of ")
        return f"{plural(head)} of {rest}"
    for ending, become in (("knife", "knives"), ("shelf", "shelves"), ("loaf", "loaves")):
        if name.endswith(ending):
            return name[: -len(ending)] + become
    if name.endswith("y") and name[-2:-1] not in "aeiou":
        return name[:-1] + "ies"
    return name + ("es" if name.endswith(("x", "ch", "sh", "z")) else "s")


def thing(rng: Random) -> str:  # noqa: PLR0911 - one line per source
    """Return the name of something that one may fetch."""
    roll = rng.random()
    if roll < 0.40:
        return rng.choice(COMMON)
    if roll < 0.66:
        return rng.choice(THINGS)
    if roll < 0.78:
        return compound(rng)
    if roll < 0.86:
        inner = f"{rng.choice(_OF_ADJECTIVES)} " if rng.random() < 0.1 else ""
        return f"{rng.choice(lex.MASS_OF)} of {inner}{rng.choice(lex.MASS)}"
    if roll < 0.875:
        return rng.choice(AMBIGUOUS)
    if roll < 0.97:
        return invented(rng)
    return rng.choice(lex.PLACES)


def place(rng: Random, kind: str) -> str:
    """Return the name of a landmark for a relation by its code (N, P or A)."""
    roll = rng.random()
    if kind == "A" and roll < 0.40:
        return rng.choice(lex.ROOMS)
    if kind == "N" and roll < 0.45:
        return thing(rng)
    if roll < 0.88:
        return rng.choice(lex.PLACES)
    if roll < 0.90:
        return rng.choice(lex.OF_FIXED)
    return thing(rng)
