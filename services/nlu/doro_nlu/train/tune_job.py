"""What a fine-tuning run is asked to do."""

from __future__ import annotations

from pathlib import Path

import msgspec


class Job(msgspec.Struct, frozen=True, kw_only=True):
    """What to tune and how.

    Attributes:
        data: the labelled sentences, ``.jsonl`` or BIO.
        out: directory to write, made if need be.
        model: directory of the encoder to start from; None = the shipped default.
        extend: learn types that the tagger does not know.
        steps, batch, rate, seed: of the training.
    """

    data: Path
    out: Path
    model: Path | None = None
    extend: bool = False
    steps: int = 200
    batch: int = 16
    rate: float = 1e-4
    seed: int = 7
