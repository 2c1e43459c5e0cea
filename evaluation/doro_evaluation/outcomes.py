"""What a method found in a recording, beside what is true: all that the metrics look at."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence

import msgspec

from doro_evaluation.chain import Room
from doro_perception.backend import big_enough, clip_box
from doro_perception.settings import PerceptionSettings
from doro_schemas.messages import Instance, SimDetection, SimDetections
from doro_schemas.vocabulary import canonical_name, split_camel_case
from doro_sim_feeder.rooms.classes import CLASSES

CLASS_OF_NAME = {canonical_name(split_camel_case(c.object_type)): c.object_type for c in CLASSES}
"""The 21 evaluated classes by the name that the map gives them."""


class Thing(msgspec.Struct, frozen=True):
    """A true or a found instance of an evaluated class.

    Attributes:
        object_type: AI2-THOR's name of the class.
        center_m, size_m: axis-aligned box, world x, y (up), z, metres.
        views: frames that show it: of a true one, those in which a perfect detector reports it.
    """

    object_type: str
    center_m: tuple[float, float, float]
    size_m: tuple[float, float, float]
    views: int
    name: str = ""


class Outcome(msgspec.Struct, frozen=True):
    """One recording under one error model, counted by one method.

    Attributes:
        recording, room, part: which recording.
        system: the method: ``ours``, ``grid``, ``paper_literal``, ``conceptgraphs_like``.
        errors: name of the error model (:data:`doro_evaluation.chain.ERROR_MODELS`).
        frames: views merged.
    """

    recording: str
    room: str
    part: str
    system: str
    errors: str
    frames: int
    truth: tuple[Thing, ...]
    found: tuple[Thing, ...]


def reported_views(room: Room, settings: PerceptionSettings | None = None) -> Counter[str]:
    """Return by object id the frames in which perception reports it under no error.

    These are the frames that show 30 pixels of it or more, less those in which its box is
    smaller than perception takes.
    """
    return reported_in(room, range(len(room.detections)), settings)


def reported_in(
    room: Room, views: Iterable[int], settings: PerceptionSettings | None = None
) -> Counter[str]:
    """Return the same for some of the views."""
    seen: Counter[str] = Counter()
    for view in views:
        seen.update(item.object_id for item in reported_boxes(room.detections[view], settings))
    return seen


def reported_boxes(
    frame: SimDetections, settings: PerceptionSettings | None = None
) -> list[SimDetection]:
    """Return the detections of a frame that are large enough for perception."""
    least = settings or PerceptionSettings()
    return [
        item
        for item in frame.detections
        if big_enough(
            clip_box(item.box_px, frame.height_px, frame.width_px),
            least.min_side_px,
            least.min_area_px,
        )
    ]


def true_things(room: Room, settings: PerceptionSettings | None = None) -> tuple[Thing, ...]:
    """Return the true instances of the evaluated classes that some view reports."""
    seen = reported_views(room, settings)
    return tuple(
        Thing(
            object_type=item.object_type,
            center_m=_three(item.center_m),
            size_m=_three(item.size_m),
            views=seen[item.object_id],
            name=item.object_id,
        )
        for item in room.truth
        if item.object_type in CLASS_OF_NAME.values() and seen[item.object_id]
    )


def found_things(instances: Sequence[Instance]) -> tuple[Thing, ...]:
    """Return the mapper's instances of the evaluated classes."""
    return tuple(
        Thing(
            object_type=CLASS_OF_NAME[item.graph.name],
            center_m=_three(item.position_m),
            size_m=_three(item.extent_m),
            views=item.hits,
            name=item.instance_id,
        )
        for item in instances
        if item.graph.name in CLASS_OF_NAME
    )


def _three(values: Sequence[float]) -> tuple[float, float, float]:
    x, y, z = values
    return (float(x), float(y), float(z))
