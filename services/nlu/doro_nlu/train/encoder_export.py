"""The trained encoder as ONNX, fp32 and int8, with parity, figures and model card."""

from __future__ import annotations

import argparse
import hashlib
from pathlib import Path

import msgspec
import numpy as np
import onnx
import onnxruntime
import torch
from numpy.typing import NDArray
from onnx import TensorProto, helper, numpy_helper
from onnxruntime.quantization.quant_utils import QuantType
from onnxruntime.quantization.quantize import quantize_dynamic

from doro_nlu.encoder import Pieces
from doro_nlu.labels import LABELS
from doro_nlu.tagger import MODEL_FILE, VOCABULARY_FILE, load_tagger
from doro_nlu.train.encoder_card import write_encoder_card
from doro_nlu.train.encoder_data import arrays
from doro_nlu.train.encoder_model import HEAD_WIDTH, Encoder
from doro_nlu.train.evaluate import evaluate, held_out_examples, read_gold

OPSET = 17
_EPSILON = 1e-12


def _weights(model: Encoder) -> dict[str, NDArray[np.generic]]:
    """Return the arrays of the graph; linear weights are transposed, the score scale is in q."""
    found: dict[str, NDArray[np.generic]] = {
        "words.w": model.words.weight.detach().numpy(),
        "positions.w": model.positions.detach().numpy(),
        "zero": np.array([0], np.int64),
        "one": np.array([1], np.int64),
        "two": np.array([2], np.int64),
        "mask_axes": np.array([1, 2], np.int64),
        "low": np.array(1e4, np.float32),
        "unit": np.array(1.0, np.float32),
        "half": np.array(0.5, np.float32),
        "root2": np.array(np.sqrt(2.0), np.float32),
    }
    hidden = model.words.weight.shape[1]
    found["split"] = np.array([0, 0, hidden // HEAD_WIDTH, HEAD_WIDTH], np.int64)
    found["joined"] = np.array([0, 0, hidden], np.int64)
    modules = {"norm": model.norm, "head": model.head}
    for index, layer in enumerate(model.layers):
        for part in ("qkv", "out", "norm1", "up", "down", "norm2"):
            modules[f"l{index}.{part}"] = getattr(layer, part)
    for name, module in modules.items():
        weight, bias = module.weight.detach().numpy(), module.bias.detach().numpy().copy()
        weight = weight.T.copy() if weight.ndim == 2 else weight
        if name.endswith("qkv"):
            weight[:, :hidden] /= np.sqrt(HEAD_WIDTH)
            bias[:hidden] /= np.sqrt(HEAD_WIDTH)
        found[f"{name}.w"], found[f"{name}.b"] = weight, bias
    return found


def _linear(name: str, source: str) -> list[onnx.NodeProto]:
    return [
        helper.make_node("MatMul", [source, f"{name}.w"], [f"{name}.m"], name=f"{name}.matmul"),
        helper.make_node("Add", [f"{name}.m", f"{name}.b"], [name]),
    ]


def _norm(name: str, source: str) -> onnx.NodeProto:
    inputs = [source, f"{name}.w", f"{name}.b"]
    return helper.make_node("LayerNormalization", inputs, [name], axis=-1, epsilon=_EPSILON)


def _layer(n: str, source: str) -> list[onnx.NodeProto]:
    node = helper.make_node
    nodes = [
        *_linear(f"{n}.qkv", source),
        node("Split", [f"{n}.qkv"], [f"{n}.q", f"{n}.k", f"{n}.v"], axis=2),
    ]
    for part in "qkv":
        perm = [0, 2, 3, 1] if part == "k" else [0, 2, 1, 3]
        nodes += [
            node("Reshape", [f"{n}.{part}", "split"], [f"{n}.{part}4"]),
            node("Transpose", [f"{n}.{part}4"], [f"{n}.{part}t"], perm=perm),
        ]
    return [
        *nodes,
        node("MatMul", [f"{n}.qt", f"{n}.kt"], [f"{n}.raw"]),
        node("Add", [f"{n}.raw", "bias"], [f"{n}.scores"]),
        node("Softmax", [f"{n}.scores"], [f"{n}.share"], axis=-1),
        node("MatMul", [f"{n}.share", f"{n}.vt"], [f"{n}.mix"]),
        node("Transpose", [f"{n}.mix"], [f"{n}.mixt"], perm=[0, 2, 1, 3]),
        node("Reshape", [f"{n}.mixt", "joined"], [f"{n}.mixed"]),
        *_linear(f"{n}.out", f"{n}.mixed"),
        node("Add", [source, f"{n}.out"], [f"{n}.res1"]),
        _norm(f"{n}.norm1", f"{n}.res1"),
        *_linear(f"{n}.up", f"{n}.norm1"),
        node("Div", [f"{n}.up", "root2"], [f"{n}.scaled"]),
        node("Erf", [f"{n}.scaled"], [f"{n}.erf"]),
        node("Add", [f"{n}.erf", "unit"], [f"{n}.erf1"]),
        node("Mul", [f"{n}.up", f"{n}.erf1"], [f"{n}.gate"]),
        node("Mul", [f"{n}.gate", "half"], [f"{n}.gelu"]),
        *_linear(f"{n}.down", f"{n}.gelu"),
        node("Add", [f"{n}.norm1", f"{n}.down"], [f"{n}.res2"]),
        _norm(f"{n}.norm2", f"{n}.res2"),
    ]


def export(model: Encoder, path: Path) -> None:
    """Write the network: pieces (b, p) int64, mask (b, p) float32 -> logits (b, p, labels)."""
    node, info = helper.make_node, helper.make_tensor_value_info
    nodes = [
        node("Gather", ["words.w", "pieces"], ["word"]),
        node("Shape", ["pieces"], ["length"], start=1),
        node("Slice", ["positions.w", "zero", "length", "zero"], ["place"]),
        node("Add", ["word", "place"], ["sum"]),
        _norm("norm", "sum"),
        node("Sub", ["mask", "unit"], ["off"]),
        node("Mul", ["off", "low"], ["bias2"]),
        node("Unsqueeze", ["bias2", "mask_axes"], ["bias"]),
    ]
    source = "norm"
    for index in range(len(model.layers)):
        nodes += _layer(f"l{index}", source)
        source = f"l{index}.norm2"
    nodes += _linear("head", source)
    n_labels = model.head.out_features
    nodes.append(node("Identity", ["head"], ["logits"]))
    weights = _weights(model)
    used = {name for item in nodes for name in item.input}
    graph = helper.make_graph(
        nodes,
        "doro_encoder",
        [
            info("pieces", TensorProto.INT64, ["b", "p"]),
            info("mask", TensorProto.FLOAT, ["b", "p"]),
        ],
        [info("logits", TensorProto.FLOAT, ["b", "p", n_labels])],
        [numpy_helper.from_array(value, name) for name, value in weights.items() if name in used],
    )
    opset = helper.make_opsetid("", OPSET)
    proto = helper.make_model(graph, opset_imports=[opset], producer_name="doro-nlu")
    proto.ir_version = 8
    onnx.checker.check_model(proto, full_check=True)
    path.write_bytes(proto.SerializeToString())


def quantise(source: Path, target: Path) -> None:
    """Write the int8 model: weights per column, activations at run time; word table included."""
    quantize_dynamic(
        source,
        target,
        op_types_to_quantize=["MatMul", "Gather"],
        per_channel=True,
        weight_type=QuantType.QInt8,
        nodes_to_exclude=["head.matmul"],
    )


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


def _write_vocabulary(directory: Path, names: list[str]) -> str:
    digest = hashlib.sha256((directory / MODEL_FILE).read_bytes()).hexdigest()
    content = msgspec.json.encode(Pieces(list(LABELS), names, digest))
    (directory / VOCABULARY_FILE).write_bytes(content + b"\n")
    return digest


def finish(model: Encoder, names: list[str], arguments: argparse.Namespace, log: list[str]) -> None:
    """Export, quantise, check parity, evaluate both and write vocabulary, log and card."""
    full, small = arguments.out / "fp32", arguments.out / "int8"
    for directory in (full, small):
        directory.mkdir(exist_ok=True)
    export(model, full / MODEL_FILE)
    quantise(full / MODEL_FILE, small / MODEL_FILE)
    held_out = held_out_examples(arguments.seed)
    pieces = {piece: index for index, piece in enumerate(names)}
    ids, mask, _ = arrays(held_out[:64], pieces)
    difference = parity(model, full / MODEL_FILE, ids.numpy(), mask.numpy())
    if difference > 1e-3:
        raise SystemExit(f"ONNX differs from torch by {difference}: the export is wrong")
    log.append(f"ONNX parity fp32 {difference:.2e}")
    reports = {}
    for directory in (full, small):
        digest = _write_vocabulary(directory, names)
        tagger = load_tagger(directory)
        reports[f"held-out templates, {directory.name}"] = evaluate(tagger, held_out)
        if arguments.gold:
            gold = read_gold(arguments.gold)
            reports[f"gold_dev (38 human sentences), {directory.name}"] = evaluate(tagger, gold)
        log.append(f"{directory.name} {(directory / MODEL_FILE).stat().st_size} bytes {digest}")
    log += [f"{name}: weighted F1 {r.weighted_f1:.4f}" for name, r in reports.items()]
    print("\n".join(log[-3 - len(reports) :]))
    (small / "training.log").write_text("\n".join(log) + "\n", encoding="utf-8")
    write_encoder_card(small, arguments, reports, parity=difference, sha256=digest)
