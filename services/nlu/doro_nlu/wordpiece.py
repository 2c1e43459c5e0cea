"""WordPiece on top of the word tokens: the encoder's input, in training and in use."""

from __future__ import annotations

import unicodedata
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

PAD, UNKNOWN, BEGIN, END = 0, 1, 2, 3
SPECIALS = ("[PAD]", "[UNK]", "[CLS]", "[SEP]")
WORD_PIECES = 24
"""Pieces kept of one word."""
ROW_PIECES = 128
"""Positions of the model, begin and end included; longer sentences go in several rows."""


class Rows(NamedTuple):
    """A batch: piece ids (b, p) int64, mask (b, p) float32 (1 = a piece), and per row the
    positions of the first piece of each word."""

    pieces: NDArray[np.int64]
    mask: NDArray[np.float32]
    firsts: list[list[int]]


def split_word(word: str, pieces: Mapping[str, int]) -> list[int]:
    """Return the ids of a word's pieces, at least one; case and accents are dropped.

    Greedy longest match as in BERT (uncased); an inner mark ("yellow-handled") is a piece of its
    own, and a part that the table cannot spell is one unknown piece.
    """
    plain = "".join(
        char
        for char in unicodedata.normalize("NFD", word.lower())
        if not unicodedata.combining(char)
    )
    ids: list[int] = []
    part = ""
    for char in plain:
        if char.isalnum() or char == "_":
            part += char
        else:
            ids += [*_split_part(part, pieces), pieces.get(char, UNKNOWN)]
            part = ""
    ids += _split_part(part, pieces)
    return ids[:WORD_PIECES] or [UNKNOWN]


def _split_part(part: str, pieces: Mapping[str, int]) -> list[int]:
    if len(part) > 60:  # no word of English; the search below is quadratic
        return [UNKNOWN]
    ids: list[int] = []
    start = 0
    while start < len(part):
        prefix = "##" if start else ""
        for end in range(len(part), start, -1):
            found = pieces.get(prefix + part[start:end])
            if found is not None:
                ids.append(found)
                start = end
                break
        else:
            return [UNKNOWN]
    return ids


def rows_of(sentences: Sequence[Sequence[Sequence[int]]]) -> tuple[Rows, list[int]]:
    """Return the batch of sentences given as pieces per word, and the sentence of each row.

    A sentence of more than ``ROW_PIECES`` pieces is cut between words.
    """
    rows: list[list[int]] = []
    firsts: list[list[int]] = []
    owners: list[int] = []
    for owner, words in enumerate(sentences):
        rows.append([BEGIN])
        firsts.append([])
        owners.append(owner)
        for ids in words:
            if len(rows[-1]) + len(ids) >= ROW_PIECES:
                rows.append([BEGIN])
                firsts.append([])
                owners.append(owner)
            firsts[-1].append(len(rows[-1]))
            rows[-1] += ids
    longest = max(len(row) for row in rows) + 1
    pieces = np.full((len(rows), longest), PAD, np.int64)
    mask = np.zeros((len(rows), longest), np.float32)
    for index, row in enumerate(rows):
        pieces[index, : len(row) + 1] = [*row, END]
        mask[index, : len(row) + 1] = 1.0
    return Rows(pieces, mask, firsts), owners
