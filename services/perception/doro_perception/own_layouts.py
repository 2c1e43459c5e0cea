"""Outputs of three families of detectors as boxes and class scores."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from doro_perception.own_description import Description
from doro_schemas.errors import Refused

FloatArray = NDArray[np.float64]
Outputs = dict[str, NDArray[Any]]
Decoded = tuple[FloatArray, FloatArray]
"""Boxes (n, 4) xmin, ymin, xmax, ymax in pixels of the input, and scores (n, classes) 0..1."""


def output_names(use: Description) -> list[str]:
    """Return the outputs that a description needs."""
    return [name for name in (use.output.boxes, use.output.scores, use.output.labels) if name]


def decode_outputs(use: Description, outputs: Outputs) -> Decoded:
    """Return boxes and scores of one image.

    Raises:
        Refused: shapes that do not fit the layout or the number of classes.
    """
    boxes, scores = DECODERS[use.layout](use, outputs)
    scores = np.clip(np.nan_to_num(_activated(scores, use.output.activation)), 0.0, 1.0)
    if use.output.background == "first":
        scores = scores[:, 1:]
    elif use.output.background == "last":
        scores = scores[:, :-1]
    if scores.shape[1] != len(use.classes):
        raise Refused(
            f"{use.model} gives scores of {scores.shape[1]} classes, but the description names"
            f" {len(use.classes)}: name all of them in the model's order, and say in"
            " output.background whether one of the columns is for nothing"
        )
    return _edges(boxes, use), scores


def _ssd(use: Description, outputs: Outputs) -> Decoded:
    boxes = _rows(outputs[use.output.boxes], use.output.boxes, 4)
    if not use.output.labels:
        scores = outputs[use.output.scores]
        return _same_length(boxes, _rows(scores, use.output.scores, scores.shape[-1]), use)
    best = outputs[use.output.scores].reshape(-1).astype(np.float64)
    labels = outputs[use.output.labels].reshape(-1)
    extra = int(use.output.background in ("first", "last"))
    columns = len(use.classes) + extra
    scores = np.zeros((len(best), columns))
    number = np.nan_to_num(labels).astype(np.int64)
    if len(labels) != len(best):
        raise Refused(f"{use.model} gives {len(labels)} labels for {len(best)} scores")
    known = (number >= 0) & (number < columns)
    scores[np.flatnonzero(known), number[known]] = best[known]
    return _same_length(boxes, scores, use)


def _yolo(use: Description, outputs: Outputs) -> Decoded:
    """Rows or columns of (cx, cy, w, h[, objectness], class scores)."""
    name = use.output.boxes
    table = outputs[name].astype(np.float64)
    extra = int(use.output.background in ("first", "last"))
    wide = 4 + int(use.output.objectness) + len(use.classes) + extra
    table = table.reshape(table.shape[-2:]) if table.ndim == 3 and table.shape[0] == 1 else table
    if table.ndim == 2 and table.shape[0] == wide and table.shape[1] != wide:
        table = table.T
    if table.ndim != 2 or table.shape[1] != wide:
        raise Refused(
            f"output '{name}' of {use.model} has shape {list(outputs[name].shape)}, but"
            f" {len(use.classes)} classes make {wide} values a box: check classes and"
            " output.objectness in the description"
        )
    scores = table[:, 4:]
    if use.output.objectness:
        scores = scores[:, 1:] * table[:, 4:5]
    return table[:, :4], scores


def _detr(use: Description, outputs: Outputs) -> Decoded:
    scores = outputs[use.output.scores]
    boxes = _rows(outputs[use.output.boxes], use.output.boxes, 4)
    return _same_length(boxes, _rows(scores, use.output.scores, scores.shape[-1]), use)


DECODERS: dict[str, Callable[[Description, Outputs], Decoded]] = {
    "ssd": _ssd,
    "yolo": _yolo,
    "detr": _detr,
}


def _rows(values: NDArray[Any], name: str, columns: int) -> FloatArray:
    """Return (1, n, columns) or (1, n, 1, columns) as (n, columns)."""
    if values.ndim < 2 or values.shape[0] != 1 or values.shape[-1] != columns:
        raise Refused(
            f"output '{name}' has shape {list(values.shape)}, not [1, boxes, {columns}]: check"
            " the layout in the description"
        )
    return values.reshape(-1, columns).astype(np.float64)


def _same_length(boxes: FloatArray, scores: FloatArray, use: Description) -> Decoded:
    if len(boxes) != len(scores):
        raise Refused(
            f"{use.model} gives {len(boxes)} boxes and scores of {len(scores)}: check the names of"
            " the outputs in the description"
        )
    return boxes, scores


def _activated(scores: FloatArray, activation: str) -> FloatArray:
    if activation == "sigmoid":
        scores = 1 / (1 + np.exp(-np.clip(scores, -60, 60)))
    elif activation == "softmax":
        powers = np.exp(scores - scores.max(axis=1, keepdims=True))
        scores = powers / powers.sum(axis=1, keepdims=True)
    return scores


def _edges(boxes: FloatArray, use: Description) -> FloatArray:
    """Return xmin, ymin, xmax, ymax in pixels of the input."""
    if use.output.box_format == "yxyx":
        boxes = boxes[:, [1, 0, 3, 2]]
    elif use.output.box_format == "cxcywh":
        half = boxes[:, 2:] / 2
        boxes = np.hstack([boxes[:, :2] - half, boxes[:, :2] + half])
    if use.output.box_units == "share":
        boxes = boxes * np.array([use.input.width_px, use.input.height_px] * 2, np.float64)
    return boxes
