"""The trained network as ONNX, written node by node: torch's exporter cannot trace packed LSTMs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import onnx
import onnxruntime
import torch
from numpy.typing import NDArray
from onnx import TensorProto, helper, numpy_helper

from doro_nlu.features import WORD_CHARS
from doro_nlu.train.model import BiLstm

OPSET = 17
_GATES = (0, 3, 1, 2)  # torch: input, forget, cell, output; ONNX: input, output, forget, cell


def _lstm_weights(layer: torch.nn.LSTM, name: str) -> dict[str, NDArray[np.float32]]:
    def gates(parameter: str) -> NDArray[np.float32]:
        directions = []
        for suffix in ("", "_reverse"):
            value = getattr(layer, f"{parameter}_l0{suffix}").detach().numpy()
            quarters = np.split(value, 4)
            directions.append(np.concatenate([quarters[index] for index in _GATES]))
        return np.stack(directions)

    bias = np.concatenate([gates("bias_ih"), gates("bias_hh")], axis=1)
    return {f"{name}.w": gates("weight_ih"), f"{name}.r": gates("weight_hh"), f"{name}.b": bias}


def _weights(model: BiLstm) -> list[onnx.TensorProto]:
    hidden = model.layer1.hidden_size
    arrays: dict[str, NDArray[np.generic]] = {
        "words.w": model.words.weight.detach().numpy(),
        "chars.w": model.chars.weight.detach().numpy(),
        "conv.w": model.conv.weight.detach().numpy(),
        "conv.b": model.conv.bias.detach().numpy(),
        "head.w": model.head.weight.detach().numpy().T.copy(),
        "head.b": model.head.bias.detach().numpy(),
        "rows": np.array([-1, WORD_CHARS], np.int64),
        "joined": np.array([0, 0, 2 * hidden], np.int64),
        "channels": np.array([model.conv.out_channels], np.int64),
    }
    for name, layer in (("layer1", model.layer1), ("layer2", model.layer2)):
        arrays.update(_lstm_weights(layer, name))
    return [numpy_helper.from_array(value, name) for name, value in arrays.items()]


def _nodes(hidden: int) -> list[onnx.NodeProto]:
    node = helper.make_node
    nodes = [
        node("Gather", ["words.w", "words"], ["word"]),
        node("Reshape", ["chars", "rows"], ["flat"]),
        node("Gather", ["chars.w", "flat"], ["letters"]),
        node("Transpose", ["letters"], ["letters_t"], perm=[0, 2, 1]),
        node("Conv", ["letters_t", "conv.w", "conv.b"], ["conv"], pads=[1, 1]),
        node("ReduceMax", ["conv"], ["peak"], axes=[2], keepdims=0),
        node("Relu", ["peak"], ["shape"]),
        node("Shape", ["words"], ["bt"]),
        node("Concat", ["bt", "channels"], ["bts"], axis=0),
        node("Reshape", ["shape", "bts"], ["shapes"]),
        node("Concat", ["word", "shapes"], ["x"], axis=2),
        node("Transpose", ["x"], ["seq0"], perm=[1, 0, 2]),
    ]
    for index in (1, 2):
        weights = [f"layer{index}.{part}" for part in "wrb"]
        nodes += [
            node("LSTM", [f"seq{index - 1}", *weights, "lengths"], [f"y{index}"],
                 hidden_size=hidden, direction="bidirectional"),
            node("Transpose", [f"y{index}"], [f"yt{index}"], perm=[0, 2, 1, 3]),
            node("Reshape", [f"yt{index}", "joined"], [f"seq{index}"]),
        ]  # fmt: skip
    nodes += [
        node("MatMul", ["seq2", "head.w"], ["scores"]),
        node("Add", ["scores", "head.b"], ["logits_t"]),
        node("Transpose", ["logits_t"], ["logits"], perm=[1, 0, 2]),
    ]
    return nodes


def export(model: BiLstm, path: Path, n_labels: int) -> None:
    """Write the network: words (b, t), chars (b, t, w), lengths (b,) -> logits (b, t, labels)."""
    info = helper.make_tensor_value_info
    graph = helper.make_graph(
        _nodes(model.layer1.hidden_size),
        "doro_bilstm",
        [
            info("words", TensorProto.INT64, ["b", "t"]),
            info("chars", TensorProto.INT64, ["b", "t", WORD_CHARS]),
            info("lengths", TensorProto.INT32, ["b"]),
        ],
        [info("logits", TensorProto.FLOAT, ["b", "t", n_labels])],
        _weights(model),
    )
    proto = helper.make_model(
        graph, opset_imports=[helper.make_opsetid("", OPSET)], producer_name="doro-nlu"
    )
    proto.ir_version = 8
    onnx.checker.check_model(proto, full_check=True)
    path.write_bytes(proto.SerializeToString())


def parity(
    model: BiLstm,
    path: Path,
    words: NDArray[np.int64],
    chars: NDArray[np.int64],
    lengths: NDArray[np.int32],
) -> float:
    """Return the largest difference between torch's and ONNX's logits on real tokens."""
    session = onnxruntime.InferenceSession(  # type: ignore[attr-defined]
        str(path), providers=["CPUExecutionProvider"]
    )
    (theirs,) = session.run(None, {"words": words, "chars": chars, "lengths": lengths})
    model.eval()
    with torch.no_grad():
        ours = model(*(torch.from_numpy(array) for array in (words, chars, lengths))).numpy()
    mask = np.arange(words.shape[1])[None, :] < lengths[:, None]
    return float(np.abs(ours - theirs)[mask].max())
