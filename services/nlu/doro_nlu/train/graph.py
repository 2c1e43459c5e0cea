"""The encoder as an ONNX graph, written node by node: float32, or int8 with fixed scales.

int8: weights per column in 7 bits, so that no processor's 16-bit sums overflow; activations with
scales fixed by calibration, so that a sentence gives the same in any batch. Needs ``onnx``.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import onnx
from numpy.typing import NDArray
from onnx import TensorProto, helper, numpy_helper

OPSET = 17
HEADS = 12
WEIGHT_MAX = 63
_EPSILON = 1e-12
_LINEARS = ("qkv", "out", "up", "down")
Weights = dict[str, NDArray[np.float32]]
Ranges = Mapping[str, tuple[float, float]]
"""Lowest and highest input of each linear ("l0.qkv")."""


def layers_of(weights: Weights) -> int:
    """Return the number of layers."""
    return sum(name.endswith(".qkv.w") for name in weights)


def linears_of(weights: Weights) -> list[str]:
    """Return the names of the linears inside the layers."""
    return [f"l{index}.{part}" for index in range(layers_of(weights)) for part in _LINEARS]


class _Graph:
    """Nodes and initialisers as they are collected."""

    def __init__(self, weights: Weights, ranges: Ranges | None) -> None:
        self.weights = weights
        self.ranges = ranges
        self.nodes: list[onnx.NodeProto] = []
        self.values: list[onnx.TensorProto] = []

    def node(self, kind: str, inputs: list[str], output: str, **attributes: Any) -> str:
        self.nodes.append(helper.make_node(kind, inputs, [output], name=output, **attributes))
        return output

    def constant(self, name: str, value: NDArray[np.generic]) -> str:
        self.values.append(numpy_helper.from_array(value, name))
        return name

    def kept(self, name: str) -> str:
        return self.constant(name, self.weights[name])

    def linear(self, name: str, source: str) -> str:
        if self.ranges is None or name not in self.ranges:
            product = self.node("MatMul", [source, self.kept(f"{name}.w")], f"{name}.m")
            return self.node("Add", [product, self.kept(f"{name}.b")], name)
        low, high = self.ranges[name]
        scale, zero = activation_scale(low, high)
        a_scale = self.constant(f"{name}.as", np.array(scale, np.float32))
        a_zero = self.constant(f"{name}.az", np.array(zero, np.uint8))
        quantised, columns = quantise_columns(self.weights[f"{name}.w"])
        whole = self.node("QuantizeLinear", [source, a_scale, a_zero], f"{name}.x")
        b, b_scale = self.constant(f"{name}.q", quantised), self.constant(f"{name}.s", columns)
        inputs = [whole, b, a_scale, b_scale, a_zero, "", self.kept(f"{name}.b")]
        return self.node("MatMulIntegerToFloat", inputs, name, domain="com.microsoft")

    def norm(self, name: str, source: str) -> str:
        inputs = [source, self.kept(f"{name}.w"), self.kept(f"{name}.b")]
        return self.node("LayerNormalization", inputs, name, axis=-1, epsilon=_EPSILON)

    def embedding(self) -> str:
        if self.ranges is None:
            return self.node("Gather", [self.kept("words.w"), "pieces"], "word")
        table = self.weights["words.w"]
        scale = np.maximum(np.abs(table).max(axis=1, keepdims=True), 1e-8) / 127
        rows = np.round(table / scale).astype(np.int8)
        whole = self.node("Gather", [self.constant("words.q", rows), "pieces"], "word.q")
        scales = [self.constant("words.s", scale.astype(np.float32)), "pieces"]
        cast = self.node("Cast", [whole], "word.f", to=TensorProto.FLOAT)
        return self.node("Mul", [cast, self.node("Gather", scales, "word.s")], "word")

    def layer(self, n: str, source: str) -> str:
        joined = self.linear(f"{n}.qkv", source)
        self.nodes.append(
            helper.make_node("Split", [joined, "thirds"], [f"{n}.{x}" for x in "qkv"], axis=-1,
                             name=f"{n}.split")
        )  # fmt: skip
        inputs = [f"{n}.q", f"{n}.k", f"{n}.v", "", "", "bias"]
        mixed = self.node("MultiHeadAttention", inputs, f"{n}.mix", domain="com.microsoft",
                          num_heads=HEADS)  # fmt: skip
        first = self.node("Add", [self.linear(f"{n}.out", mixed), source], f"{n}.res1")
        first = self.norm(f"{n}.norm1", first)
        up = self.linear(f"{n}.up", first)
        gate = self.node("Gelu", [up], f"{n}.gelu", domain="com.microsoft")
        down = self.linear(f"{n}.down", gate)
        return self.norm(f"{n}.norm2", self.node("Add", [down, first], f"{n}.res2"))


def encoder_graph(weights: Weights, ranges: Ranges | None = None) -> onnx.ModelProto:
    """Return the network: pieces (b, p) int64, mask (b, p) float32 -> logits (b, p, labels).

    Args:
        weights: by name, linears as (inputs, outputs).
        ranges: of the inputs of the linears to quantise; None = float32 throughout.
    """
    graph = _Graph(weights, ranges)
    hidden = weights["words.w"].shape[1]
    for name, value in (("zero", 0), ("one", 1)):
        graph.constant(name, np.array([value], np.int64))
    graph.constant("thirds", np.array([hidden] * 3, np.int64))
    graph.constant("mask_axes", np.array([1, 2], np.int64))
    graph.constant("low", np.array(1e4, np.float32))
    graph.constant("unit", np.array(1.0, np.float32))
    length = graph.node("Shape", ["pieces"], "length", start=1)
    place = graph.node("Slice", [graph.kept("positions.w"), "zero", length, "zero"], "place")
    source = graph.norm("norm", graph.node("Add", [graph.embedding(), place], "sum"))
    off = graph.node("Mul", [graph.node("Sub", ["mask", "unit"], "off"), "low"], "bias2")
    wide = graph.node("Unsqueeze", [off, "mask_axes"], "bias4")
    shape = graph.node("Concat", ["one", "one", length, "one"], "bias_shape", axis=0)
    graph.node("Expand", [wide, shape], "bias")
    for index in range(layers_of(weights)):
        source = graph.layer(f"l{index}", source)
    graph.node("Identity", [graph.linear("head", source)], "logits")
    info, labels = helper.make_tensor_value_info, weights["head.b"].shape[0]
    proto = helper.make_graph(
        graph.nodes,
        "doro_encoder",
        [
            info("pieces", TensorProto.INT64, ["b", "p"]),
            info("mask", TensorProto.FLOAT, ["b", "p"]),
        ],
        [info("logits", TensorProto.FLOAT, ["b", "p", labels])],
        graph.values,
    )
    opsets = [helper.make_opsetid("", OPSET), helper.make_opsetid("com.microsoft", 1)]
    model = helper.make_model(proto, opset_imports=opsets, producer_name="doro-nlu")
    model.ir_version = 8
    return model


def activation_scale(low: float, high: float) -> tuple[float, int]:
    """Return scale and zero point of unsigned 8-bit values that span ``low`` to ``high``."""
    low, high = min(low, 0.0), max(high, 0.0)
    scale = max(high - low, 1e-6) / 255
    return scale, int(np.clip(round(-low / scale), 0, 255))


def quantise_columns(weight: NDArray[np.float32]) -> tuple[NDArray[np.int8], NDArray[np.float32]]:
    """Return the 7-bit weights and the scale of each column."""
    scale = np.maximum(np.abs(weight).max(axis=0), 1e-8) / WEIGHT_MAX
    return np.round(weight / scale).astype(np.int8), scale.astype(np.float32)


def read_weights(path: Path) -> Weights:
    """Return the float32 weights of a model written here; int8 ones are scaled back."""
    found = {
        item.name: numpy_helper.to_array(item) for item in onnx.load(str(path)).graph.initializer
    }
    weights = {name: value for name, value in found.items() if name.endswith((".w", ".b"))}
    for name, value in found.items():
        if name.endswith(".q"):
            stem = name.removesuffix(".q")
            weights[f"{stem}.w"] = value.astype(np.float32) * found[f"{stem}.s"]
    return weights
