"""Training data of the encoder: word pieces kept, arrays, and the mix of the two sources."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from random import Random

import numpy as np
import torch

from doro_nlu.train.__main__ import IGNORED, LABEL_IDS, batches
from doro_nlu.train.annotate import Example
from doro_nlu.wordpiece import SPECIALS, rows_of, split_word


def read_pieces(path: Path) -> tuple[list[str], list[int]]:
    """Return the pieces kept (special ones first, then printable ASCII) and their rows."""
    lines = path.read_text(encoding="utf-8").splitlines()
    rows = {piece: row for row, piece in enumerate(lines)}
    kept = [p for p in lines if p.isascii() and not (p.startswith("[") and len(p) > 1)]
    names = [*SPECIALS, *kept]
    return names, [rows[name] for name in names]


def arrays(
    examples: list[Example], pieces: dict[str, int]
) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    """Return pieces, mask and label ids (b, p); only a word's first piece carries a label."""
    split = [[split_word(token, pieces) for token in example.tokens] for example in examples]
    rows, owners = rows_of(split)
    wanted = np.full(rows.pieces.shape, IGNORED, np.int64)
    done = [0] * len(examples)
    for row, (owner, firsts) in enumerate(zip(owners, rows.firsts, strict=True)):
        for place in firsts:
            wanted[row, place] = LABEL_IDS[examples[owner].labels[done[owner]]]
            done[owner] += 1
    return torch.from_numpy(rows.pieces), torch.from_numpy(rows.mask), torch.from_numpy(wanted)


def mixed(seed: int, size: int, weak: list[Example], every: int) -> Iterator[list[Example]]:
    """Yield batches of the generator, every ``every``-th one of weakly labelled sentences."""
    source, rng = batches(seed, size), Random(seed + 2)
    count = 0
    while True:
        count += 1
        if weak and every and count % every == 0:
            yield rng.choices(weak, k=size)
        else:
            yield next(source)
