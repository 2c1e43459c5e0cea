"""The vocabulary: every word of the lexicon and the frames, no invented or misspelt one."""

from __future__ import annotations

import string

from doro_nlu.features import FIRST_FREE
from doro_nlu.tokens import tokenize
from doro_nlu.train import lexicon as lex
from doro_nlu.train.fillers import WORDS
from doro_nlu.train.generate import Generator
from doro_nlu.train.nouns import THINGS, plural

_SAMPLE = 20_000
_MIN_COUNT = 12


def build_words(seed: int) -> dict[str, int]:
    """Return word -> id, sorted; ids below ``FIRST_FREE`` are reserved."""
    words: set[str] = set()
    for name in THINGS + lex.PLACES + lex.ROOMS + lex.COMPOUND_HEADS + lex.MASS + lex.MASS_OF:
        words.update(tokenize(name.lower()), tokenize(plural(name).lower()))
    for name in lex.COMPOUND_MODIFIERS + lex.COLORS + lex.SHADES + lex.MATERIALS + lex.ADJECTIVES:
        words.update(tokenize(name.lower()))
    for slot, phrases in WORDS.items():
        if slot != "foreign":
            words.update(token for phrase in phrases for token in tokenize(phrase.lower()))
    counts: dict[str, int] = {}
    source = iter(Generator(seed + 1000))
    for _ in range(_SAMPLE):
        for token in next(source).tokens:
            counts[token.lower()] = counts.get(token.lower(), 0) + 1
    foreign = {token for phrase in WORDS["foreign"] for token in tokenize(phrase.lower())}
    words.update(w for w, n in counts.items() if n >= _MIN_COUNT and w not in foreign)
    return {word: FIRST_FREE + index for index, word in enumerate(sorted(words))}


def build_chars() -> dict[str, int]:
    """Return character -> id for lower-case ASCII; all others are unknown."""
    known = string.ascii_lowercase + string.digits + string.punctuation
    return {char: FIRST_FREE + index for index, char in enumerate(known)}
