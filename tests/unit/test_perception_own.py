"""A detector of the user's own is plugged in by its TOML file alone, whatever its layout."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from doro_perception.backend import RgbImage
from doro_perception.backends import make_backend
from doro_perception.core import Perception
from doro_perception.own import OwnDetector
from doro_perception.settings import PerceptionSettings
from doro_perception.stages import Stages
from doro_schemas.errors import Refused
from doro_schemas.messages import ColorFrame, FrameCaptions
from tests.tiny_onnx import FLOAT, INT64, UINT8, model, node, port

SIDE_PX = 64
# Each tiny model "sees" two boxes of two classes, the surer the more red the image is.
SCORES = np.array([[0.9, 0.05], [0.1, 0.8], [0.02, 0.03]], np.float32)
EDGES = np.array([[4, 8, 20, 40], [30, 30, 60, 50], [0, 0, 64, 64]], np.float32)
CENTRES = np.hstack([(EDGES[:, :2] + EDGES[:, 2:]) / 2, EDGES[:, 2:] - EDGES[:, :2]])
INPUT = f"[input]\nwidth_px = {SIDE_PX}\nheight_px = {SIDE_PX}\n"


def redness(order: str = "nchw") -> list[bytes]:
    """Return nodes that give the mean of the first channel, shape (1, 1, 1, 1)."""
    axes = [2, 3] if order == "nchw" else [1, 2]
    gather = node("Gather", ["image", "first"], ["channel"], axis=1 if order == "nchw" else 3)
    return [gather, node("ReduceMean", ["channel"], ["mean"], axes=axes, keepdims=1)]


FIRST = np.array([0], np.int64)


def yolo(folder: Path) -> Path:
    """(1, 4 + classes, boxes), pixels, as YOLOv8 exports it."""
    nodes = [
        *redness(),
        node("Reshape", ["mean", "three"], ["share"]),
        node("Mul", ["scores", "share"], ["seen"]),
        node("Concat", ["boxes", "seen"], ["output0"], axis=1),
    ]
    constants = {
        "first": FIRST,
        "three": np.array([1, 1, 1], np.int64),
        "scores": SCORES.T[None].copy(),
        "boxes": CENTRES.T[None].copy(),
    }
    image = port("image", FLOAT, [1, 3, SIDE_PX, SIDE_PX])
    data = model(nodes, constants, [image], [port("output0", FLOAT, [1, 6, 3])])
    (folder / "tiny.onnx").write_bytes(data)
    text = f'model = "tiny.onnx"\nlayout = "yolo"\nclasses = ["Cup", "CoffeeTable"]\n{INPUT}'
    return written(folder, text.replace("CoffeeTable", "coffee table"))


def ssd(folder: Path) -> Path:
    """uint8 NHWC; boxes as shares (ymin, xmin, ymax, xmax), scores with a background column."""
    nodes = [
        node("Cast", ["pixels"], ["image"], to=FLOAT),
        *redness("nhwc"),
        node("Div", ["mean", "full"], ["part"]),
        node("Reshape", ["part", "three"], ["share"]),
        node("Mul", ["table", "share"], ["scores"]),
        node("Identity", ["places"], ["boxes"]),
    ]
    table = np.hstack([np.full((3, 1), 0.5, np.float32), SCORES])[None].copy()
    constants = {
        "first": FIRST,
        "three": np.array([1, 1, 1], np.int64),
        "full": np.array([255], np.float32),
        "table": table,
        "places": (EDGES[:, [1, 0, 3, 2]] / SIDE_PX)[None].copy(),
    }
    image = port("pixels", UINT8, ["n", SIDE_PX, SIDE_PX, 3])
    outputs = [port("boxes", FLOAT, [1, 3, 4]), port("scores", FLOAT, [1, 3, 3])]
    (folder / "tiny.onnx").write_bytes(model(nodes, constants, [image], outputs))
    text = 'model = "tiny.onnx"\nlayout = "ssd"\nclasses = ["cup", "coffee table"]\n' + INPUT
    text += 'type = "uint8"\norder = "nhwc"\n[output]\nbackground = "first"\n'
    return written(folder, text)


def detr(folder: Path) -> Path:
    """Logits with "no object" last, boxes (cx, cy, w, h) as shares; BGR, ImageNet's mean."""
    logits = np.log(np.hstack([SCORES, 1 - SCORES.sum(axis=1, keepdims=True)]))[None]
    nodes = [
        # BGR: the first channel is blue; the last one tells the redness.
        node("Gather", ["image", "last"], ["channel"], axis=1),
        node("ReduceMean", ["channel"], ["mean"], axes=[2, 3], keepdims=1),
        node("Reshape", ["mean", "three"], ["share"]),
        node("Mul", ["logits", "share"], ["pred_logits"]),
        node("Identity", ["places"], ["pred_boxes"]),
    ]
    constants = {
        "last": np.array([2], np.int64),
        "three": np.array([1, 1, 1], np.int64),
        "logits": logits.astype(np.float32),
        "places": (CENTRES / SIDE_PX)[None].copy(),
    }
    image = port("image", FLOAT, ["n", 3, "h", "w"])
    outputs = [port("pred_logits", FLOAT, [1, 3, 3]), port("pred_boxes", FLOAT, [1, 3, 4])]
    (folder / "tiny.onnx").write_bytes(model(nodes, constants, [image], outputs))
    text = 'model = "tiny.onnx"\nlayout = "detr"\nclasses = ["cup", "coffee table"]\n' + INPUT
    text += 'channels = "bgr"\nmean = [127.5, 127.5, 127.5]\nstd = [127.5, 127.5, 127.5]\n'
    return written(folder, text)


def written(folder: Path, text: str) -> Path:
    path = folder / "detector.toml"
    path.write_text(text, encoding="utf-8")
    return path


def red(height_px: int = SIDE_PX, width_px: int = SIDE_PX) -> RgbImage:
    image = np.zeros((height_px, width_px, 3), np.uint8)
    image[..., 0] = 255
    return image


def detector(path: Path) -> OwnDetector:
    found = make_backend(PerceptionSettings(backend="onnx", detector=str(path)), Stages())
    assert isinstance(found, OwnDetector)
    found.warm_up()
    return found


@pytest.mark.parametrize("layout", [yolo, ssd, detr])
def test_each_layout_gives_the_boxes_and_names(layout, tmp_path: Path) -> None:
    own = detector(layout(tmp_path))
    found = own.detect(red())
    assert [item.name for item in found] == ["cup", "coffee table"]
    assert [item.score for item in found] == pytest.approx([0.9, 0.8], abs=1e-3)
    assert np.allclose([item.box_px for item in found], EDGES[:2], atol=1e-3)
    assert found[0].classes[0] == ("cup", pytest.approx(0.9, abs=1e-3))
    # Blue instead of red: channels and normalisation reach the model as the TOML says.
    blue = own.detect(red()[..., ::-1])
    at_first = [item for item in blue if np.allclose(item.box_px, EDGES[0], atol=1)]
    assert not any(item.name == "cup" for item in at_first)


def test_a_wide_image_is_letterboxed_and_boxes_come_back(tmp_path: Path) -> None:
    own = detector(yolo(tmp_path))
    # 32 x 64 into 64 x 64: the lower half of the input is padding.
    found = own.detect(np.full((128, 256, 3), 255, np.uint8))
    assert np.allclose(found[0].box_px, EDGES[0] * 4, atol=1e-3)


def test_the_core_captions_what_it_sees(tmp_path: Path) -> None:
    settings = PerceptionSettings(backend="onnx", detector=str(ssd(tmp_path)), colour=False)
    core = Perception(settings, make_backend(settings, Stages()))
    frame = ColorFrame(frame=3, height_px=64, width_px=64, data=red())
    (message,) = core.color_frame(frame)
    assert isinstance(message, FrameCaptions)
    assert [box.caption for box in message.detections] == ["a cup", "a coffee table"]
    assert message.detections[1].classes[0].name == "coffee table"


def test_labels_chosen_by_the_model(tmp_path: Path) -> None:
    nodes = [node("Identity", [one], [one[1:]]) for one in ("_boxes", "_best", "_label")]
    nodes.append(node("Shape", ["image"], ["unused"]))
    constants = {
        "_boxes": EDGES[None].copy(),
        "_best": np.array([[0.9, 0.7, 0.2]], np.float32),
        "_label": np.array([[1, 0, 0]], np.int64),
    }
    outputs = [
        port("boxes", FLOAT, [1, 3, 4]),
        port("best", FLOAT, [1, 3]),
        port("label", INT64, [1, 3]),
        port("unused", INT64, [4]),
    ]
    image = port("image", FLOAT, [1, 3, SIDE_PX, SIDE_PX])
    (tmp_path / "tiny.onnx").write_bytes(model(nodes, constants, [image], outputs))
    text = 'model = "tiny.onnx"\nlayout = "ssd"\nclasses = ["-", "bowl"]\n' + INPUT
    text += '[output]\nscores = "best"\nlabels = "label"\nbox_format = "xyxy"\n'
    found = detector(written(tmp_path, text + 'box_units = "pixels"\n')).detect(red())
    assert [(item.name, item.score) for item in found] == [("bowl", pytest.approx(0.9))]


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (('layout = "yolo"', 'layout = "rcnn"'), r"detector.toml does not fit"),
        (('"Cup"', '"Cup", "Bowl"'), r"3 classes make 7 values a box: check classes"),
        (("width_px = 64", "width_px = 96"), r"float32 \[1, 3, 64, 96\] \(nchw\): correct \[inp"),
        (("[input]", '[input]\ntype = "uint8"'), r"but the description says one image, uint8"),
        (("[input]", '[input]\norder = "nhwc"'), r"\[1, 64, 64, 3\] \(nhwc\): correct \[input\]"),
        (('"tiny.onnx"', '"gone.onnx"'), r"gone.onnx is missing: correct the file"),
        (("[input]", '[input]\ncolour = "blue"'), r"does not fit \(Object contains unknown fi"),
        (('layout = "yolo"', 'layout = "detr"'), r"has no output 'pred_boxes', it gives output0"),
    ],
)
def test_a_description_that_does_not_fit_is_refused(
    change: tuple[str, str], sentence: str, tmp_path: Path
) -> None:
    path = yolo(tmp_path)
    path.write_text(path.read_text(encoding="utf-8").replace(*change), encoding="utf-8")
    with pytest.raises(Refused, match=sentence) as caught:
        detector(path)
    assert "\n" not in caught.value.reason


def test_no_description_is_refused(tmp_path: Path) -> None:
    with pytest.raises(Refused, match=r"perception\.detector names no description"):
        make_backend(PerceptionSettings(backend="onnx"), Stages())
    with pytest.raises(Refused, match=r"none\.toml cannot be read"):
        detector(tmp_path / "none.toml")
    path = yolo(tmp_path)
    (tmp_path / "tiny.onnx").write_bytes(b"\x08\x07garbage")
    with pytest.raises(Refused, match=r"tiny\.onnx is no ONNX model that can be run"):
        detector(path)
