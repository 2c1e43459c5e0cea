"""What a rendered picture shows: boxes with class, colour and material."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from doro_perception.classes import CLASSES, COLOURS, MATERIALS, UNNAMED
from doro_schemas.camera import Pose
from doro_sim_feeder.rooms.camera import Camera
from doro_sim_feeder.rooms.instances import BACKGROUND
from doro_sim_feeder.rooms.scene import Scene

UNNAMED_KIND = len(CLASSES)
LEAST_PX, LEAST_SIDE_PX, LEAST_SHOWN, LEAST_INSIDE, LEAST_FILLED = 30, 5.0, 0.25, 0.2, 0.06
TAUGHT = {name: number for number, name in enumerate(CLASSES)} | dict.fromkeys(
    UNNAMED, UNNAMED_KIND
)
# A poster is a picture with another name; one class for both.
TAUGHT["Poster"] = TAUGHT["Painting"]


@dataclass(frozen=True)
class Labels:
    """The boxes of one picture, in the columns of a shard (``frames.py``)."""

    box: NDArray[np.float32]
    kind: NDArray[np.int16]
    colour: NDArray[np.int8]
    material: NDArray[np.int8]
    ignore: NDArray[np.bool_]
    copy: NDArray[np.bool_]


def label(scene: Scene, ids: NDArray[np.int32], pose: Pose, camera: Camera) -> Labels:
    """Return the boxes of what a picture of instance ids shows."""
    counts = np.bincount(ids.ravel())
    rows: list[tuple[list[float], int, int, int, bool, bool]] = []
    for number in np.flatnonzero(counts):
        if number == 0:
            continue
        item = scene.instances[number - 1]
        if item.object_type in BACKGROUND or counts[number] < LEAST_PX / 2:
            continue
        mask = ids == number
        columns, lines = np.flatnonzero(mask.any(axis=0)), np.flatnonzero(mask.any(axis=1))
        box = np.array([columns[0], lines[0], columns[-1] + 1, lines[-1] + 1], np.float64)
        hidden = _hidden(box, int(counts[number]), np.stack(item.corners), pose, camera)
        kind = TAUGHT.get(item.object_type, -1)
        colour = COLOURS.index(item.color) if item.color in COLOURS else -1
        material = MATERIALS.index(item.material) if item.material in MATERIALS else -1
        if kind >= 0 or item.object_type not in ("Cabinet", "Drawer", "Shelf"):
            rows.append((box.tolist(), kind, colour, material, hidden, item.copy))
    columns_of: list[Any] = list(zip(*rows, strict=True)) if rows else [()] * 6
    return Labels(
        box=np.asarray(columns_of[0], np.float32).reshape(-1, 4),
        kind=np.asarray(columns_of[1], np.int16),
        colour=np.asarray(columns_of[2], np.int8),
        material=np.asarray(columns_of[3], np.int8),
        ignore=np.asarray(columns_of[4], np.bool_),
        copy=np.asarray(columns_of[5], np.bool_),
    )


def _hidden(
    box: NDArray[np.float64],
    pixels: int,
    corners: NDArray[np.float32],
    pose: Pose,
    camera: Camera,
) -> bool:
    """Tell whether too little of a thing is seen to ask anyone for it."""
    size = box[2:] - box[:2]
    scale = camera.size_px / 300
    if pixels < LEAST_PX * scale**2 or size.min() < LEAST_SIDE_PX * scale:
        return True
    if pixels < LEAST_FILLED * size.prod():
        return True
    grid = np.stack(np.meshgrid(*corners.T, indexing="ij"), axis=-1).reshape(-1, 3)
    at = (grid - np.asarray(pose.position_m)) @ pose.matrix()
    ahead = np.maximum(at[:, 2:], 0.05)
    k = camera.intrinsics
    pixel = at[:, :2] / ahead * k.fx + [k.cx, k.cy]
    low, high = pixel.min(axis=0), pixel.max(axis=0)
    whole = float(np.maximum(high - low, 1).prod())
    inside = np.clip(high, 0, camera.size_px) - np.clip(low, 0, camera.size_px)
    shown = float(np.maximum(inside, 1).prod())
    return bool(size.prod() < LEAST_SHOWN * shown or shown < LEAST_INSIDE * whole)
