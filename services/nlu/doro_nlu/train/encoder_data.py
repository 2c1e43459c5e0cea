"""Training data of the encoder: word pieces kept, arrays, and the mix of the sources."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from random import Random
from typing import NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray

from doro_nlu.labels import LABELS
from doro_nlu.train.annotate import Example
from doro_nlu.train.stream import batches
from doro_nlu.train.weak import read_labelled
from doro_nlu.wordpiece import SPECIALS, rows_of, split_word

SMOOTHING = 0.02
"""Share of a hard label given to all labels alike."""


class Target(NamedTuple):
    """A sentence with the wanted probability of each label, (t, labels) float32."""

    tokens: list[str]
    wanted: NDArray[np.float32]


def read_pieces(path: Path) -> tuple[list[str], list[int]]:
    """Return the pieces kept (special ones first, then printable ASCII) and their rows."""
    lines = path.read_text(encoding="utf-8").splitlines()
    rows = {piece: row for row, piece in enumerate(lines)}
    kept = [p for p in lines if p.isascii() and not (p.startswith("[") and len(p) > 1)]
    names = [*SPECIALS, *kept]
    return names, [rows[name] for name in names]


def hard(example: Example, labels: Sequence[str] = LABELS) -> Target:
    """Return a labelled sentence as a target, smoothed.

    Raises:
        ValueError: a label that is not among ``labels``.
    """
    wanted = np.full((len(example.labels), len(labels)), SMOOTHING / len(labels), np.float32)
    for row, label in enumerate(example.labels):
        wanted[row, labels.index(label)] += 1 - SMOOTHING
    return Target(example.tokens, wanted)


def arrays(
    targets: Sequence[Target], pieces: Mapping[str, int]
) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    """Return pieces (b, p), mask (b, p) and wanted probabilities (b, p, labels).

    Only a word's first piece carries a label; elsewhere the probabilities are all zero.
    """
    split = [[split_word(token, pieces) for token in target.tokens] for target in targets]
    rows, owners = rows_of(split)
    wanted = np.zeros((*rows.pieces.shape, targets[0].wanted.shape[1]), np.float32)
    done = [0] * len(targets)
    for row, (owner, firsts) in enumerate(zip(owners, rows.firsts, strict=True)):
        at = done[owner]
        wanted[row, firsts] = targets[owner].wanted[at : at + len(firsts)]
        done[owner] += len(firsts)
    return torch.from_numpy(rows.pieces), torch.from_numpy(rows.mask), torch.from_numpy(wanted)


def mixed(seed: int, size: int, human: Sequence[Target], share: float) -> Iterator[list[Target]]:
    """Yield batches of the generator and, with probability ``share``, of human sentences."""
    source, rng = batches(seed, size), Random(seed + 2)
    groups = _grouped(human, size, rng) if human else None
    while True:
        if groups is not None and rng.random() < share:
            yield next(groups)
        else:
            yield [hard(example) for example in next(source)]


def _grouped(human: Sequence[Target], size: int, rng: Random) -> Iterator[list[Target]]:
    """Yield endless batches of sentences of like length, each sentence once per round."""
    while True:
        order = sorted(human, key=lambda item: len(item.tokens) + rng.random() * 4)
        starts = list(range(0, len(order), size))
        rng.shuffle(starts)
        for start in starts:
            yield order[start : start + size]


def write_soft(path: Path, targets: Sequence[Target]) -> None:
    """Write sentences with a teacher's probabilities (16-bit)."""
    np.savez(
        path,
        tokens=np.array("\n".join("\t".join(target.tokens) for target in targets)),
        wanted=np.concatenate([target.wanted for target in targets]).astype(np.float16),
    )


def read_soft(path: Path) -> list[Target]:
    """Return what ``write_soft`` wrote."""
    with np.load(path, allow_pickle=False) as content:
        lines = str(content["tokens"]).split("\n")
        wanted = content["wanted"].astype(np.float32)
    found, at = [], 0
    for line in lines:
        tokens = line.split("\t")
        found.append(Target(tokens, wanted[at : at + len(tokens)]))
        at += len(tokens)
    return found


def read_human(paths: list[Path]) -> list[Target]:
    """Return human sentences with weak labels (JSON lines) or a teacher's probabilities (npz)."""
    found: list[Target] = []
    for path in paths:
        if path.suffix == ".npz":
            found += read_soft(path)
        else:
            found += [hard(example) for example in read_labelled(path)]
    return found
