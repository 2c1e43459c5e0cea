"""Endless batches of generated sentences."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from random import Random

from doro_nlu.train.annotate import Example
from doro_nlu.train.generate import Generator


def batches(seed: int, size: int) -> Iterator[list[Example]]:
    """Yield endless batches of fresh sentences, sorted by length within a chunk."""
    source = iter(Generator(seed))
    order = Random(seed + 1)
    while True:
        chunk = sorted(itertools.islice(source, size * 32), key=lambda e: len(e.tokens))
        groups = [chunk[start : start + size] for start in range(0, len(chunk), size)]
        order.shuffle(groups)
        yield from groups
