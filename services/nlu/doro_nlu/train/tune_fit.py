"""The training inside ``doro_nlu.train.tune``: from the weights of an ONNX model to a new one."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from random import Random

import numpy as np
import torch

from doro_nlu.encoder import Pieces
from doro_nlu.onnx_files import MODEL_FILE
from doro_nlu.train.annotate import Example
from doro_nlu.train.encoder_data import Target, arrays, hard
from doro_nlu.train.encoder_export import export_int8, load_weights, write_vocabulary
from doro_nlu.train.encoder_model import Encoder
from doro_nlu.train.fit import Plan, fit
from doro_nlu.train.graph import Weights, layers_of, read_weights
from doro_nlu.train.stream import batches
from doro_nlu.train.tune_data import Split
from doro_nlu.train.tune_job import Job
from doro_nlu.wordpiece import ROW_PIECES
from doro_schemas.errors import Refused

_HEAD_BOOST = 10.0


def model_of(path: Path, n_labels: int) -> Encoder:
    """Return the network of an ONNX model, its head widened for new labels.

    Raises:
        Refused: a model that was not written by this project's encoder training.
    """
    weights = read_weights(path)
    if "positions.w" not in weights or not layers_of(weights):
        raise Refused(f"{path} is no encoder of doro_nlu.train: start from the shipped default")
    pieces, hidden = weights["words.w"].shape
    model = Encoder(pieces, ROW_PIECES, n_labels, layers=layers_of(weights), hidden=hidden,
                    inner=weights["l0.up.b"].shape[0])  # fmt: skip
    load_weights(model, weights | _widened(weights, n_labels))
    return model


def _widened(weights: Weights, n_labels: int) -> Weights:
    """Return the head with zero weights and a low bias for labels that it does not have."""
    new = n_labels - weights["head.b"].shape[0]
    return {
        "head.w": np.pad(weights["head.w"], ((0, 0), (0, new))),
        "head.b": np.pad(weights["head.b"], (0, new), constant_values=-4.0),
    }


def new_words(examples: Sequence[Example], known: Sequence[str]) -> frozenset[str]:
    """Return the words (lower case) that carry a label of a new type."""
    return frozenset(
        token.lower()
        for example in examples
        for token, label in zip(example.tokens, example.labels, strict=True)
        if label not in known
    )


def without(target: Target, words: frozenset[str]) -> Target:
    """Return a generated sentence in which some words do not count.

    The generator labels "small" O; to a user with the type size it is none.
    """
    for row, token in enumerate(target.tokens):
        if token.lower() in words:
            target.wanted[row] = 0.0
    return target


def own_and_generated(
    own: list[Target], generated: Iterator[list[Target]], size: int, seed: int
) -> Iterator[list[Target]]:
    """Yield batches of own sentences and of generated ones in turns."""
    rng = Random(seed)
    while True:
        yield rng.choices(own, k=size)
        yield next(generated)


def train(
    job: Job, start: Path, vocabulary: Pieces, labels: Sequence[str], parts: Split
) -> list[str]:
    """Train on the first part of the user's sentences, write the int8 model; return the log."""
    torch.set_num_threads(1)
    torch.manual_seed(job.seed)
    model = model_of(start / MODEL_FILE, len(labels))
    own = [hard(example, labels) for example in parts.train]
    fresh = new_words(parts.train, vocabulary.labels)
    generated = ([without(hard(example, labels), fresh) for example in batch]
                 for batch in batches(job.seed, job.batch))  # fmt: skip
    pieces = {piece: index for index, piece in enumerate(vocabulary.pieces)}

    def run(batch: list[Target]) -> tuple[torch.Tensor, torch.Tensor]:
        ids, mask, wanted = arrays(batch, pieces)
        return model(ids, mask), wanted

    log = [f"seed {job.seed} steps {job.steps} batch {job.batch} rate {job.rate}"
           f" own sentences {len(own)} torch {torch.__version__}"]  # fmt: skip
    source = own_and_generated(own, generated, job.batch, job.seed)
    plan = Plan(job.steps, job.rate, save_every=0, head_boost=_HEAD_BOOST)
    fit(model, run, source, plan, out=job.out, log=log)
    export_int8(model, job.out / MODEL_FILE, vocabulary.pieces, own)
    log.append(f"sha256 {write_vocabulary(job.out, vocabulary.pieces, labels)}")
    return log
