"""The tokenizer of the annotation guide: words with inner - ' /, free clitics, single marks."""

from __future__ import annotations

import re

_TOKEN = re.compile(r"\w+(?:[-'/]\w+)*|'(?:s|t|re|d|ll|ve|m)\b|[^\w\s]", re.IGNORECASE)
_APOSTROPHES = str.maketrans({"\u2019": "'", "\u2018": "'", "\u02bc": "'", "\u2010": "-"})


def tokenize(text: str) -> list[str]:
    """Return the tokens of a text, as they are written.

    ``yellow-handled``, ``that's`` and ``baby's`` are one token, a free ``'s`` is one, and so is
    every punctuation mark. Typographic apostrophes and hyphens count as the plain ones.
    """
    return _TOKEN.findall(text.translate(_APOSTROPHES))
