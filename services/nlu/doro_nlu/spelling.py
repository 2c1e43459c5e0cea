"""Misspelt colours and materials, repaired against closed lists."""

from __future__ import annotations

from functools import lru_cache

_COLORS = """
red green blue yellow white black brown gray grey orange pink purple silver gold golden beige cyan
magenta turquoise violet maroon navy teal tan cream olive lavender crimson scarlet indigo aqua
ivory khaki mauve peach rose ruby amber burgundy charcoal lilac mint mustard salmon plum lime
fuchsia auburn coral ochre emerald sapphire blonde blond rust reddish greenish bluish yellowish
brownish greyish grayish pinkish dark light bright pale deep sky neon pastel royal forest hot
colored coloured color colour transparent clear multicolored and
"""
_MATERIALS = """
wooden wood plastic metal metallic glass ceramic leather paper cardboard steel stainless iron cast
aluminum aluminium copper brass bronze porcelain clay stone marble granite concrete cotton wool
woolen woollen silk linen denim velvet suede fabric cloth rubber silicone bamboo wicker rattan
straw crystal chrome tin vinyl nylon polyester foam fur canvas oak pine mahogany teak walnut
plywood styrofoam wax cork enamel acrylic terracotta felt felted plush jute china titanium and
"""
VALUES = {"color": frozenset(_COLORS.split()), "material": frozenset(_MATERIALS.split())}
_LETTERS = "abcdefghijklmnopqrstuvwxyz"
_SHORTEST = 4
_LONGEST = 14
_REMEMBERED = 4096


@lru_cache(_REMEMBERED)
def repair(value: str, kind: str) -> str:
    """Return a lower-case value with each unknown word replaced by the one known word that is
    two letters swapped, a letter lost, added or replaced away (the first of these that fits);
    none or several such words: unchanged.

    Words of less than four letters are left alone: too many are a letter apart.
    """
    known = VALUES.get(kind)
    if known is None:
        return value
    return " ".join(_repair_word(word, known) for word in value.split(" "))


def _repair_word(word: str, known: frozenset[str]) -> str:
    if word in known or not _SHORTEST <= len(word) <= _LONGEST or not word.isalpha():
        return word
    halves = [(word[:at], word[at:]) for at in range(len(word) + 1)]
    slips = (
        {a + b[1] + b[0] + b[2:] for a, b in halves if len(b) > 1},
        {a + c + b for a, b in halves for c in _LETTERS},
        {a + b[1:] for a, b in halves if b},
        {a + c + b[1:] for a, b in halves if b for c in _LETTERS},
    )
    for near in slips:
        found = near & known
        if found:
            return next(iter(found)) if len(found) == 1 else word
    return word
