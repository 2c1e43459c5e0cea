"""Slips of the keyboard in an answer: two letters swapped, one missing, one doubled.

Only towards words that the answer may hold here (colors, materials, what was observed, the
words of an answer itself), only where exactly one of them is so near, and never away from a
word that is one itself ("old" is not "gold"). Other letters are not guessed: "pen" is no "pan".
"""

from __future__ import annotations

import re
from functools import lru_cache

from doro_dialogue.act_words import COLORS, MATERIALS
from doro_dialogue.facts import words

ANSWERING = words(
    "the one ones other first second third fourth last left right middle near next from both"
    " either neither none never mind forget yes not that top inside beside behind under bring"
    " take mean meant with and please"
)
REAL = words(
    "able amp ark back bass bras brow cap clot cram ear fist form god ink ion lack lap lass lather"
    " lay let line live meal meta old pie pin range ream self sin sliver tale tea tone ton woo"
    " can get got put let see say had him her his she you are was for but any all who why how use"
    " out off our two six ten may yet way day now new far too did does done make made"
    " tan tin pan pen bed bread read reed own ow eel tee sand hand has was saw on no rear bear"
)
MIN_LETTERS = 3


def mended(said: str, known: frozenset[str]) -> str:
    """Return an answer with such slips repaired.

    Args:
        said: lower case.
        known: words that were observed, and the class asked about.
    """
    return re.sub(r"[a-z]{3,}", lambda found: _word(found.group(), known), said)


@lru_cache(4096)
def _word(word: str, known: frozenset[str]) -> str:
    wanted = ANSWERING | COLORS | MATERIALS | known
    if word in wanted or word in REAL or word.removesuffix("s") in wanted:
        return word
    near = [one for one in _slips(word) if one in wanted]
    near += sorted(one for one in wanted if _misses_one(word, one))
    return near[0] if len(set(near)) == 1 else word


def _slips(word: str) -> list[str]:
    """Return the words of which this one is a swap of neighbors or has a letter doubled."""
    swapped = [word[:i] + word[i + 1] + word[i] + word[i + 2 :] for i in range(len(word) - 1)]
    single = [word[:i] + word[i + 1 :] for i in range(1, len(word)) if word[i] == word[i - 1]]
    return [one for one in (*swapped, *single) if len(one) >= MIN_LETTERS and one != word]


def _misses_one(word: str, full: str) -> bool:
    """Tell whether a word is another one of four letters or more without one of them."""
    if len(full) != len(word) + 1 or len(full) <= MIN_LETTERS:
        return False
    return any(full[:i] + full[i + 1 :] == word for i in range(len(full)))
