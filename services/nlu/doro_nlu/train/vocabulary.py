"""The Bi-LSTM's vocabulary: words of the generator, of the human sentences, and frequent ones."""

from __future__ import annotations

import string
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from doro_nlu.features import FIRST_FREE
from doro_nlu.tokens import tokenize
from doro_nlu.train import lexicon as lex
from doro_nlu.train.fillers import FOREIGN_PARTS, WORDS
from doro_nlu.train.generate import Generator
from doro_nlu.train.more_fillers import MORE_WORDS
from doro_nlu.train.nouns import THINGS, plural

FREQUENT = 12_000
"""Most frequent words of GloVe taken, whether our data has them or not."""
_SAMPLE = 20_000
_MIN_COUNT = 12
_MIN_HUMAN = 2


class Sentence(Protocol):
    """What has tokens."""

    @property
    def tokens(self) -> list[str]: ...


def _foreign() -> set[str]:
    phrases = (*WORDS["foreign"], *FOREIGN_PARTS)
    return {token for phrase in phrases for token in tokenize(phrase.lower())}


def build_words(seed: int, human: Sequence[Sentence]) -> list[str]:
    """Return the words of our data, sorted: of lexicon and frames, none invented or misspelt."""
    words: set[str] = set()
    for name in THINGS + lex.PLACES + lex.ROOMS + lex.COMPOUND_HEADS + lex.MASS + lex.MASS_OF:
        words.update(tokenize(name.lower()), tokenize(plural(name).lower()))
    for name in lex.COMPOUND_MODIFIERS + lex.COLORS + lex.SHADES + lex.MATERIALS + lex.ADJECTIVES:
        words.update(tokenize(name.lower()))
    for slot, phrases in (WORDS | MORE_WORDS).items():
        if slot != "foreign":
            words.update(token for phrase in phrases for token in tokenize(phrase.lower()))
    source = iter(Generator(seed + 1000))
    made = _counted(next(source).tokens for _ in range(_SAMPLE))
    written = _counted(sentence.tokens for sentence in human)
    foreign = _foreign() - words
    words.update(w for w, n in made.items() if n >= _MIN_COUNT and w not in foreign)
    words.update(w for w, n in written.items() if n >= _MIN_HUMAN and w not in foreign)
    return sorted(words)


def _counted(sentences: Iterable[Sequence[str]]) -> dict[str, int]:
    counts: dict[str, int] = {}
    for tokens in sentences:
        for token in tokens:
            counts[token.lower()] = counts.get(token.lower(), 0) + 1
    return counts


def read_glove(directory: Path, words: Sequence[str]) -> tuple[dict[str, int], NDArray[np.float32]]:
    """Return word -> id for the words that GloVe has and its frequent ones, and their vectors.

    Ids below ``FIRST_FREE`` are reserved; the vectors (n, 50) are in the order of the ids.
    """
    import pyarrow.parquet  # type: ignore[import-untyped, import-not-found, unused-ignore] # noqa: PLC0415 - only this needs it

    table = pyarrow.parquet.read_table(directory / "glove_6B_index.parquet")
    rows = {str(word): row for row, word in enumerate(table.column(0).to_pylist())}
    frequent = [word for word in list(rows)[:FREQUENT] if word.isascii() and word.isalpha()]
    foreign = _foreign() - set(words)
    chosen = sorted({word for word in words if word in rows} | set(frequent) - foreign)
    vectors = np.load(directory / "glove_6B_50d_emb.npy", mmap_mode="r")
    found = np.array(vectors[[rows[word] for word in chosen]], np.float32)
    return {word: FIRST_FREE + index for index, word in enumerate(chosen)}, found


def build_chars() -> dict[str, int]:
    """Return character -> id for lower-case ASCII; all others are unknown."""
    known = string.ascii_lowercase + string.digits + string.punctuation
    return {char: FIRST_FREE + index for index, char in enumerate(known)}
