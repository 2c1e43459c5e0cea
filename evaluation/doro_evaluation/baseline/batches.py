"""Training batches: examples as pieces, sorted by length so that little is padding."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import msgspec
import numpy as np
from numpy.typing import NDArray

from doro_evaluation.baseline.text import BEGIN, PAD, Vocabulary
from doro_nlu.tokens import tokenize
from doro_nlu.wordpiece import SPECIALS, split_word

FREQUENT = 1500
"""Most frequent whole words of the base vocabulary that are kept besides those of the data."""
POOL = 4096
FIRST_WORD = 1996
"""Where BERT's vocabulary begins to list words, the most frequent first."""


class Line(msgspec.Struct, frozen=True):
    """What training reads of a line of ``make_data``."""

    configuration: str
    state: str
    instruction: str
    captions: list[list[str]]
    target: str


class Batch(NamedTuple):
    """Input (n, p), mask (n, p), and what is written (n, t): begin first, end last."""

    pieces: NDArray[np.int64]
    mask: NDArray[np.float32]
    written: NDArray[np.int64]


def read_lines(path: Path) -> list[Line]:
    """Return the examples of a file of ``make_data``."""
    decoder = msgspec.json.Decoder(Line)
    with path.open("rb") as file:
        return [decoder.decode(line) for line in file]


def thinned(lines: Sequence[Line], share: float, seed: int) -> list[Line]:
    """Return the examples with a share of those whose captions of all views are joined."""
    draws = np.random.default_rng(seed).random(len(lines))
    return [
        line
        for line, draw in zip(lines, draws, strict=True)
        if line.configuration != "captions joined" or draw < share
    ]


def build_vocabulary(lines: Sequence[Line], base: Sequence[str]) -> tuple[list[str], list[int]]:
    """Return the pieces kept and their rows in the base vocabulary.

    Kept are the pieces of all words of the data, of the single ASCII characters (so that every
    English word can be spelt), and the most frequent words.
    """
    table = {name: row for row, name in enumerate(base)}
    words = {word for line in lines for word in _words(line)}
    wanted = {piece for word in words for piece in split_word(word, table)}
    wanted |= {row for name, row in table.items() if _single(name)}
    plain = [row for row in range(FIRST_WORD, len(base)) if base[row].isascii()]
    wanted |= set([row for row in plain if base[row].isalpha()][:FREQUENT])
    rows = sorted(wanted - {table[name] for name in SPECIALS} - {1})
    kept = [table[name] for name in SPECIALS] + rows
    return [base[row] for row in kept], kept


def batches(
    lines: Sequence[Line], vocabulary: Vocabulary, tokens: int, seed: int
) -> Iterator[Batch]:
    """Yield batches without end, of at most ``tokens`` places with padding, shuffled by seed."""
    rng = np.random.default_rng(seed)
    while True:
        order = rng.permutation(len(lines))
        for start in range(0, len(order), POOL):
            pool = [_coded(lines[k], vocabulary) for k in order[start : start + POOL]]
            pool.sort(key=lambda pair: (len(pair[0]), len(pair[1])))
            groups = list(_groups(pool, tokens))
            for k in rng.permutation(len(groups)):
                yield _arrays(groups[k])


Coded = tuple[list[int], list[int]]


def _coded(line: Line, vocabulary: Vocabulary) -> Coded:
    written = [BEGIN, *vocabulary.target(line.target)]
    return vocabulary.input(line.captions, line.instruction), written


def _groups(pool: Sequence[Coded], tokens: int) -> Iterator[list[Coded]]:
    group: list[Coded] = []
    longest = [0, 0]
    for pair in pool:
        grown = [max(a, len(b)) for a, b in zip(longest, pair, strict=True)]
        if group and sum(grown) * (len(group) + 1) > tokens:
            yield group
            group, grown = [], [len(pair[0]), len(pair[1])]
        group.append(pair)
        longest = grown
    if group:
        yield group


def _arrays(group: Sequence[Coded]) -> Batch:
    pieces = _padded([pair[0] for pair in group])
    return Batch(pieces, (pieces != PAD).astype(np.float32), _padded([pair[1] for pair in group]))


def _padded(rows: Sequence[Sequence[int]]) -> NDArray[np.int64]:
    table = np.full((len(rows), max(map(len, rows))), PAD, np.int64)
    for number, row in enumerate(rows):
        table[number, : len(row)] = row
    return table


def _words(line: Line) -> list[str]:
    captions = [caption for view in line.captions for caption in view]
    return tokenize(" ".join([line.instruction, line.target, *captions]))


def _single(name: str) -> bool:
    plain = name.removeprefix("##")
    return len(plain) == 1 and plain.isascii() and (plain.isalnum() or not name.startswith("##"))
