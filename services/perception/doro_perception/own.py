"""A user's own detector, described by a TOML file: the backend ``onnx``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from doro_perception.backend import Detection, RgbImage, suppressed
from doro_perception.own_description import Description, read_description
from doro_perception.own_layouts import decode_outputs, output_names
from doro_perception.sessions import Port, Session
from doro_perception.settings import PerceptionSettings
from doro_perception.stages import Stages
from doro_schemas.errors import Refused

ADVICE = "correct the file that perception.detector names"
PADDING = 114
KINDS = {"float32": "tensor(float)", "uint8": "tensor(uint8)"}


class OwnDetector:
    """The backend ``onnx``; loading checks the model against its description.

    Raises:
        Refused: no description, or a model that is missing, corrupt or of other inputs and
            outputs than described.
    """

    def __init__(self, settings: PerceptionSettings, stages: Stages | None = None) -> None:
        if not settings.detector:
            raise Refused(
                "perception.backend is 'onnx', but perception.detector names no description of a"
                " detector: name a TOML file, or use the backend 'captioner' or 'coco'"
            )
        path = Path(settings.detector)
        self.description: Description = read_description(path)
        self._settings = settings
        self._stages = stages or Stages()
        self._session = Session(path.parent / self.description.model, settings.threads, ADVICE)
        self._input = self._checked_input()
        given = [port.name for port in self._session.outputs]
        missing = [name for name in output_names(self.description) if name not in given]
        if missing:
            raise Refused(
                f"model {self._session.path.name} has no output '{missing[0]}', it gives"
                f" {', '.join(given)}: name the right ones under [output]"
            )
        self.names = self.description.names()

    def warm_up(self) -> None:
        """Look at a gray image, which also checks the shapes of the outputs."""
        side = (self.description.input.height_px, self.description.input.width_px)
        self.detect(np.full((*side, 3), 127, np.uint8))

    def detect(self, rgb: RgbImage) -> list[Detection]:
        """Return the detections of an image, best first, suppressed across classes."""
        use = self.description
        pixels, scale = self._fitted(rgb)
        names = output_names(use)
        values = self._session.run(names, {self._input.name: self._as_input(pixels)})
        self._stages.lap("model")
        boxes, scores = decode_outputs(use, dict(zip(names, values, strict=True)))
        reported = np.array([bool(name) for name in self.names])
        best = np.where(reported, scores, 0.0).max(axis=1, initial=0.0)
        good = (best >= use.score_threshold) & np.isfinite(boxes).all(axis=1)
        good &= (boxes[:, 2:] > boxes[:, :2]).all(axis=1)
        boxes, scores, best = boxes[good], scores[good], best[good]
        kept = suppressed(boxes, best, use.nms_iou)[: use.max_boxes]
        self._stages.lap("decode boxes")
        return [self._detection(boxes[k] / scale, scores[k] * reported) for k in kept]

    def _detection(self, box: NDArray[Any], scores: NDArray[Any]) -> Detection:
        shares = scores / max(1.0, float(scores.sum()))
        order = np.argsort(-shares, kind="stable")[: self._settings.top_classes]
        best = int(scores.argmax())
        return Detection(
            box_px=(float(box[0]), float(box[1]), float(box[2]), float(box[3])),
            score=float(scores[best]),
            name=self.names[best],
            classes=tuple((self.names[k], float(shares[k])) for k in order if shares[k] > 0),
        )

    def _fitted(self, rgb: RgbImage) -> tuple[RgbImage, NDArray[np.float64]]:
        """Return the image at the input's size, and what its boxes are to be divided by."""
        use = self.description.input
        height, width = rgb.shape[:2]
        scale = np.array([use.width_px / width, use.height_px / height])
        if use.fit == "letterbox":
            scale[:] = scale.min()
        wide = max(1, min(use.width_px, round(width * scale[0])))
        high = max(1, min(use.height_px, round(height * scale[1])))
        how = cv2.INTER_AREA if scale.min() < 1 else cv2.INTER_LINEAR
        small = cv2.resize(np.ascontiguousarray(rgb), (wide, high), interpolation=how)
        canvas = np.full((use.height_px, use.width_px, 3), PADDING, np.uint8)
        canvas[:high, :wide] = small
        return canvas, np.tile([wide / width, high / height], 2)

    def _as_input(self, pixels: RgbImage) -> NDArray[Any]:
        use = self.description.input
        image: NDArray[Any] = pixels[..., ::-1] if use.channels == "bgr" else pixels
        if use.type == "float32":
            image = ((image - np.asarray(use.mean)) / np.asarray(use.std)).astype(np.float32)
        if use.order == "nchw":
            image = image.transpose(2, 0, 1)
        return np.ascontiguousarray(image[None])

    def _checked_input(self) -> Port:
        use, inputs = self.description.input, self._session.inputs
        sides: tuple[int, ...] = (use.height_px, use.width_px, 3)
        if use.order == "nchw":
            sides = (3, use.height_px, use.width_px)
        if len(inputs) == 1 and inputs[0].kind == KINDS[use.type]:
            shape = inputs[0].shape
            fixed = [have for have, want in zip(shape[1:], sides, strict=False) if have != want]
            free = [side for side in fixed if not isinstance(side, int)]
            batch_free = not isinstance(shape[0], int) or shape[0] == 1 if shape else False
            if len(shape) == 4 and batch_free and len(free) == len(fixed):
                return inputs[0]
        raise Refused(
            f"model {self._session.path.name} takes {', '.join(map(str, inputs)) or 'nothing'},"
            f" but the description says one image, {use.type} {[1, *sides]} ({use.order}):"
            " correct [input]"
        )
