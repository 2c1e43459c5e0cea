"""Our own captioner: boxes from a proposer, then class, colour and material of each box.

Two networks trained on rendered rooms (models/captioner/MODEL_CARD.md). The proposer finds
boxes with a first opinion of the class; the crop net looks at each box alone. Both opinions
are multiplied, the score is calibrated, and the distributions travel with the detection: the
map decides from many views.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import msgspec
import numpy as np
from numpy.typing import NDArray

from doro_perception.backend import (
    Detection,
    RgbImage,
    Shares,
    intersection_over_union,
    without_doubles,
)
from doro_perception.classes import CLASSES, COLOURS, MATERIALS, class_names
from doro_perception.crop_reader import CropReader
from doro_perception.sessions import Session
from doro_perception.settings import PerceptionSettings
from doro_perception.stages import Stages
from doro_schemas.errors import Refused

PACKAGED_FOLDER = Path(__file__).parent / "models" / "captioner"
PROPOSER, CROPS, CALIBRATION = "proposer.onnx", "crops.onnx", "calibration.json"
ADVICE = "set perception.captioner to the folder of its models, or leave it empty"
PADDING = 114
UNNAMED, NOTHING = len(CLASSES), len(CLASSES) + 1
FLOOR = 0.01
"""The least that the proposer gives a class at a place."""
SAME_PLACE_IOU = 0.55
FloatArray = NDArray[np.float64]


class Calibration(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What was fitted on the calibration rooms after the training.

    Attributes:
        temperature, color_temperature, material_temperature: logits are divided by them.
        detector_share: weight of the proposer's opinion of the class, as an exponent.
        class_share: how much the class counts in the raw score, 0..1; the rest is the box's.
        scale, offset: of the logit of the raw score.
        material_prior: how often a thing of each class is of each material, (classes, materials).
        prior_share: exponent of the prior.
    """

    temperature: float = 1.0
    color_temperature: float = 1.0
    material_temperature: float = 1.0
    detector_share: float = 0.3
    class_share: float = 0.5
    scale: float = 1.0
    offset: float = 0.0
    material_prior: tuple[tuple[float, ...], ...] = ()
    prior_share: float = 0.5


class Candidates(msgspec.Struct, frozen=True):
    """Boxes of an image, (n, 4) px, with the proposer's opinion, (n, classes + 1)."""

    boxes: FloatArray
    opinions: FloatArray


class Read(msgspec.Struct, frozen=True):
    """What the crop net says of n boxes: probabilities (n, classes + 2), (n, 11), (n, 9)."""

    kinds: FloatArray
    colors: FloatArray
    materials: FloatArray


class Captioner:
    """The backend ``captioner``.

    Raises:
        Refused: a file of the model is missing, corrupt or another one.
    """

    def __init__(self, settings: PerceptionSettings, stages: Stages | None = None) -> None:
        folder = Path(settings.captioner) if settings.captioner else PACKAGED_FOLDER
        self._settings = settings
        self._stages = stages or Stages()
        image, floats = "tensor(uint8)", "tensor(float)"
        self._proposer = Session(folder / PROPOSER, settings.threads, ADVICE)
        self._proposer.need({"image": image}, {"boxes": floats, "scores": floats, "kinds": floats})
        self._side_px = square_side_px(self._proposer)
        self._crops = CropReader(folder / CROPS, settings.threads, ADVICE)
        self.calibration = read_calibration(folder / CALIBRATION)
        self._prior = np.asarray(self.calibration.material_prior, np.float64)
        if self._prior.shape != (len(CLASSES), len(MATERIALS)):
            self._prior = np.full((len(CLASSES), len(MATERIALS)), 1 / len(MATERIALS))
        self._names = class_names()
        self._left_out = np.array([name in settings.captioner_leave_out for name in self._names])

    def warm_up(self) -> None:
        """Look at a gray image and a crop, which also checks the shapes of the outputs."""
        gray = np.full((self._side_px, self._side_px, 3), 127, np.uint8)
        self.detect(gray)
        self.read(gray, np.array([[10.0, 10.0, 200.0, 200.0]]))

    def detect(self, rgb: RgbImage) -> list[Detection]:
        """Return named and nameless detections, best first."""
        found = self.propose(rgb)
        self._stages.lap("propose")
        if not len(found.boxes):
            return []
        seen = self.read(rgb, found.boxes)
        self._stages.lap("crops")
        kinds, scores = self.fuse(found, seen)
        detections = [
            self._detection(found.boxes[k], kinds[k], float(scores[k]), (seen, k))
            for k in range(len(found.boxes))
        ]
        self._stages.lap("fuse")
        kept = sorted([one for one in detections if one is not None], key=lambda one: -one.score)
        return without_doubles(kept, self._settings.double_iou)

    def propose(self, rgb: RgbImage) -> Candidates:
        """Return the places that may hold a thing, merged over classes, best first."""
        image, scale = fitted(rgb, self._side_px)
        raw, score, kind = self._peaks(image)
        if self._settings.mirror:
            # Beside the mirrored image lies the padding of a wide or high one: mirror all of it.
            other, more, kinds = self._peaks(np.ascontiguousarray(image[:, ::-1]))
            turned = np.column_stack([self._side_px - other[:, 2], other[:, 1]])
            turned = np.column_stack([turned, self._side_px - other[:, 0], other[:, 3]])
            raw, score = np.vstack([raw, turned]), np.concatenate([score, more])
            kind = np.vstack([kind, kinds])
        good = np.flatnonzero(
            (score >= self._settings.candidate_score) & np.isfinite(raw).all(axis=1)
        )
        order = good[np.argsort(-score[good], kind="stable")]
        limits = np.array([rgb.shape[1], rgb.shape[0]] * 2, np.float64)
        places = np.clip(raw / scale, 0, limits)
        kept: list[int] = []
        opinions: list[FloatArray] = []
        for k in order.tolist():
            if (places[k, 2:] - places[k, :2]).min() < 2:
                continue
            overlaps = intersection_over_union(places[k], places[kept]) if kept else np.zeros(1)
            same = int(overlaps.argmax())
            if overlaps[same] > SAME_PLACE_IOU:
                np.maximum(opinions[same], kind[k], out=opinions[same])
            elif len(kept) < self._settings.max_boxes:
                kept.append(k)
                opinions.append(np.maximum(kind[k], FLOOR))
        return Candidates(places[kept], np.asarray(opinions).reshape(-1, UNNAMED + 1))

    def _peaks(self, image: RgbImage) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return boxes (n, 4) in pixels of the input, scores (n,) and what the classes'
        maps say there (n, classes + 1).
        """
        boxes, scores, kinds = self._proposer.run(
            ["boxes", "scores", "kinds"], {"image": image[None]}
        )
        wide = (*scores.shape, UNNAMED + 1)
        if boxes.shape != (*scores.shape, 4) or kinds.shape != wide:
            raise Refused(
                f"model {self._proposer.path.name} gives boxes {boxes.shape}, scores"
                f" {scores.shape} and kinds {kinds.shape}, which do not fit together: {ADVICE}"
            )
        score: FloatArray = np.nan_to_num(scores[0].astype(np.float64))
        told = np.nan_to_num(np.asarray(kinds[0], np.float64))
        return boxes[0].astype(np.float64), score, np.clip(told, 0.0, 1.0)

    def read(self, rgb: RgbImage, boxes: FloatArray) -> Read:
        """Return what the crop net says of each box."""
        logits = self._crops.logits(rgb, boxes)
        use = self.calibration
        heat = (use.temperature, use.color_temperature, use.material_temperature)
        return Read(*(softmax(item / t) for item, t in zip(logits, heat, strict=True)))

    def fuse(self, found: Candidates, seen: Read) -> tuple[FloatArray, FloatArray]:
        """Return class probabilities (n, classes + 2) and calibrated scores (n,).

        The raw score is a geometric mean of "there is something" and "it is this class".
        """
        use = self.calibration
        opinions = np.column_stack([found.opinions, np.full(len(found.boxes), FLOOR)])
        opinions = opinions / opinions.sum(axis=1, keepdims=True)
        kinds = seen.kinds * opinions**use.detector_share
        # That nothing is there is the crop net's own word: the proposer has no such class.
        nothing = seen.kinds[:, NOTHING]
        rest = kinds[:, :NOTHING]
        rest = rest / np.maximum(rest.sum(axis=1, keepdims=True), 1e-12)
        kinds = np.column_stack([rest * (1 - nothing)[:, None], nothing])
        something = found.opinions.max(axis=1)
        best = kinds[:, :UNNAMED].max(axis=1)
        raw = something ** (1 - use.class_share) * best**use.class_share
        return kinds, calibrated(raw, use)

    def _detection(
        self, box: FloatArray, kinds: FloatArray, score: float, seen: tuple[Read, int]
    ) -> Detection | None:
        settings = self._settings
        read, k = seen
        best = int(kinds[:UNNAMED].argmax())
        name = self._names[best]
        # What is left out is not named otherwise: a window is no mirror.
        if self._left_out[best]:
            return None
        edges = (float(box[0]), float(box[1]), float(box[2]), float(box[3]))
        threshold = settings.class_thresholds.get(name, settings.captioner_threshold)
        if score >= threshold and kinds[best] > 0:
            return Detection(
                box_px=edges,
                score=score,
                name=name,
                classes=top(self._names, kinds[:UNNAMED], settings.top_classes),
                colors=top(COLOURS, read.colors[k], settings.top_attributes),
                materials=top(MATERIALS, self.material(kinds, read.materials[k]), 3),
                calibrated=True,
            )
        there = float(1 - kinds[NOTHING]) * float(kinds[UNNAMED] + kinds[:UNNAMED].sum())
        if there >= settings.unnamed_threshold and kinds[UNNAMED] >= kinds[best]:
            return Detection(box_px=edges, score=min(1.0, there), name="")
        return None

    def material(self, kinds: FloatArray, image: FloatArray) -> FloatArray:
        """Return material probabilities: the image chooses among what the class is made of."""
        share = kinds[:UNNAMED] / max(float(kinds[:UNNAMED].sum()), 1e-12)
        prior: FloatArray = share @ self._prior
        mixed = image * np.maximum(prior, 1e-3) ** self.calibration.prior_share
        result: FloatArray = mixed / mixed.sum()
        return result


def read_calibration(path: Path) -> Calibration:
    """Return the calibration beside the models.

    Raises:
        Refused: the file is missing or damaged.
    """
    try:
        return msgspec.json.decode(path.read_bytes(), type=Calibration)
    except OSError as error:
        raise Refused(f"{path} cannot be read ({error.strerror}): {ADVICE}") from error
    except msgspec.MsgspecError as error:
        raise Refused(f"{path} is no calibration ({error}): {ADVICE}") from error


def square_side_px(proposer: Session) -> int:
    """Return the side of the images that a proposer takes.

    Raises:
        Refused: it takes others than (1, side, side, 3) of a fixed side.
    """
    shape = proposer.inputs[0].shape
    side = shape[1] if len(shape) == 4 else None
    if not isinstance(side, int) or side < 1 or shape[2:] != (side, 3):
        raise Refused(
            f"model {proposer.path.name} takes images {list(shape)}, not"
            f" (1, side, side, 3) of a fixed side: {ADVICE}"
        )
    return side


def fitted(rgb: RgbImage, side_px: int) -> tuple[RgbImage, float]:
    """Return the image scaled into a square, gray below or beside it, and the scale."""
    height, width = rgb.shape[:2]
    scale = side_px / max(height, width)
    wide, high = max(1, round(width * scale)), max(1, round(height * scale))
    how = cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR
    small = cv2.resize(np.ascontiguousarray(rgb), (wide, high), interpolation=how)
    if (wide, high) == (side_px, side_px):
        return np.asarray(small, np.uint8), scale
    canvas = np.full((side_px, side_px, 3), PADDING, np.uint8)
    canvas[:high, :wide] = small
    return canvas, scale


def softmax(logits: NDArray[Any]) -> FloatArray:
    """Return probabilities along the last axis."""
    shifted = logits.astype(np.float64) - logits.max(axis=-1, keepdims=True)
    powers = np.exp(shifted)
    result: FloatArray = powers / powers.sum(axis=-1, keepdims=True)
    return result


def calibrated(raw: FloatArray, use: Calibration) -> FloatArray:
    """Return the share of right ones among detections of a raw score (Platt, 1999)."""
    clipped = np.clip(raw, 1e-4, 1 - 1e-4)
    logit = np.log(clipped / (1 - clipped)) * use.scale + use.offset
    result: FloatArray = 1 / (1 + np.exp(-logit))
    return result


def top(words: tuple[str, ...], shares: FloatArray, count: int) -> Shares:
    """Return the likeliest words with their shares; at most ``count``, none below 0.001."""
    order = np.argsort(-shares, kind="stable")[:count]
    return tuple((words[k], float(shares[k])) for k in order if shares[k] >= 0.001)
