"""The paper's evaluation set (Section V): which rooms, which copies, which seeds.

5 bedrooms for validation, 17 kitchens and 17 living rooms as they are, and 68 configurations
with copies of one class so that the room has 2 to 5 of it: two for each of the 34 rooms.
"""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Callable

import msgspec
import numpy as np

from doro_schemas.errors import Refused
from doro_sim_feeder.rooms.classes import BEDROOM, CLASSES, KITCHEN, LIVING, EvaluatedClass
from doro_sim_feeder.rooms.copies import CopySpec
from doro_sim_feeder.rooms.layout import load_layout, room_names
from doro_sim_feeder.rooms.placement import Spawned
from doro_sim_feeder.rooms.scene import Scene
from doro_sim_feeder.rooms.version import generator_version

VALIDATION_ROOMS = 5
ROOMS_OF_A_KIND = 17
CONFIGURATIONS = 2
TOTALS = (2, 3, 4, 5)
DEFAULT_SEED = 7


class SetRow(msgspec.Struct, frozen=True):
    """One recording of the set.

    Attributes:
        name: file and episode, ``copies-FloorPlan5-Cup``.
        part: ``validation``, ``default`` or ``copies``.
        total: instances of the class that the room is to have, its own included; 0 where no
            copies are spawned.
        copies: of which so many are spawned.
    """

    name: str
    part: str
    room: str
    room_kind: str
    seed: int
    object_type: str = ""
    total: int = 0
    copies: int = 0

    def spec(self) -> CopySpec | None:
        if not self.copies:
            return None
        return CopySpec(self.object_type, self.copies, arrange="mixed")

    def arrangement(self) -> Callable[[Scene], Spawned] | None:
        """Return what else changes the room before it is rendered (:mod:`more_sets`)."""
        return None

    def digest(self, size_px: int, views: int | None) -> str:
        """Return the digest of all that the recording depends on."""
        depends = {"row": self, "size_px": size_px, "views": views, "by": generator_version()}
        return hashlib.sha256(msgspec.json.encode(depends)).hexdigest()


def plan_set(seed: int = DEFAULT_SEED) -> list[SetRow]:
    """Return the 107 recordings of the set for a seed."""
    rng = np.random.default_rng([seed, 107])
    chosen = {
        kind: sorted(
            (str(name) for name in rng.permutation(room_names(kind))[:count]),
            key=lambda name: int(name.removeprefix("FloorPlan")),
        )
        for kind, count in (
            (BEDROOM, VALIDATION_ROOMS),
            (KITCHEN, ROOMS_OF_A_KIND),
            (LIVING, ROOMS_OF_A_KIND),
        )
    }
    rows = [_plain("validation", name, BEDROOM, seed) for name in chosen[BEDROOM]]
    for kind in (KITCHEN, LIVING):
        rows += [_plain("default", name, kind, seed) for name in chosen[kind]]
    return rows + _with_copies(chosen, rng, seed)


def select(rows: list[SetRow], only: tuple[str, ...]) -> list[SetRow]:
    """Return the rows of a name or of a room; all where nothing is named.

    Raises:
        Refused: a name is neither.
    """
    for name in only:
        if not any(name in (row.name, row.room, row.part) for row in rows):
            raise Refused(
                f"the set has nothing named '{name}': use a recording's name"
                f" ({rows[0].name}), a room of the set ({rows[0].room}) or a part of it"
                " (validation, default, copies)"
            )
    return [row for row in rows if not only or {row.name, row.room, row.part} & {*only}]


def _plain(part: str, room: str, kind: str, seed: int) -> SetRow:
    return SetRow(f"{part}-{room}", part, room, kind, seed)


def _with_copies(chosen: dict[str, list[str]], rng: np.random.Generator, seed: int) -> list[SetRow]:
    """Return the rooms with copies; classes and totals are spread as evenly as rooms allow."""
    used: Counter[str] = Counter()
    totals: Counter[int] = Counter()
    rows: list[SetRow] = []
    for number in range(CONFIGURATIONS):
        for kind in (KITCHEN, LIVING):
            for room in chosen[kind]:
                taken = {row.object_type for row in rows if row.room == room}
                item, total, own = _choose(room, kind, (used, totals), taken, rng)
                used[item.object_type] += 1
                totals[total] += 1
                rows.append(
                    SetRow(
                        name=f"copies-{room}-{item.object_type}",
                        part="copies",
                        room=room,
                        room_kind=kind,
                        seed=seed + 1 + number,
                        object_type=item.object_type,
                        total=total,
                        copies=total - own,
                    )
                )
    return rows


def _choose(
    room: str,
    kind: str,
    counts: tuple[Counter[str], Counter[int]],
    taken: set[str],
    rng: np.random.Generator,
) -> tuple[EvaluatedClass, int, int]:
    """Return class, total and the room's own number: the least used first, ties by the seed."""
    used, totals = counts
    own = Counter(item.object_type for item in load_layout(room).objects)
    options = [
        (used[item.object_type], totals[total], float(rng.random()), item, total)
        for item in CLASSES
        for total in TOTALS
        if kind in item.kinds
        and item.object_type not in taken
        and own[item.object_type] < total <= item.most
    ]
    _, _, _, best, total = min(options, key=lambda option: option[:3])
    return best, total, own[best.object_type]
