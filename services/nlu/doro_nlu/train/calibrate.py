"""Ranges of the activations, for the int8 encoder's fixed scales. Needs ``onnx``, not torch."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np
import onnxruntime as ort
from numpy.typing import NDArray
from onnx import TensorProto, helper

from doro_nlu.train.graph import Weights, encoder_graph, linears_of
from doro_nlu.wordpiece import rows_of, split_word

TAIL = 1e-5
"""Share of the values cut off at each end."""
_KEPT = 64
"""Values kept of each sentence at each end; more than the tails can ask for."""


class Sentence(Protocol):
    """What has tokens."""

    @property
    def tokens(self) -> list[str]: ...


def calibrate(
    weights: Weights, sentences: Sequence[Sentence], pieces: Mapping[str, int]
) -> dict[str, tuple[float, float]]:
    """Return the range of each linear's input over the sentences, without its thinnest tails."""
    proto = encoder_graph(weights)
    names = linears_of(weights)
    inputs = {node.output[0].removesuffix(".m"): node.input[0] for node in proto.graph.node
              if node.op_type == "MatMul"}  # fmt: skip
    sources = list(dict.fromkeys(inputs[name] for name in names))
    proto.graph.output.extend(
        helper.make_tensor_value_info(source, TensorProto.FLOAT, None) for source in sources
    )
    session = ort.InferenceSession(  # type: ignore[attr-defined]
        proto.SerializeToString(), providers=["CPUExecutionProvider"]
    )
    lows: dict[str, list[NDArray[np.float32]]] = {source: [] for source in sources}
    highs: dict[str, list[NDArray[np.float32]]] = {source: [] for source in sources}
    counts = dict.fromkeys(sources, 0)
    for sentence in sentences:
        rows, _ = rows_of([[split_word(token, pieces) for token in sentence.tokens]])
        found = session.run(sources, {"pieces": rows.pieces, "mask": rows.mask})
        for source, values in zip(sources, found, strict=True):
            ordered = np.sort(np.asarray(values)[rows.mask > 0].ravel())
            counts[source] += len(ordered)
            lows[source].append(ordered[:_KEPT])
            highs[source].append(ordered[-_KEPT:])
    ends = {}
    for source in sources:
        cut = int(TAIL * counts[source])
        low = np.sort(np.concatenate(lows[source]))[cut]
        high = np.sort(np.concatenate(highs[source]))[-1 - cut]
        ends[source] = (float(low), float(high))
    return {name: ends[inputs[name]] for name in names}
