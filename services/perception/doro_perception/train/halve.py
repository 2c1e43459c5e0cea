"""Halves a model file: large float32 constants become float16, cast back when the model loads.

``python -m doro_perception.train.halve IN.onnx OUT.onnx``. onnxruntime folds the casts at load,
so that speed and memory stay; values move by at most one part in two thousand.
"""

from __future__ import annotations

import hashlib
import sys
from pathlib import Path

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper

LEAST_VALUES = 1024
LARGEST = 60000.0


def halve(source: Path, target: Path) -> None:
    """Write the halved model and its sha256."""
    model = onnx.load(str(source))
    graph = model.graph
    kept, casts = [], []
    for item in graph.initializer:
        values = numpy_helper.to_array(item)
        if values.dtype != np.float32 or values.size < LEAST_VALUES or _too_large(values):
            kept.append(item)
            continue
        name = f"{item.name}__half"
        kept.append(numpy_helper.from_array(values.astype(np.float16), name))
        casts.append(helper.make_node("Cast", [name], [item.name], to=TensorProto.FLOAT))
    del graph.initializer[:]
    graph.initializer.extend(kept)
    nodes = [*casts, *graph.node]
    del graph.node[:]
    graph.node.extend(nodes)
    onnx.save(model, str(target))
    digest = hashlib.sha256(target.read_bytes()).hexdigest()
    target.with_name(target.name + ".sha256").write_text(
        f"{digest}  {target.name}\n", encoding="utf-8"
    )


def _too_large(values: np.ndarray[tuple[int, ...], np.dtype[np.float32]]) -> bool:
    return bool(np.abs(values).max() > LARGEST)


if __name__ == "__main__":
    halve(Path(sys.argv[1]), Path(sys.argv[2]))
