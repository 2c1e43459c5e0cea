"""One command trains and exports: ``python -m doro_nlu.train --seed 7 --out DIR``."""

from __future__ import annotations

import argparse
import hashlib
import itertools
import math
import time
from collections.abc import Iterator
from pathlib import Path
from random import Random

import msgspec
import numpy as np
import torch
from torch import nn

from doro_nlu.features import FIRST_FREE, encode
from doro_nlu.labels import LABELS
from doro_nlu.tagger import MODEL_FILE, VOCABULARY_FILE, BiLstmTagger, Vocabulary
from doro_nlu.train.annotate import Example
from doro_nlu.train.card import write_card
from doro_nlu.train.evaluate import Report, evaluate, held_out_examples, read_gold
from doro_nlu.train.export import export, parity
from doro_nlu.train.generate import Generator
from doro_nlu.train.model import BiLstm
from doro_nlu.train.vocabulary import build_chars, build_words

LABEL_IDS = {label: index for index, label in enumerate(LABELS)}
IGNORED = -100


def batches(seed: int, size: int) -> Iterator[list[Example]]:
    """Yield endless batches of fresh sentences, sorted by length within a chunk."""
    source = iter(Generator(seed))
    order = Random(seed + 1)
    while True:
        chunk = sorted(itertools.islice(source, size * 32), key=lambda e: len(e.tokens))
        groups = [chunk[start : start + size] for start in range(0, len(chunk), size)]
        order.shuffle(groups)
        yield from groups


def targets(batch: list[Example], length: int) -> torch.Tensor:
    """Return label ids (b, t), padding ignored."""
    ids = np.full((len(batch), length), IGNORED, np.int64)
    for row, example in enumerate(batch):
        ids[row, : len(example.labels)] = [LABEL_IDS[label] for label in example.labels]
    return torch.from_numpy(ids)


def train(arguments: argparse.Namespace, log: list[str]) -> tuple[BiLstm, Vocabulary]:
    """Return the trained network and its vocabulary; ``log`` gets a line per 200 steps."""
    words, chars = build_words(arguments.seed), build_chars()
    torch.manual_seed(arguments.seed)
    model = BiLstm(len(words) + FIRST_FREE, len(chars) + FIRST_FREE, len(LABELS))
    optimizer = torch.optim.AdamW(model.parameters(), lr=arguments.rate, weight_decay=1e-4)
    loss_of = nn.CrossEntropyLoss(ignore_index=IGNORED, label_smoothing=0.02)
    source = batches(arguments.seed, arguments.batch)
    total, began, running = arguments.steps, time.monotonic(), 0.0
    for step in range(total):
        warm = min(1.0, (step + 1) / 200)
        for group in optimizer.param_groups:
            group["lr"] = arguments.rate * warm * 0.5 * (1 + math.cos(math.pi * step / total))
        batch = next(source)
        arrays = encode([example.tokens for example in batch], words, chars)
        logits = model(*(torch.from_numpy(array) for array in arrays))
        loss = loss_of(logits.flatten(0, 1), targets(batch, logits.shape[1]).flatten())
        optimizer.zero_grad()
        loss.backward()
        nn.utils.clip_grad_norm_(model.parameters(), 1.0)
        optimizer.step()
        running += float(loss.detach())
        if step % 200 == 199:
            elapsed_s = time.monotonic() - began
            log.append(f"step {step + 1} of {total} loss {running / 200:.4f} ({elapsed_s:.0f} s)")
            print(log[-1], flush=True)
            running = 0.0
    return model, Vocabulary(list(LABELS), list(words), list(chars))


def main() -> None:
    """Train, export, check parity, evaluate and write the model card."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--steps", type=int, default=4000)
    parser.add_argument("--batch", type=int, default=64)
    parser.add_argument("--rate", type=float, default=3e-3)
    parser.add_argument("--gold", type=Path, help="labelled human sentences, measured only")
    arguments = parser.parse_args()
    torch.set_num_threads(1)
    torch.use_deterministic_algorithms(True)
    log = [f"seed {arguments.seed} steps {arguments.steps} batch {arguments.batch}"
           f" rate {arguments.rate} torch {torch.__version__}"]  # fmt: skip
    model, vocabulary = train(arguments, log)
    model.eval()
    out: Path = arguments.out
    out.mkdir(parents=True, exist_ok=True)
    export(model, out / MODEL_FILE, len(LABELS))
    digest = hashlib.sha256((out / MODEL_FILE).read_bytes()).hexdigest()
    vocabulary = msgspec.structs.replace(vocabulary, model_sha256=digest)
    (out / VOCABULARY_FILE).write_bytes(msgspec.json.encode(vocabulary) + b"\n")
    held_out = held_out_examples(arguments.seed)
    words = {word: FIRST_FREE + i for i, word in enumerate(vocabulary.words)}
    chars = {char: FIRST_FREE + i for i, char in enumerate(vocabulary.chars)}
    sample = encode([example.tokens for example in held_out[:64]], words, chars)
    difference = parity(model, out / MODEL_FILE, *sample)
    if difference > 1e-4:
        raise SystemExit(f"ONNX differs from torch by {difference}: the export is wrong")
    tagger = BiLstmTagger(out)
    reports: dict[str, Report] = {"held-out templates": evaluate(tagger, held_out)}
    if arguments.gold:
        reports["gold_dev (38 human sentences)"] = evaluate(tagger, read_gold(arguments.gold))
    parameters = sum(parameter.numel() for parameter in model.parameters())
    log.append(f"parameters {parameters} ONNX parity {difference:.2e} sha256 {digest}")
    log += [f"{name}: weighted F1 {r.weighted_f1:.4f}" for name, r in reports.items()]
    print("\n".join(log[-1 - len(reports) :]))
    (out / "training.log").write_text("\n".join(log) + "\n", encoding="utf-8")
    write_card(out, arguments, reports, parameters=parameters, parity=difference, sha256=digest)


if __name__ == "__main__":
    main()
