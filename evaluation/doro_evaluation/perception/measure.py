"""Perception measured: held-out rendered rooms, and real frames with hand-checked boxes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import msgspec
import numpy as np
from numpy.typing import NDArray

from doro_evaluation.dressing.frames import frames_of, rooms_of
from doro_evaluation.dressing.labels import UNNAMED_KIND, Labels
from doro_evaluation.figures import Figure
from doro_evaluation.perception.scores import (
    Tally,
    Truth,
    add_image,
    at_threshold,
    calibration_error,
    mean_precision,
    reliability,
)
from doro_perception.backend import Detection, RgbImage
from doro_perception.captioner import Captioner, top
from doro_perception.classes import CLASSES, COLOURS, MATERIALS, class_names
from doro_schemas.errors import Refused
from doro_schemas.vocabulary import canonical_name, split_camel_case
from doro_sim_feeder.rooms.classes import BY_TYPE

NAMES = class_names()
EVALUATED = tuple(canonical_name(split_camel_case(name)) for name in BY_TYPE)
SEED = 7
FRAMES_A_ROOM = 30
OPERATING_SCORES = (0.3, 0.5)
# What one hand-checked name stands for.
REAL_NAMES = {
    "Table": ("dining table", "coffee table", "side table", "desk"),
    "Sofa": ("sofa", "arm chair"),
    "Bottle": ("bottle", "wine bottle"),
}
Image = tuple[RgbImage, Truth]


@dataclass(frozen=True)
class Measured:
    """The tallies of one set of images: as detected, and of the truth's own boxes."""

    name: str
    images: int
    detected: Tally
    given: Tally


def rendered(frames: int = FRAMES_A_ROOM, seed: int = SEED, rooms: int = 0) -> Iterator[Image]:
    """Yield frames of the held-out rooms, as the evaluation renders them.

    Args:
        frames: of each room; rooms: only the first so many, 0: all.
    """
    chosen = rooms_of("held-out")
    for room in chosen[:rooms] if rooms else chosen:
        for image, labels in frames_of(room, seed, frames, dress=False):
            yield image, truth_of(labels)


def truth_of(labels: Labels) -> Truth:
    """Return the truth of labelled boxes; what has no class is not asked for."""
    named = (labels.kind >= 0) & (labels.kind < UNNAMED_KIND)
    return Truth(
        boxes=labels.box.astype(np.float64),
        names=tuple(
            frozenset([NAMES[kind]]) if known else frozenset()
            for kind, known in zip(labels.kind.tolist(), named.tolist(), strict=True)
        ),
        ignore=labels.ignore | ~named,
        colours=tuple(COLOURS[k] if k >= 0 else None for k in labels.colour.tolist()),
        materials=tuple(
            frozenset([MATERIALS[k]]) if k >= 0 else frozenset() for k in labels.material.tolist()
        ),
    )


class _RealBox(msgspec.Struct, frozen=True):
    c: str
    b: list[float]
    ig: int
    mats: list[str] | None = None


class _RealFrame(msgspec.Struct, frozen=True):
    f: str
    l: list[_RealBox]  # noqa: E741 - the file's own key


def real(folder: Path) -> Iterator[Image]:
    """Yield the real AI2-THOR event frames that have hand-checked boxes.

    Args:
        folder: with ``ai2thor_events`` and ``ai2thor_events_boxes``.

    Raises:
        Refused: they are not there.
    """
    path = folder / "ai2thor_events_boxes" / "boxes.json"
    try:
        rows = msgspec.json.decode(path.read_bytes(), type=list[_RealFrame])
    except (OSError, msgspec.MsgspecError) as error:
        raise Refused(f"{path} cannot be read ({error}): name the folder of the data") from error
    for row in rows:
        bgr = cv2.imread(str(folder / "ai2thor_events" / row.f), cv2.IMREAD_COLOR)
        if bgr is None:
            raise Refused(f"{folder / 'ai2thor_events' / row.f} is no image: get the data again")
        names = [REAL_NAMES.get(box.c, (canonical_name(split_camel_case(box.c)),)) for box in row.l]
        truth = Truth(
            boxes=np.array([box.b for box in row.l], np.float64).reshape(-1, 4),
            names=tuple(frozenset(words) for words in names),
            ignore=np.array([bool(box.ig) for box in row.l], np.bool_),
            materials=tuple(frozenset(m.lower() for m in box.mats or ()) for box in row.l),
        )
        yield np.ascontiguousarray(bgr[..., ::-1], dtype=np.uint8), truth


def measure(
    name: str,
    images: Iterator[Image],
    detect: Callable[[RgbImage], list[Detection]],
    captioner: Captioner | None = None,
) -> Measured:
    """Return the tallies of a detector on images.

    Args:
        detect: from pixels to detections, down to low scores.
        captioner: with it the truth's own boxes are named as well.
    """
    detected, given, count = Tally(), Tally(), 0
    for rgb, truth in images:
        count += 1
        add_image(detected, truth, detect(rgb))
        if captioner is not None:
            add_image(given, truth, _given(captioner, rgb, truth))
    return Measured(name, count, detected, given)


def _given(captioner: Captioner, rgb: RgbImage, truth: Truth) -> list[Detection]:
    """Return the truth's own boxes named by the crop net alone."""
    boxes: NDArray[np.float64] = truth.boxes[~truth.ignore]
    if not len(boxes):
        return []
    seen = captioner.read(rgb, boxes)
    named = seen.kinds[:, : len(CLASSES)]
    named = named / np.maximum(named.sum(axis=1, keepdims=True), 1e-12)
    found = []
    for k, box in enumerate(boxes):
        material = captioner.material(seen.kinds[k], seen.materials[k])
        found.append(
            Detection(
                box_px=(float(box[0]), float(box[1]), float(box[2]), float(box[3])),
                score=1.0,
                name=NAMES[int(named[k].argmax())],
                classes=top(NAMES, named[k], 5),
                colors=top(COLOURS, seen.colors[k], 3),
                materials=top(MATERIALS, material, 3),
            )
        )
    return found


def figures_of(measured: Measured) -> dict[str, Figure]:
    """Return the figures of a set of images, ``perception/<set>/...``."""
    tally, given, prefix = measured.detected, measured.given, f"perception/{measured.name}"
    overall, each = mean_precision(tally)
    figures: dict[str, Figure] = {
        f"{prefix}/images": measured.images,
        f"{prefix}/boxes": sum(tally.truths.values()),
        f"{prefix}/map50": overall,
        f"{prefix}/map50_evaluated": mean_precision(tally, EVALUATED)[0],
        f"{prefix}/recall": tally.share("recall"),
        f"{prefix}/calibration_error": calibration_error(tally.certain),
    }
    for metric in ("top1", "top3", "colour", "material"):
        figures[f"{prefix}/{metric}"] = tally.share(metric)
        if given.truths:
            figures[f"{prefix}/{metric}_given_box"] = given.share(metric)
    for score in OPERATING_SCORES:
        precision, recall = at_threshold(tally, score)
        figures[f"{prefix}/precision_at_{score}"] = precision
        figures[f"{prefix}/recall_at_{score}"] = recall
    for key, value in each.items():
        figures[f"{prefix}/ap/{key}"] = value
    for score, share, count in reliability(tally.certain):
        figures[f"{prefix}/reliability/{score:.2f}/right"] = share
        figures[f"{prefix}/reliability/{score:.2f}/count"] = count
    return {
        key: round(value, 4) if isinstance(value, float) else value
        for key, value in figures.items()
    }
