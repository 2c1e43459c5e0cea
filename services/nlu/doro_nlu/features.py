"""Words to numbers: the input of the Bi-LSTM, the same in training and in use."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

WORD_CHARS = 20
PAD, UNKNOWN, BEGIN, END = 0, 1, 2, 3
FIRST_FREE = 4


def char_ids(word: str, chars: Mapping[str, int]) -> list[int]:
    """Return ``WORD_CHARS`` character ids of a word; of a long one its two ends."""
    room = WORD_CHARS - 2
    if len(word) > room:
        word = word[: room // 2] + word[-(room - room // 2) :]
    ids = [BEGIN, *(chars.get(char, UNKNOWN) for char in word), END]
    return ids + [PAD] * (WORD_CHARS - len(ids))


def encode(
    sentences: Sequence[Sequence[str]], words: Mapping[str, int], chars: Mapping[str, int]
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int32]]:
    """Return word ids (b, t), character ids (b, t, WORD_CHARS) and lengths (b,).

    Case is dropped.
    """
    longest = max(len(tokens) for tokens in sentences)
    word_ids = np.zeros((len(sentences), longest), np.int64)
    letters = np.zeros((len(sentences), longest, WORD_CHARS), np.int64)
    for row, tokens in enumerate(sentences):
        for column, token in enumerate(tokens):
            lower = token.lower()
            word_ids[row, column] = words.get(lower, UNKNOWN)
            letters[row, column] = char_ids(lower, chars)
    lengths = np.array([len(tokens) for tokens in sentences], np.int32)
    return word_ids, letters, lengths
