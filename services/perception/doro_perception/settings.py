"""Settings of perception: the table ``[perception]``."""

from __future__ import annotations

from typing import Literal

import msgspec

from doro_schemas.detector_errors import ErrorModels, parse_errors

STRUCTURE = (
    "Ceiling",
    "Door",
    "Doorframe",
    "Doorway",
    "Floor",
    "Room",
    "Wall",
    "Window",
)
NOT_HOUSEHOLD = (
    "airplane",
    "bear",
    "bench",
    "bicycle",
    "bird",
    "boat",
    "bus",
    "car",
    "cow",
    "elephant",
    "fire hydrant",
    "giraffe",
    "horse",
    "kite",
    "motorcycle",
    "parking meter",
    "person",
    "sheep",
    "skateboard",
    "skis",
    "snowboard",
    "stop sign",
    "surfboard",
    "tie",
    "traffic light",
    "train",
    "truck",
    "zebra",
)


class PerceptionSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What perception may be told.

    Attributes:
        backend: ``oracle`` says what the simulator knows; the others look at the images:
            ``captioner`` (trained on rendered rooms), ``coco`` (the SSDLite as it comes),
            ``onnx`` (a detector of your own).
        emit: ``captions`` (English) or ``graphs``.
        min_side_px, min_area_px: smaller boxes are left out (after clipping to the image).
        leave_out: AI2-THOR objectTypes that the oracle never reports; they stay landmarks.
        relation_joiner: word between two relations of an oracle's caption ("and"), or empty.
        errors: error models of the oracle, any of ``cs,sd,fn,fp`` (paper, Section V-B); empty:
            a perfect detector. See :mod:`doro_schemas.detector_errors`.
        error_seed: of what the error models draw.
        fp_pool: JSON file with detections of other rooms, needed by ``fp``.
        model: path of another model file with the same inputs and outputs; empty: the one
            that comes with the package. Its classes stand in ``coco_classes.txt`` beside it.
        threads: of onnxruntime; of the captioner's crop net so many boxes at once.
        score_threshold: detections below it are dropped.
        class_thresholds: other thresholds by canonical class name.
        nms_iou: of two boxes that overlap more, of whatever class, the better one stays.
        max_area_share: boxes over more of the image are dropped: on bare floors and walls the
            detector sees a bed or a table as large as the image.
        flip: look at the mirrored image as well.
        tiles: look at 2 x 2 or 3 x 3 overlapping tiles as well (small and far things); 0: none.
        stretch: stretch the contrast of what the detector sees (dim rooms).
        second_looks: look once more, closely, at this many of the best candidates; then only
            what is seen there counts. 0: what is seen at first counts.
        coco_leave_out: canonical names of classes that ``coco`` is not to report.
        top_classes, top_attributes: length of the distributions that go with each detection.
        colour: name the colour of each crop, where the backend does not know it.
        captioner: folder with other models of the captioner; empty: the packaged ones.
        captioner_leave_out: canonical names of classes that the captioner is not to report.
        captioner_threshold: calibrated scores below it are not reported as detections.
        double_iou: of two boxes of one name that overlap more, the better one stays.
        candidate_score: proposals below it are not looked at.
        mirror: the captioner looks for boxes in the mirrored image as well.
        max_boxes: at most so many proposals of a frame are looked at, the best ones.
        unnamed_threshold: what is surely there and has no name is reported from here on; above
            1: never.
        attribute_threshold: a colour or material less probable than this is not said.
        relations: relations between things seen in one image: ``off`` (the map finds them),
            ``boxes`` (from the boxes), ``depth`` (in metres, where the frame has depth).
        detector: the TOML file that describes your own detector (backend ``onnx``).
    """

    backend: Literal["oracle", "captioner", "coco", "onnx"] = "oracle"
    emit: Literal["captions", "graphs"] = "captions"
    min_side_px: float = 6.0
    min_area_px: float = 50.0
    leave_out: tuple[str, ...] = STRUCTURE
    relation_joiner: Literal["", "and"] = "and"
    errors: str = ""
    error_seed: int = 0
    fp_pool: str = ""
    model: str = ""
    threads: int = 1
    score_threshold: float = 0.4
    class_thresholds: dict[str, float] = {}
    nms_iou: float = 0.55
    max_area_share: float = 0.4
    flip: bool = False
    tiles: Literal[0, 2, 3] = 2
    stretch: bool = True
    second_looks: int = 8
    coco_leave_out: tuple[str, ...] = NOT_HOUSEHOLD
    top_classes: int = 5
    top_attributes: int = 3
    colour: bool = True
    captioner: str = ""
    captioner_leave_out: tuple[str, ...] = ("window",)
    captioner_threshold: float = 0.55
    double_iou: float = 0.4
    candidate_score: float = 0.08
    mirror: bool = False
    max_boxes: int = 20
    unnamed_threshold: float = 0.5
    attribute_threshold: float = 0.5
    relations: Literal["off", "boxes", "depth"] = "off"
    detector: str = ""

    def __post_init__(self) -> None:
        shares = [self.score_threshold, self.nms_iou, self.max_area_share, self.candidate_score]
        shares += [self.captioner_threshold, self.attribute_threshold, self.double_iou]
        if not all(0.0 <= share <= 1.0 for share in [*shares, *self.class_thresholds.values()]):
            raise ValueError("thresholds, nms_iou and max_area_share must be in 0..1")
        if not 1 <= self.max_boxes <= 100:
            raise ValueError(f"max_boxes must be in 1..100, got {self.max_boxes}")
        if not 1 <= self.threads <= 64:
            raise ValueError(f"threads must be in 1..64, got {self.threads}")
        counts = (self.min_side_px, self.min_area_px, self.top_classes, self.second_looks)
        if min(counts) < 0:
            raise ValueError("sizes, top_classes and second_looks must not be negative")
        if "fp" in parse_errors(self.errors) and not self.fp_pool:
            raise ValueError("errors has fp, so fp_pool must name a file with other rooms' boxes")

    def error_models(self) -> ErrorModels:
        """Return the error models that the oracle's detections are given."""
        return ErrorModels(errors=parse_errors(self.errors), seed=self.error_seed)
