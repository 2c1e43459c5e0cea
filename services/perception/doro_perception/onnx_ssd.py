"""SSDLite-MobileNetV2 (COCO) with onnxruntime; see models/coco_ssdlite/MODEL_CARD.md."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import onnxruntime as ort
from doro_schemas.errors import Refused
from doro_schemas.vocabulary import canonical_name
from numpy.typing import NDArray
from onnxruntime.capi.onnxruntime_pybind11_state import (
    EPFail,
    Fail,
    InvalidArgument,
    InvalidGraph,
    InvalidProtobuf,
    NoSuchFile,
    RuntimeException,
)
from onnxruntime.capi.onnxruntime_pybind11_state import (
    NotImplemented as OpNotImplemented,
)

from doro_perception.backend import Detection, RgbImage, intersection_over_union
from doro_perception.settings import PerceptionSettings

ORT_ERRORS = (
    EPFail,
    Fail,
    InvalidArgument,
    InvalidGraph,
    InvalidProtobuf,
    NoSuchFile,
    OpNotImplemented,
    RuntimeException,
)
PACKAGED_MODEL = Path(__file__).parent / "models" / "coco_ssdlite" / "coco_ssd_lite.onnx"
CLASSES_FILE = "coco_classes.txt"
INPUT = "image_tensor:0"
BOXES = "Postprocessor/ExpandDims_1:0"
SCORES = "Postprocessor/Slice:0"
SIDE_PX = 300
TILE_SHARE = {2: 0.625, 3: 0.5}
STRETCH_PERCENTILES = (1.0, 99.0)
# A flat wall is not stretched to full contrast.
MIN_STRETCH_RANGE = 60.0
# Tiles see a part of a thing as a whole thing: a box that ends at an inner edge is dropped.
EDGE_SHARE = 0.02

FloatArray = NDArray[np.float64]
View = tuple[int, int, int, int, bool]
"""A part of the image: (x, y, width, height) px, mirrored or not."""


class OnnxSsd:
    """The detector; loading checks the file, its inputs and outputs, and its class list.

    Raises:
        Refused: a model that is missing, corrupt, or another one.
    """

    def __init__(self, settings: PerceptionSettings) -> None:
        self._settings = settings
        path = Path(settings.model) if settings.model else PACKAGED_MODEL
        self._path = path
        self._session = _load(path, settings.threads)
        self._names = _read_classes(path.with_name(CLASSES_FILE))
        left_out = set(settings.onnx_leave_out)
        self._columns = [
            column for column, name in enumerate(self._names) if name and name not in left_out
        ]
        self._kept_names = [self._names[column] for column in self._columns]
        self._thresholds = np.array(
            [
                settings.class_thresholds.get(name, settings.score_threshold)
                for name in self._kept_names
            ]
        )
        if not self._columns:
            raise Refused("perception.onnx_leave_out leaves no class: remove some names from it")

    def warm_up(self) -> None:
        """Run once on a gray image, which also checks the shapes of the outputs."""
        self.detect(np.full((SIDE_PX, SIDE_PX, 3), 127, dtype=np.uint8))

    def detect(self, rgb: RgbImage) -> list[Detection]:
        """Return the detections of an image, best first, suppressed across classes."""
        found = [self._look(rgb, view) for view in self._views(rgb.shape[0], rgb.shape[1])]
        boxes = np.concatenate([boxes for boxes, _ in found])
        scores = np.concatenate([scores for _, scores in found])
        passing = np.where(scores >= self._thresholds, scores, 0.0)
        best = passing.argmax(axis=1)
        order = np.argsort(-passing.max(axis=1), kind="stable")
        kept: list[int] = []
        for index in order:
            overlap = intersection_over_union(boxes[index], boxes[kept]) if kept else np.zeros(0)
            if not (overlap > self._settings.nms_iou).any():
                kept.append(int(index))
        return [self._detection(boxes[index], scores[index], int(best[index])) for index in kept]

    def _views(self, height_px: int, width_px: int) -> list[View]:
        """Return what to look at: the whole image, then what the settings add."""
        views: list[View] = [(0, 0, width_px, height_px, False)]
        if self._settings.flip:
            views.append((0, 0, width_px, height_px, True))
        count = self._settings.tiles
        if count and min(height_px, width_px) >= 2 * count:
            share = TILE_SHARE[count]
            wide, high = round(width_px * share), round(height_px * share)
            columns = [round((width_px - wide) * k / (count - 1)) for k in range(count)]
            rows = [round((height_px - high) * k / (count - 1)) for k in range(count)]
            views.extend((x, y, wide, high, False) for y in rows for x in columns)
        return views

    def _look(self, rgb: RgbImage, view: View) -> tuple[FloatArray, FloatArray]:
        """Return candidate boxes (n, 4) px of the image and scores (n, classes) of one view."""
        x, y, wide, high, mirrored = view
        part = rgb[y : y + high, x : x + wide]
        boxes, scores = self._run(part[:, ::-1] if mirrored else part)
        if mirrored:
            boxes = np.stack([1 - boxes[:, 2], boxes[:, 1], 1 - boxes[:, 0], boxes[:, 3]], axis=1)
        keep = (scores >= self._thresholds).any(axis=1) & np.isfinite(boxes).all(axis=1)
        boxes, scores = np.clip(boxes[keep], 0.0, 1.0), scores[keep]
        boxes = boxes * [wide, high, wide, high] + [x, y, x, y]
        size = boxes[:, 2:] - boxes[:, :2]
        area = rgb.shape[0] * rgb.shape[1]
        inside = (size > 0).all(axis=1) & (
            size.prod(axis=1) <= self._settings.max_area_share * area
        )
        inside &= ~_ends_at_inner_edge(boxes, view, rgb.shape[0], rgb.shape[1])
        return boxes[inside], scores[inside]

    def _run(self, part: RgbImage) -> tuple[FloatArray, FloatArray]:
        """Return boxes (n, 4) xmin, ymin, xmax, ymax as shares of ``part``, and scores."""
        small = cv2.resize(
            np.ascontiguousarray(part), (SIDE_PX, SIDE_PX), interpolation=cv2.INTER_AREA
        )
        pixels = small.astype(np.uint8, copy=False)
        if self._settings.stretch:
            pixels = stretched(pixels)
        try:
            outputs: list[Any] = self._session.run([BOXES, SCORES], {INPUT: pixels[None]})
        except ORT_ERRORS as error:
            raise Refused(
                f"model {self._path.name} fails on an image ({_first_line(error)}):"
                " use the model that comes with the package"
            ) from error
        raw_boxes, raw_scores = outputs
        anchors = raw_boxes.shape[1]
        if raw_boxes.shape != (1, anchors, 1, 4) or raw_scores.shape != (
            1,
            anchors,
            len(self._names),
        ):
            raise Refused(
                f"model {self._path.name} gives boxes {raw_boxes.shape} and scores"
                f" {raw_scores.shape} for {len(self._names)} classes: use a model with the"
                " outputs that MODEL_CARD.md describes"
            )
        boxes = raw_boxes[0, :, 0, [1, 0, 3, 2]].T.astype(np.float64)
        scores = np.nan_to_num(raw_scores[0][:, self._columns].astype(np.float64))
        return boxes, np.clip(scores, 0.0, 1.0)

    def _detection(self, box: FloatArray, scores: FloatArray, best: int) -> Detection:
        """Return one detection with its class distribution.

        The model scores every class on its own; divided by their sum (at least 1, so that
        doubt stays doubt) they become shares.
        """
        shares = scores / max(1.0, float(scores.sum()))
        top = np.argsort(-shares, kind="stable")[: self._settings.top_classes]
        return Detection(
            box_px=(float(box[0]), float(box[1]), float(box[2]), float(box[3])),
            score=float(scores[best]),
            name=self._kept_names[best],
            classes=tuple((self._kept_names[i], float(shares[i])) for i in top),
        )


def stretched(rgb: RgbImage) -> RgbImage:
    """Return the image with its darkest percent black and its brightest percent white."""
    low, high = np.percentile(rgb, STRETCH_PERCENTILES)
    scale = 255.0 / max(high - low, MIN_STRETCH_RANGE)
    result: RgbImage = np.clip(np.rint((rgb.astype(np.float32) - low) * scale), 0, 255).astype(
        np.uint8
    )
    return result


def _ends_at_inner_edge(
    boxes: FloatArray, view: View, height_px: int, width_px: int
) -> NDArray[np.bool_]:
    """Tell which boxes (n, 4) px end where the view ends but the image goes on."""
    x, y, wide, high, _ = view
    margin = EDGE_SHARE * max(wide, high)
    cut = np.zeros(len(boxes), dtype=np.bool_)
    for column, edge, inner in (
        (0, x, x > 0),
        (1, y, y > 0),
        (2, x + wide, x + wide < width_px),
        (3, y + high, y + high < height_px),
    ):
        if inner:
            cut |= np.abs(boxes[:, column] - edge) < margin
    return cut


def _load(path: Path, threads: int) -> Any:
    """Return the checked session of a model file."""
    advice = "set perception.model to the detector's file, or leave it empty"
    if not path.is_file():
        raise Refused(f"model file {path} is missing: {advice}")
    data = path.read_bytes()
    checksum = path.with_name(path.name + ".sha256")
    if checksum.is_file():
        expected = checksum.read_text(encoding="utf-8").split()[:1]
        if [hashlib.sha256(data).hexdigest()] != expected:
            raise Refused(
                f"model file {path} is corrupt: it does not have the sha256 of {checksum.name};"
                " install the package again"
            )
    options = ort.SessionOptions()  # type: ignore[attr-defined]
    options.intra_op_num_threads = threads
    options.inter_op_num_threads = 1
    options.log_severity_level = 4
    try:
        session = ort.InferenceSession(  # type: ignore[attr-defined]
            data, options, providers=["CPUExecutionProvider"]
        )
    except ORT_ERRORS as error:
        raise Refused(
            f"model file {path} is no ONNX model that can be run ({_first_line(error)}): {advice}"
        ) from error
    inputs = [(value.name, value.type) for value in session.get_inputs()]
    outputs = {value.name: value.type for value in session.get_outputs()}
    wanted = {BOXES: "tensor(float)", SCORES: "tensor(float)"}
    if inputs != [(INPUT, "tensor(uint8)")] or any(
        outputs.get(name) != kind for name, kind in wanted.items()
    ):
        raise Refused(
            f"model file {path} takes {[name for name, _ in inputs]} and gives {list(outputs)},"
            f" but the detector takes uint8 '{INPUT}' and gives '{BOXES}' and '{SCORES}': {advice}"
        )
    return session


def _read_classes(path: Path) -> list[str]:
    """Return the canonical name of each score column; empty where COCO has none."""
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise Refused(
            f"class list {path} cannot be read: put one name per line beside the model"
        ) from error
    return ["" if line.strip() in {"", "-"} else canonical_name(line) for line in lines]


def _first_line(error: Exception) -> str:
    """Return the first line of onnxruntime's message, short."""
    return (str(error).splitlines() or ["no reason given"])[0][:120]
