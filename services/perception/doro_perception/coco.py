"""SSDLite-MobileNetV2 (COCO) as a detector: where to look, and what to keep.

The model names a thing well when it fills a good part of the image, and hardly when it is
small in a wide view (README, "Measured"). So the image is looked at as a whole and in tiles,
then once more at a square around each of the best candidates, of whatever class; with
second looks only those decide.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from doro_perception.backend import Detection, RgbImage, suppressed
from doro_perception.coco_model import SIDE_PX, SsdModel
from doro_perception.settings import PerceptionSettings
from doro_perception.stages import Stages

TILE_SHARE = {2: 0.625, 3: 0.5}
# A tile sees a part of a thing as a whole thing: a box that ends at an inner edge is dropped.
EDGE_SHARE = 0.02
CANDIDATE_SCORE = 0.08
CANDIDATE_IOU = 0.5
CLOSE_UP_MARGIN = 0.5
MIN_CLOSE_UP_PX = 48.0
# What is small in the close-up is not what was looked at.
MIN_CLOSE_UP_SHARE = 0.1

FloatArray = NDArray[np.float64]
View = tuple[int, int, int, int, bool]
"""A part of the image: (x, y, width, height) px, mirrored or not."""
Seen = tuple[FloatArray, FloatArray]
"""Boxes (n, 4) px of the image, and scores (n, classes)."""


class CocoSsd:
    """The detector; loading checks the model.

    Raises:
        Refused: see :class:`doro_perception.coco_model.SsdModel`.
    """

    def __init__(self, settings: PerceptionSettings, stages: Stages | None = None) -> None:
        self._settings = settings
        self._stages = stages or Stages()
        self._model = SsdModel(settings)
        self.names = self._model.names
        default = settings.score_threshold
        self._thresholds = np.array(
            [settings.class_thresholds.get(name, default) for name in self.names]
        )

    def warm_up(self) -> None:
        """Run once on a gray image, which also checks the shapes of the outputs."""
        self.detect(np.full((SIDE_PX, SIDE_PX, 3), 127, dtype=np.uint8))

    def detect(self, rgb: RgbImage) -> list[Detection]:
        """Return the detections of an image, best first, suppressed across classes."""
        seen = [self._look(rgb, view) for view in self._views(rgb.shape[0], rgb.shape[1])]
        if self._settings.second_looks:
            seen = self._second_looks(rgb, _joined(seen))
        boxes, scores = _joined(seen)
        self._stages.lap("model")
        passing = np.where(scores >= self._thresholds, scores, 0.0)
        best = passing.max(axis=1, initial=0.0)
        good = best > 0
        boxes, scores, passing, best = boxes[good], scores[good], passing[good], best[good]
        return [
            self._detection(boxes[index], scores[index], int(passing[index].argmax()))
            for index in suppressed(boxes, best, self._settings.nms_iou)
        ]

    def _views(self, height_px: int, width_px: int) -> list[View]:
        """Return what to look at first: the whole image, then what the settings add."""
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

    def _second_looks(self, rgb: RgbImage, candidates: Seen) -> list[Seen]:
        """Look closely at the best candidates of the first look."""
        boxes, scores = candidates
        best = scores.max(axis=1, initial=0.0)
        chosen = suppressed(boxes, best, CANDIDATE_IOU)[: self._settings.second_looks]
        seen = [(boxes[:0], scores[:0])]
        for index in chosen:
            view = _close_up(boxes[index], rgb.shape[0], rgb.shape[1])
            near_boxes, near_scores = self._look(rgb, view)
            areas = (near_boxes[:, 2:] - near_boxes[:, :2]).prod(axis=1)
            large = areas >= MIN_CLOSE_UP_SHARE * view[2] * view[3]
            seen.append((near_boxes[large], near_scores[large]))
        return seen

    def _look(self, rgb: RgbImage, view: View) -> Seen:
        """Return what one view shows, down to ``CANDIDATE_SCORE``."""
        x, y, wide, high, mirrored = view
        part = rgb[y : y + high, x : x + wide]
        boxes, scores = self._model.run(part[:, ::-1] if mirrored else part)
        if mirrored:
            boxes = np.stack([1 - boxes[:, 2], boxes[:, 1], 1 - boxes[:, 0], boxes[:, 3]], axis=1)
        least = np.minimum(self._thresholds, CANDIDATE_SCORE)
        keep = (scores >= least).any(axis=1) & np.isfinite(boxes).all(axis=1)
        boxes, scores = np.clip(boxes[keep], 0.0, 1.0), scores[keep]
        boxes = boxes * [wide, high, wide, high] + [x, y, x, y]
        size = boxes[:, 2:] - boxes[:, :2]
        largest = self._settings.max_area_share * rgb.shape[0] * rgb.shape[1]
        good = (size > 0).all(axis=1) & (size.prod(axis=1) <= largest)
        good &= ~_ends_at_inner_edge(boxes, view, rgb.shape[0], rgb.shape[1])
        return boxes[good], scores[good]

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
            name=self.names[best],
            classes=tuple((self.names[i], float(shares[i])) for i in top),
        )


def _joined(seen: list[Seen]) -> Seen:
    """Return what several views show as one."""
    return np.concatenate([boxes for boxes, _ in seen]), np.concatenate([rows for _, rows in seen])


def _close_up(box: FloatArray, height_px: int, width_px: int) -> View:
    """Return the square around a box, pushed into the image and cut to its shorter side."""
    wanted = max(box[2] - box[0], box[3] - box[1]) * (1 + CLOSE_UP_MARGIN)
    side = int(min(max(wanted, MIN_CLOSE_UP_PX), width_px, height_px))
    x = int(min(max((box[0] + box[2] - side) / 2, 0.0), width_px - side))
    y = int(min(max((box[1] + box[3] - side) / 2, 0.0), height_px - side))
    return x, y, side, side, False


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
