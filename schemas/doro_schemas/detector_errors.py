"""Error models of a detector: one pure, seeded function over the detections of a frame.

Paper, Section V-B, with its parameters: centroid shift (``cs``), shape distortion (``sd``),
false negatives (``fn``) and false positives (``fp``). Perception's oracle, the evaluation and
``doro play --errors`` share this function, so that they mean the same.

What a frame gets depends on (seed, episode, camera, frame) alone, never on the order of
frames or on which other errors are on: each error draws from a stream of its own.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Literal, get_args

import msgspec
import numpy as np

from doro_schemas.errors import Refused
from doro_schemas.messages import SimDetection, SimDetections

ErrorName = Literal["cs", "sd", "fn", "fp"]
ERROR_NAMES: tuple[ErrorName, ...] = get_args(ErrorName)
FALSE_POSITIVE = "FalsePositive"
THOR_ROOM = re.compile(r"FloorPlan(_[A-Za-z]+)?\d+(_\d+)?")


class ErrorModels(msgspec.Struct, frozen=True, kw_only=True):
    """Which errors to make; the numbers are the paper's.

    Attributes:
        errors: any of ``cs``, ``sd``, ``fn``, ``fp``; applied in this order.
        seed: of all draws.
        shift_mean, shift_sigma: shift of the centre, as shares of the box's width and height.
        scale_mean, scale_sigma: change of the size, as a share; larger or smaller.
        miss_probability: of each detection (``fn``).
        extra_probability: of each frame (``fp``).
        min_side_px: boxes with a smaller side after clipping to the image are dropped.
    """

    errors: tuple[ErrorName, ...] = ()
    seed: int = 0
    shift_mean: float = 0.2
    shift_sigma: float = 0.04
    scale_mean: float = 0.2
    scale_sigma: float = 0.04
    miss_probability: float = 0.15
    extra_probability: float = 0.15
    min_side_px: float = 2.0


class PoolBox(msgspec.Struct, frozen=True):
    """A detection that may be pasted: its box as shares of the image's sides."""

    box: tuple[float, float, float, float]
    detection: SimDetection

    def __post_init__(self) -> None:
        left, top, right, bottom = self.box
        if not (0 <= left < right <= 1.01 and 0 <= top < bottom <= 1.01):
            raise ValueError(f"box {self.box} must be shares of the image's sides, in 0..1")


class FalsePositivePool(msgspec.Struct, frozen=True):
    """What false positives are drawn from: by room, the detections of each observation."""

    rooms: dict[str, list[list[PoolBox]]]

    def __post_init__(self) -> None:
        for room, views in self.rooms.items():
            if not views or not all(views):
                raise ValueError(f"room '{room}' has no view, or a view without a detection")


def parse_errors(text: str) -> tuple[ErrorName, ...]:
    """Return the errors of ``"cs,sd,fn"``, in the order of application; "" is none.

    Raises:
        Refused: an unknown name.
    """
    names = [part.strip() for part in text.split(",") if part.strip()]
    for name in names:
        if name not in ERROR_NAMES:
            raise Refused(
                f"error model '{name}' is unknown: use any of {', '.join(ERROR_NAMES)},"
                " separated by commas"
            )
    return tuple(name for name in ERROR_NAMES if name in names)


def room_of(episode: str) -> str:
    """Return the room that an episode's name tells: "FloorPlan5" of "copies-FloorPlan5-Cup".

    Where it has no iTHOR or RoboTHOR name in it, the part before the first "-" counts.
    """
    found = THOR_ROOM.search(episode)
    return found.group() if found else episode.partition("-")[0]


def disturb(
    frame: SimDetections, models: ErrorModels, pool: FalsePositivePool | None = None
) -> SimDetections:
    """Return the frame with the errors of ``models``; the input is not changed.

    Boxes are clipped to the image. A pasted detection has the object id
    ``FalsePositive|<room>|<its id there>``; depth stays that of this frame.

    Args:
        pool: needed for ``fp``; rooms with the name of the frame's own room are not used.

    Raises:
        Refused: ``fp`` without a pool, or a pool with no other room.
    """
    found = list(frame.detections)
    boxes = np.array([item.box_px for item in found], np.float64).reshape(-1, 4)
    if "cs" in models.errors:
        boxes = _shifted(boxes, models, _stream("cs", frame, models))
    if "sd" in models.errors:
        boxes = _scaled(boxes, models, _stream("sd", frame, models))
    kept = np.ones(len(found), np.bool_)
    if "fn" in models.errors:
        draws = _stream("fn", frame, models).random(len(found))
        kept = draws >= models.miss_probability
    sides = np.array([frame.width_px, frame.height_px] * 2, np.float64)
    boxes = np.clip(boxes, 0.0, sides)
    disturbed = [
        msgspec.structs.replace(item, box_px=[float(value) for value in box])
        for item, box, keep in zip(found, boxes, kept, strict=True)
        if keep and min(box[2] - box[0], box[3] - box[1]) >= models.min_side_px
    ]
    if "fp" in models.errors:
        disturbed += _pasted(frame, models, pool)
    return msgspec.structs.replace(frame, detections=disturbed)


def pool_of(frames: Iterable[SimDetections]) -> FalsePositivePool:
    """Return a pool of the given frames; their rooms follow from their episodes' names."""
    rooms: dict[str, list[list[PoolBox]]] = {}
    for frame in frames:
        sides = (frame.width_px, frame.height_px) * 2
        boxes = []
        for item in frame.detections:
            left, top, right, bottom = (
                max(0.0, value / side) for value, side in zip(item.box_px, sides, strict=True)
            )
            boxes.append(PoolBox((left, top, right, bottom), item))
        if boxes:
            rooms.setdefault(room_of(frame.episode), []).append(boxes)
    return FalsePositivePool(rooms)


def write_pool(path: Path, pool: FalsePositivePool) -> None:
    """Write a pool as JSON."""
    path.write_bytes(msgspec.json.encode(pool) + b"\n")


def read_pool(path: Path) -> FalsePositivePool:
    """Return the pool of a JSON file that :func:`write_pool` wrote.

    Raises:
        Refused: missing, or not such a file.
    """
    try:
        return msgspec.json.decode(path.read_bytes(), type=FalsePositivePool)
    except OSError as error:
        raise Refused(f"false-positive pool {path} cannot be read: {error.strerror}") from error
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise Refused(f"{path} is no false-positive pool: {error}") from error


def _stream(name: str, frame: SimDetections, models: ErrorModels) -> np.random.Generator:
    """Return the random numbers of one error in one frame."""
    key = f"{models.seed}\n{name}\n{frame.episode}\n{frame.camera}\n{frame.frame}"
    digest = hashlib.blake2b(key.encode(), digest_size=16).digest()
    return np.random.default_rng(int.from_bytes(digest, "big"))


def _shifted(
    boxes: np.ndarray[tuple[int, int], np.dtype[np.float64]],
    models: ErrorModels,
    random: np.random.Generator,
) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """Move each box towards a random quadrant, its shape intact."""
    shares = random.normal(models.shift_mean, models.shift_sigma, (len(boxes), 2))
    quadrant = random.integers(0, 2, (len(boxes), 2)) * 2 - 1
    offset = shares * quadrant * (boxes[:, 2:] - boxes[:, :2])
    return boxes + np.tile(offset, 2)


def _scaled(
    boxes: np.ndarray[tuple[int, int], np.dtype[np.float64]],
    models: ErrorModels,
    random: np.random.Generator,
) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """Make each box larger or smaller about its centre, both sides by the same share."""
    shares = random.normal(models.scale_mean, models.scale_sigma, len(boxes))
    larger = random.integers(0, 2, len(boxes)) * 2 - 1
    half = (boxes[:, 2:] - boxes[:, :2]) / 2 * (1 + larger * shares)[:, None]
    center = (boxes[:, :2] + boxes[:, 2:]) / 2
    return np.concatenate([center - half, center + half], axis=1)


def _pasted(
    frame: SimDetections, models: ErrorModels, pool: FalsePositivePool | None
) -> list[SimDetection]:
    """Return the false positive of a frame, if it gets one: a room, a view, a detection."""
    own = room_of(frame.episode)
    others = sorted(name for name in (pool.rooms if pool else {}) if name != own)
    if pool is None or not others:
        raise Refused(
            "false positives are drawn from other rooms: give a pool of another room than"
            f" '{own}' (perception.fp_pool)",
            episode=frame.episode,
            frame=frame.frame,
        )
    random = _stream("fp", frame, models)
    if random.random() >= models.extra_probability:
        return []
    room = others[int(random.integers(len(others)))]
    views = pool.rooms[room]
    view = views[int(random.integers(len(views)))]
    chosen = view[int(random.integers(len(view)))]
    sides = (frame.width_px, frame.height_px) * 2
    box_px = [share * side for share, side in zip(chosen.box, sides, strict=True)]
    if min(box_px[2] - box_px[0], box_px[3] - box_px[1]) < models.min_side_px:
        return []
    object_id = f"{FALSE_POSITIVE}|{room}|{chosen.detection.object_id}"
    return [msgspec.structs.replace(chosen.detection, object_id=object_id, box_px=box_px)]
