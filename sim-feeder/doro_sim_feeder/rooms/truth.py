"""Ground truth: what was rendered, not what the layout said."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import msgspec
import numpy as np
from numpy.typing import NDArray

from doro_schemas.messages import SimDetection, SimRelation
from doro_schemas.spatial import Box3, footprint_share, gap_m, relation_between
from doro_sim_feeder.rooms.footprints import ON_WALLS
from doro_sim_feeder.rooms.instances import BACKGROUND, Instance

MIN_VISIBLE_PX = 30
NEAR_LANDMARKS = 2
LANDMARK_SIDE_M = 0.3
# Too many of a kind in a room, or too small, to say where something is.
NO_LANDMARK = BACKGROUND | ON_WALLS | {"Cabinet", "Drawer", "StoveBurner", "StoveKnob", "Faucet"}


class Thing(Protocol):
    """What the rule of the relations needs to know of an object, rendered or simulated."""

    @property
    def object_id(self) -> str: ...
    @property
    def object_type(self) -> str: ...
    @property
    def receptacles(self) -> tuple[str, ...]: ...
    @property
    def pickupable(self) -> bool: ...
    def attributes(self) -> dict[str, str]: ...


class TrueRelation(msgspec.Struct, frozen=True):
    """A relation of an instance to a landmark."""

    type: str
    object_id: str
    object_type: str
    attributes: dict[str, str]


class TrueInstance(msgspec.Struct, frozen=True):
    """An instance as rendered.

    Attributes:
        number: its id in the pictures of instance ids.
        center_m, size_m: axis-aligned box, world x, y, z, metres.
        views: number of frames in which it has a detection.
        copy: spawned, not of the room's own layout.
    """

    number: int
    object_id: str
    object_type: str
    attributes: dict[str, str]
    center_m: list[float]
    size_m: list[float]
    receptacle: str
    relations: list[TrueRelation]
    views: int = 0
    copy: bool = False


def true_instances(instances: tuple[Instance, ...], views: dict[int, int]) -> list[TrueInstance]:
    """Return the truth of all things but the shell; ``views`` counts frames by number."""
    boxes = [item.box() for item in instances]
    return [
        TrueInstance(
            number=k + 1,
            object_id=item.object_id,
            object_type=item.object_type,
            attributes=item.attributes(),
            center_m=_rounded(boxes[k].center_m),
            size_m=_rounded(boxes[k].size_m),
            receptacle=item.receptacles[0] if item.receptacles else "",
            relations=relations_of(k, instances, boxes),
            views=views.get(k + 1, 0),
            copy=item.copy,
        )
        for k, item in enumerate(instances)
        if item.object_type not in BACKGROUND
    ]


def _rounded(ground: tuple[float, float, float]) -> list[float]:
    """Return (ground, ground, up) as world x, y, z."""
    return [round(ground[0], 4), round(ground[2], 4), round(ground[1], 4)]


def relations_of(
    number: int, instances: Sequence[Thing], boxes: Sequence[Box3]
) -> list[TrueRelation]:
    """Return what holds a thing (on, else in), and up to two landmarks near it.

    Args:
        number: index of the thing.
        boxes: of all things, (ground, ground, up).
    """
    item, box = instances[number], boxes[number]
    holders: list[tuple[bool, float, float, int, str]] = []
    near: list[tuple[float, int, str]] = []
    for k, other in enumerate(instances):
        if k == number or other.object_type in NO_LANDMARK | {item.object_type}:
            continue
        relation = relation_between(box, boxes[k])
        area = _ground_area(boxes[k])
        if relation is None or area <= _ground_area(box):
            continue
        if relation == "is-near":
            if _furniture_sized(boxes[k]) and not other.pickupable:
                near.append((_ground_gap(box, boxes[k]), k, relation))
        elif footprint_share(box, boxes[k]) > 0 and not (isinstance(item, Instance) and item.piled):
            # A box may hold what only stands above it (a chair under the table's edge): what
            # is known to carry the thing comes first, then the nearest surface.
            known = any(name.startswith(other.object_id) for name in item.receptacles)
            gap = abs(box.low(2) - boxes[k].high(2))
            holders.append((not known, round(gap, 2), area, k, relation))
    chosen = [(k, relation) for *_, k, relation in sorted(holders)[:1]]
    chosen += _held_by(item, instances, boxes, box)
    chosen += [(k, relation) for _, k, relation in sorted(near)[:NEAR_LANDMARKS]]
    return [_relation(relation, instances[k]) for k, relation in chosen]


def _held_by(
    item: Thing, instances: Sequence[Thing], boxes: Sequence[Box3], box: Box3
) -> list[tuple[int, str]]:
    """Return what a piled thing was put on or into, which may be of its class and smaller."""
    if not (isinstance(item, Instance) and item.piled):
        return []
    below = next(k for k, one in enumerate(instances) if one.object_id == item.receptacles[0])
    return [(below, relation_between(box, boxes[below]) or "is-on")]


def _relation(relation: str, landmark: Thing) -> TrueRelation:
    return TrueRelation(relation, landmark.object_id, landmark.object_type, landmark.attributes())


def _ground_area(box: Box3) -> float:
    return box.size_m[0] * box.size_m[1]


def _ground_gap(a: Box3, b: Box3) -> float:
    return float(np.hypot(gap_m(a, b, 0), gap_m(a, b, 1)))


def _furniture_sized(box: Box3) -> bool:
    return max(box.size_m) >= LANDMARK_SIDE_M and sorted(box.size_m)[1] >= LANDMARK_SIDE_M / 2


def detections(
    ids: NDArray[np.int32], truth: dict[int, TrueInstance], min_px: int = MIN_VISIBLE_PX
) -> list[SimDetection]:
    """Return the detections of a picture of instance ids, in order of number.

    Boxes enclose the visible pixels, with exclusive upper edges.

    Args:
        truth: the truth by number; ids that are not in it (the shell) are no detections.
    """
    found = []
    counts = np.bincount(ids.ravel())
    for number in np.flatnonzero(counts >= min_px):
        item = truth.get(int(number))
        if item is None:
            continue
        rows, columns = np.nonzero(ids == number)
        box = [columns.min(), rows.min(), columns.max() + 1, rows.max() + 1]
        found.append(
            SimDetection(
                object_id=item.object_id,
                object_type=item.object_type,
                box_px=[float(value) for value in box],
                attributes=item.attributes,
                relations=[
                    SimRelation(r.type, r.object_type, r.attributes) for r in item.relations
                ],
            )
        )
    return found
