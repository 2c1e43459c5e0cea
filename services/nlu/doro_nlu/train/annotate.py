"""Bracket notation to tokens and labels: ``"the {C green} {O cup} {A in} the {R sink}"``."""

from __future__ import annotations

import re
from typing import NamedTuple

from doro_nlu.tokens import tokenize

CODES = {
    "O": "object",
    "R": "related",
    "C": "color",
    "M": "material",
    "N": "is-near",
    "P": "is-on",
    "A": "is-at",
}
_PART = re.compile(r"\{([ORCMNPA]) ([^{}]*)\}|([^{}]+)")


class Example(NamedTuple):
    """A labelled sentence: tokens and BIO labels, of equal length."""

    tokens: list[str]
    labels: list[str]


def annotate(text: str) -> Example:
    """Return the labelled sentence of a bracketed text (the annotation guide's notation).

    Raises:
        ValueError: a bracket that is not closed or has an unknown letter.
    """
    tokens: list[str] = []
    labels: list[str] = []
    end = 0
    for part in _PART.finditer(text):
        if part.start() != end:
            break
        end = part.end()
        words = tokenize(part[2] if part[1] else part[3])
        tokens += words
        if part[1]:
            kind = CODES[part[1]]
            labels += [f"{'I' if index else 'B'}-{kind}" for index in range(len(words))]
        else:
            labels += ["O"] * len(words)
    if end != len(text):
        raise ValueError(f"bad bracket at character {end} of '{text}'")
    return Example(tokens, labels)
