"""The trained encoder as ONNX, fp32 and int8, with parity, figures and model card."""

from __future__ import annotations

import argparse
import hashlib
import itertools
from collections.abc import Sequence
from pathlib import Path

import msgspec
import numpy as np
import onnx
import onnxruntime
import torch
from numpy.typing import NDArray

from doro_nlu.encoder import Pieces
from doro_nlu.labels import LABELS
from doro_nlu.onnx_files import MODEL_FILE, VOCABULARY_FILE
from doro_nlu.tagger import load_tagger
from doro_nlu.train.calibrate import calibrate
from doro_nlu.train.encoder_card import write_encoder_card
from doro_nlu.train.encoder_data import Target, arrays, hard
from doro_nlu.train.encoder_model import Encoder
from doro_nlu.train.evaluate import evaluate, held_out_examples, read_gold
from doro_nlu.train.generate import Generator
from doro_nlu.train.graph import Weights, encoder_graph

CALIBRATION_SENTENCES = 512
_PARTS = ("qkv", "out", "norm1", "up", "down", "norm2")


def weights_of(model: Encoder) -> Weights:
    """Return the arrays of the graph; weights of linears are transposed."""
    found = {
        "words.w": model.words.weight.detach().numpy(),
        "positions.w": model.positions.detach().numpy(),
    }
    modules = {"norm": model.norm, "head": model.head}
    for index, layer in enumerate(model.layers):
        modules |= {f"l{index}.{part}": getattr(layer, part) for part in _PARTS}
    for name, module in modules.items():
        weight = module.weight.detach().numpy()
        found[f"{name}.w"] = weight.T.copy() if weight.ndim == 2 else weight
        found[f"{name}.b"] = module.bias.detach().numpy()
    return found


def load_weights(model: Encoder, weights: Weights) -> None:
    """Put the arrays of a graph into a model of the same shape; the word table stays frozen."""
    modules = {"norm": model.norm, "head": model.head}
    for index, layer in enumerate(model.layers):
        modules |= {f"l{index}.{part}": getattr(layer, part) for part in _PARTS}
    with torch.no_grad():
        model.words.weight.copy_(torch.tensor(weights["words.w"]))
        model.positions.copy_(torch.tensor(weights["positions.w"]))
        for name, module in modules.items():
            weight = torch.tensor(weights[f"{name}.w"])
            module.weight.copy_(weight.T if weight.ndim == 2 else weight)
            module.bias.copy_(torch.tensor(weights[f"{name}.b"]))
    model.words.weight.requires_grad_(False)


def export(model: Encoder, path: Path) -> None:
    """Write the network in float32."""
    proto = encoder_graph(weights_of(model))
    onnx.checker.check_model(proto)
    path.write_bytes(proto.SerializeToString())


def export_int8(model: Encoder, path: Path, names: Sequence[str], human: Sequence[Target]) -> None:
    """Write the int8 network, calibrated on sentences of the training data."""
    made = itertools.islice(Generator(1), CALIBRATION_SENTENCES)
    targets = [hard(example) for example in made]
    targets += list(human[:: max(1, len(human) // CALIBRATION_SENTENCES)])
    pieces = {piece: index for index, piece in enumerate(names)}
    weights = weights_of(model)
    proto = encoder_graph(weights, calibrate(weights, targets, pieces))
    onnx.checker.check_model(proto)
    path.write_bytes(proto.SerializeToString())


def parity(
    model: Encoder, path: Path, pieces: NDArray[np.int64], mask: NDArray[np.float32]
) -> float:
    """Return the largest difference between torch's and ONNX's logits on real pieces."""
    session = onnxruntime.InferenceSession(  # type: ignore[attr-defined]
        str(path), providers=["CPUExecutionProvider"]
    )
    (theirs,) = session.run(None, {"pieces": pieces, "mask": mask})
    with torch.no_grad():
        ours = model(torch.from_numpy(pieces), torch.from_numpy(mask)).numpy()
    return float(np.abs(ours - theirs)[mask > 0].max())


def write_vocabulary(directory: Path, names: Sequence[str], labels: Sequence[str] = LABELS) -> str:
    """Write the vocabulary beside a model and return the model's digest."""
    digest = hashlib.sha256((directory / MODEL_FILE).read_bytes()).hexdigest()
    content = msgspec.json.encode(Pieces(list(labels), list(names), digest))
    (directory / VOCABULARY_FILE).write_bytes(content + b"\n")
    return digest


def finish(
    model: Encoder,
    names: list[str],
    human: Sequence[Target],
    arguments: argparse.Namespace,
    log: list[str],
) -> None:
    """Export, quantise, check parity, evaluate both and write vocabulary, log and card."""
    full, small = arguments.out / "fp32", arguments.out / "int8"
    for directory in (full, small):
        directory.mkdir(exist_ok=True)
    export(model, full / MODEL_FILE)
    export_int8(model, small / MODEL_FILE, names, human)
    held_out = held_out_examples(arguments.seed)
    pieces = {piece: index for index, piece in enumerate(names)}
    ids, mask, _ = arrays([hard(example) for example in held_out[:64]], pieces)
    difference = parity(model, full / MODEL_FILE, ids.numpy(), mask.numpy())
    if difference > 1e-3:
        raise SystemExit(f"ONNX differs from torch by {difference}: the export is wrong")
    log.append(f"ONNX parity fp32 {difference:.2e}")
    reports = {}
    for directory in (full, small):
        digest = write_vocabulary(directory, names)
        tagger = load_tagger(directory)
        reports[f"held-out templates, {directory.name}"] = evaluate(tagger, held_out)
        if arguments.gold:
            gold = read_gold(arguments.gold)
            reports[f"gold_dev (38 human sentences), {directory.name}"] = evaluate(tagger, gold)
        log.append(f"{directory.name} {(directory / MODEL_FILE).stat().st_size} bytes {digest}")
    log += [f"{name}: weighted F1 {r.weighted_f1:.4f}" for name, r in reports.items()]
    print("\n".join(log[-3 - len(reports) :]))
    for directory in (full, small):
        (directory / "training.log").write_text("\n".join(log) + "\n", encoding="utf-8")
    write_encoder_card(arguments.out, arguments, reports, parity=difference)
