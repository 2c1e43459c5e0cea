"""Rooms for the baseline's training: layouts that no test room has, varied, without rendering.

The layouts are iTHOR's rooms less the 34 test rooms. A varied room has other colours, now and then
another kind of landmark, and copies of one or two classes on places where its own things stand.
What a view shows is told by direction and distance from a random point.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import msgspec
import numpy as np

from doro_sim_feeder.rooms.appearance import NO_COLOR, PALETTE, USUAL_COLORS
from doro_sim_feeder.rooms.classes import BEDROOM, CLASSES, KITCHEN, LIVING
from doro_sim_feeder.rooms.copies import CopySpec, wishes
from doro_sim_feeder.rooms.evaluation_set import plan_set
from doro_sim_feeder.rooms.layout import load_layout, room_names
from doro_sim_feeder.rooms.scene import build_scene
from doro_sim_feeder.rooms.truth import TrueInstance, TrueRelation, true_instances

RECOLOR_SHARE = 0.7
ANY_COLOR_SHARE = 0.3
RENAME_SHARE = 0.15
SEEN_M = 6.0
HIDDEN_SHARE = 0.15
HALF_VIEW = np.cos(np.radians(45.0))
CAMERA_M = 1.5


@dataclass(frozen=True)
class BaseRoom:
    """A layout as it would be rendered: its name and all that is true of it."""

    name: str
    instances: tuple[TrueInstance, ...]


def training_rooms() -> list[str]:
    """Return the names of the rooms that may be trained on: all but the test rooms."""
    tested = {row.room for row in plan_set() if row.part != "validation"}
    names = [name for kind in (KITCHEN, LIVING, BEDROOM) for name in room_names(kind)]
    return [name for name in names if name not in tested]


def base_rooms(names: Sequence[str]) -> Iterator[BaseRoom]:
    """Yield the layouts of rooms with the truth that their rendering would have."""
    for name in names:
        scene = build_scene(name)
        everything = dict.fromkeys(range(1, len(scene.instances) + 1), 1)
        yield BaseRoom(name, tuple(true_instances(scene.instances, everything)))


def object_types(names: Sequence[str]) -> list[str]:
    """Return the classes of the rooms' layouts, in order of name."""
    return sorted({item.object_type for name in names for item in load_layout(name).objects})


def varied(
    base: BaseRoom, types: Sequence[str], rng: np.random.Generator
) -> tuple[list[TrueInstance], set[str]]:
    """Return a room like a base room, and the classes of which copies were added.

    Args:
        types: classes that a landmark may become.
    """
    items = list(base.instances)
    kinds: set[str] = set()
    for _ in range(1 + int(rng.random() < 0.4)):
        kind = CLASSES[int(rng.integers(len(CLASSES)))]
        if kind.object_type not in kinds:
            kinds.add(kind.object_type)
            items = _with_copies(items, kind.object_type, kind.most, rng)
    looks = _looks(items, types, rng)
    return [_dressed(item, looks) for item in items], kinds


def seen_from_somewhere(
    items: Sequence[TrueInstance], towards: TrueInstance | None, rng: np.random.Generator
) -> list[TrueInstance]:
    """Return what a view shows: before the camera and near enough, some of it hidden.

    Args:
        towards: a thing that the camera looks at; None: any yaw.
    """
    places = np.array([item.center_m for item in items])
    low, high = places.min(axis=0), places.max(axis=0)
    eye = np.array([rng.uniform(low[0], high[0]), CAMERA_M, rng.uniform(low[2], high[2])])
    yaw = rng.uniform(0, 2 * np.pi)
    ahead = np.array([np.sin(yaw), 0.0, np.cos(yaw)])
    if towards is not None:
        ahead = (np.asarray(towards.center_m) - eye) * (1.0, 0.0, 1.0) + 1e-6
        ahead /= np.linalg.norm(ahead)
    offset = (places - eye) * (1.0, 0.0, 1.0)
    distance_m = np.linalg.norm(offset, axis=1) + 1e-6
    shown = (offset @ ahead / distance_m > HALF_VIEW) & (distance_m < SEEN_M)
    shown &= rng.random(len(items)) > HIDDEN_SHARE
    return [item for item, visible in zip(items, shown, strict=True) if visible]


def _with_copies(
    items: list[TrueInstance], kind: str, most: int, rng: np.random.Generator
) -> list[TrueInstance]:
    """Return the room with some of a class taken away, then copies up to a drawn number."""
    own = [item for item in items if item.object_type == kind]
    total = int(rng.integers(1, most + 1))
    taken = {item.object_id for item in own[total:]}
    items = [item for item in items if item.object_id not in taken]
    count = total - min(len(own), total)
    donors = [item for item in items if item.relations] or items
    if not count:
        return items
    for number, wish in enumerate(wishes(CopySpec(kind, count), rng)):
        donor = donors[int(rng.integers(len(donors)))]
        pairs = (("color", wish.look.color), ("material", wish.look.material))
        copy = TrueInstance(
            number=len(items) + 1,
            object_id=f"{kind}|copy{number}",
            object_type=kind,
            attributes={name: value for name, value in pairs if value is not None},
            center_m=list(donor.center_m),
            size_m=list(donor.size_m),
            receptacle=donor.receptacle,
            relations=[one for one in donor.relations if one.object_type != kind],
            views=1,
            copy=True,
        )
        items.insert(int(rng.integers(len(items) + 1)), copy)
    return items


def _looks(
    items: Sequence[TrueInstance], types: Sequence[str], rng: np.random.Generator
) -> dict[str, tuple[str, dict[str, str]]]:
    """Return class and attributes of each thing, by its id; copies keep theirs."""
    evaluated = {item.object_type for item in CLASSES}
    recolor, found = rng.random() < RECOLOR_SHARE, {}
    for item in items:
        kind, attributes = item.object_type, dict(item.attributes)
        if kind not in evaluated and rng.random() < RENAME_SHARE:
            kind = types[int(rng.integers(len(types)))]
        if recolor and not item.copy and kind not in NO_COLOR:
            usual = USUAL_COLORS.get(kind, tuple(PALETTE))
            choices = tuple(PALETTE) if rng.random() < ANY_COLOR_SHARE else usual
            attributes = {"color": choices[int(rng.integers(len(choices)))], **attributes}
            attributes["color"] = choices[int(rng.integers(len(choices)))]
        found[item.object_id] = (kind, attributes)
    return found


def _dressed(item: TrueInstance, looks: dict[str, tuple[str, dict[str, str]]]) -> TrueInstance:
    kind, attributes = looks[item.object_id]
    relations = [
        TrueRelation(one.type, one.object_id, *looks[one.object_id])
        for one in item.relations
        if one.object_id in looks
    ]
    return msgspec.structs.replace(
        item, object_type=kind, attributes=attributes, relations=relations
    )
