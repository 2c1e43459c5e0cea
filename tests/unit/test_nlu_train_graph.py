"""The encoder's graph: float32 and int8 from the same weights, and back. Needs the extra onnx."""

import numpy as np
import onnxruntime as ort
import pytest

pytest.importorskip("onnx", reason="the extra train or speed is not installed")

from pathlib import Path

from doro_nlu.tagger import MODEL_FILE, SHIPPED
from doro_nlu.train.annotate import annotate
from doro_nlu.train.calibrate import calibrate
from doro_nlu.train.graph import WEIGHT_MAX, Weights, encoder_graph, linears_of, read_weights

PIECES = {piece: index for index, piece in enumerate(["[PAD]", "[UNK]", "[CLS]", "[SEP]", "cup"])}


def random_weights(layers: int = 2, hidden: int = 48, inner: int = 96) -> Weights:
    draw = np.random.default_rng(1)
    sizes = {"words": (9, hidden), "positions": (128, hidden), "norm": (hidden,),
             "head": (hidden, 5)}  # fmt: skip
    parts = {"qkv": (hidden, 3 * hidden), "out": (hidden, hidden), "norm1": (hidden,),
             "up": (hidden, inner), "down": (inner, hidden), "norm2": (hidden,)}  # fmt: skip
    sizes |= {f"l{at}.{part}": size for at in range(layers) for part, size in parts.items()}
    weights: Weights = {}
    for name, size in sizes.items():
        weights[f"{name}.w"] = (draw.standard_normal(size) * 0.2).astype(np.float32)
        weights[f"{name}.b"] = np.zeros(size[-1], np.float32)
    return weights


def run(model: bytes, rows: int = 3) -> np.ndarray:
    pieces = np.arange(rows * 6).reshape(rows, 6) % 9
    mask = np.ones((rows, 6), np.float32)
    mask[1:, 4:] = 0
    session = ort.InferenceSession(model, providers=["CPUExecutionProvider"])
    return np.asarray(session.run(None, {"pieces": pieces, "mask": mask})[0])


def test_int8_is_near_float32_and_reads_back(tmp_path: Path) -> None:
    weights = random_weights()
    ranges = calibrate(weights, [annotate("the cup"), annotate("cup cup zzz")] * 8, PIECES)
    assert list(ranges) == linears_of(weights)
    full, small = encoder_graph(weights), encoder_graph(weights, ranges)
    difference = np.abs(run(full.SerializeToString()) - run(small.SerializeToString()))
    assert difference.max() < 0.5
    path = tmp_path / MODEL_FILE
    path.write_bytes(small.SerializeToString())
    found = read_weights(path)
    assert set(found) == set(weights) - {"words.b", "positions.b"}
    for name, value in found.items():
        np.testing.assert_allclose(value, weights[name], atol=0.02)


def test_a_row_does_not_depend_on_its_batch() -> None:
    weights = random_weights()
    ranges = dict.fromkeys(linears_of(weights), (-4.0, 4.0))
    model = encoder_graph(weights, ranges).SerializeToString()
    np.testing.assert_array_equal(run(model, 3)[:1], run(model, 1))


def test_the_shipped_weights_overflow_nowhere() -> None:
    import onnx
    from onnx import numpy_helper

    model = onnx.load(str(SHIPPED["default"] / MODEL_FILE))
    found = {v.name: numpy_helper.to_array(v) for v in model.graph.initializer}
    linears = [value for name, value in found.items() if name.endswith(".q") and name[0] == "l"]
    assert len(linears) == 12
    assert all(np.abs(value.astype(int)).max() <= WEIGHT_MAX for value in linears)
    assert 2 * 255 * WEIGHT_MAX < 2**15  # two products meet in 16 bits where there is no VNNI
