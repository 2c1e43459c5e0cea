"""The SSDLite model file: checked at load, run on one image part at a time.

See models/coco_ssdlite/MODEL_CARD.md.
"""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from doro_perception.backend import RgbImage
from doro_perception.sessions import Session
from doro_perception.settings import PerceptionSettings
from doro_schemas.errors import Refused
from doro_schemas.vocabulary import canonical_name

PACKAGED_MODEL = Path(__file__).parent / "models" / "coco_ssdlite" / "coco_ssd_lite.onnx"
CLASSES_FILE = "coco_classes.txt"
INPUT = "image_tensor:0"
BOXES = "Postprocessor/ExpandDims_1:0"
SCORES = "Postprocessor/Slice:0"
SIDE_PX = 300
ADVICE = "set perception.model to the detector's file, or leave it empty"
STRETCH_PERCENTILES = (1.0, 99.0)
# A flat wall is not stretched to full contrast.
MIN_STRETCH_RANGE = 60.0


class SsdModel:
    """A loaded model and its class list.

    Attributes:
        names: canonical names of the classes that count, in the order of ``run``'s columns.

    Raises:
        Refused: a model or class list that is missing, corrupt, or another one.
    """

    def __init__(self, settings: PerceptionSettings) -> None:
        path = Path(settings.model) if settings.model else PACKAGED_MODEL
        self._path = path
        self._stretch = settings.stretch
        self._session = Session(path, settings.threads, ADVICE)
        kinds = {BOXES: "tensor(float)", SCORES: "tensor(float)"}
        self._session.need({INPUT: "tensor(uint8)"}, kinds)
        names = _read_classes(path.with_name(CLASSES_FILE))
        left_out = {"", *settings.coco_leave_out}
        self._class_count = len(names)
        self._columns = [column for column, name in enumerate(names) if name not in left_out]
        self.names = [names[column] for column in self._columns]
        if not self.names:
            raise Refused("perception.coco_leave_out leaves no class: remove some names from it")

    def run(self, part: RgbImage) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return boxes (n, 4) xmin, ymin, xmax, ymax as shares of ``part``, and scores."""
        small = cv2.resize(
            np.ascontiguousarray(part), (SIDE_PX, SIDE_PX), interpolation=cv2.INTER_AREA
        )
        pixels = small.astype(np.uint8, copy=False)
        if self._stretch:
            pixels = stretched(pixels)
        raw_boxes, raw_scores = self._session.run([BOXES, SCORES], {INPUT: pixels[None]})
        anchors = raw_boxes.shape[1]
        if raw_boxes.shape != (1, anchors, 1, 4) or raw_scores.shape != (
            1,
            anchors,
            self._class_count,
        ):
            raise Refused(
                f"model {self._path.name} gives boxes {raw_boxes.shape} and scores"
                f" {raw_scores.shape} for {self._class_count} classes: use a model with the"
                " outputs that MODEL_CARD.md describes"
            )
        boxes = raw_boxes[0, :, 0, [1, 0, 3, 2]].T.astype(np.float64)
        scores = np.nan_to_num(raw_scores[0][:, self._columns].astype(np.float64))
        return boxes, np.clip(scores, 0.0, 1.0)


def stretched(rgb: RgbImage) -> RgbImage:
    """Return the image with its darkest percent black and its brightest percent white."""
    low, high = np.percentile(rgb, STRETCH_PERCENTILES)
    scale = 255.0 / max(high - low, MIN_STRETCH_RANGE)
    result: RgbImage = np.clip(np.rint((rgb.astype(np.float32) - low) * scale), 0, 255).astype(
        np.uint8
    )
    return result


def _read_classes(path: Path) -> list[str]:
    """Return the canonical name of each score column; empty where COCO has none."""
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise Refused(
            f"class list {path} cannot be read: put one name per line beside the model"
        ) from error
    return ["" if line.strip() in {"", "-"} else canonical_name(line) for line in lines]
