"""Recordings beyond the paper's 107: high counts, chairs round a table, stacks.

- ``extra``: the 34 test rooms once more, each with four classes of which there are 3 to 5, so
  that the high counts of Table II are no noise; ``copies-tune``: the other 26 kitchens and living
  rooms, each with four classes of which there are 2 to 5.
- ``chairs``: four identical chairs round a table in ten of the test rooms; ``chairs-tune``: in
  ten other rooms.
- ``stacks``: up to four piles in each of the test rooms; ``stacks-tune``: in fifteen others.

The ``-tune`` parts are what parameters may be tuned on, besides the validation bedrooms. None
of these changes a recording of the paper's set.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

import numpy as np

from doro_schemas.errors import Refused
from doro_sim_feeder.rooms.chairs import chairs_round_table
from doro_sim_feeder.rooms.classes import BEDROOM, CLASSES, KITCHEN, LIVING, EvaluatedClass
from doro_sim_feeder.rooms.copies import CopySpec, Unplaced
from doro_sim_feeder.rooms.evaluation_set import DEFAULT_SEED, SetRow, plan_set
from doro_sim_feeder.rooms.layout import load_layout, room_names
from doro_sim_feeder.rooms.placement import Spawned, place_copies
from doro_sim_feeder.rooms.scene import Scene
from doro_sim_feeder.rooms.stacks import add_stacks

PAPER = "paper"
MORE_PARTS = ("extra", "chairs", "chairs-tune", "stacks", "stacks-tune", "copies-tune")
CLASSES_A_ROOM, LARGE_A_ROOM = 4, 1
WANTED = {3: 1.0, 4: 2.0, 5: 2.0}
"""How often a total is wanted beside the others; the paper's set has few of 4 and 5."""
WANTED_TUNING = {2: 1.0, 3: 1.0, 4: 1.0, 5: 1.0}
PILES_A_ROOM = 4
TUNING_STACK_ROOMS = 15
SEEDS = {
    "extra": 100,
    "chairs": 200,
    "chairs-tune": 300,
    "stacks": 400,
    "stacks-tune": 500,
    "copies-tune": 600,
}
"""Added to the set's seed, so that no two parts share a random stream."""
CHAIR_ROOMS = {
    "chairs": (2, 8, 10, 13, 18, 203, 205, 206, 209, 228),
    "chairs-tune": (1, 7, 14, 16, 22, 202, 204, 211, 221, 223),
}
"""Rooms with floor enough for a table with four chairs that can be walked round."""


class ArrangedRow(SetRow, frozen=True):
    """A recording with more than copies of one class.

    Attributes:
        more: classes and how many copies of each (``extra``).
        first: number of the first recipe (``stacks``).
    """

    more: tuple[tuple[str, int], ...] = ()
    first: int = 0

    def arrangement(self) -> Callable[[Scene], Spawned]:
        """Return what changes the room before it is rendered."""
        return self._arranged

    def _arranged(self, scene: Scene) -> Spawned:
        if self.part.startswith("chairs"):
            return Spawned(chairs_round_table(scene, self.seed), ())
        if self.part.startswith("stacks"):
            return Spawned(add_stacks(scene, self.seed, self.first, PILES_A_ROOM), ())
        missing: tuple[Unplaced, ...] = ()
        for object_type, count in self.more:
            spawned = place_copies(scene, CopySpec(object_type, count, arrange="mixed"), self.seed)
            scene, missing = spawned.scene, missing + spawned.missing
        return Spawned(scene, missing)


def plan_part(part: str, seed: int = DEFAULT_SEED) -> list[SetRow]:
    """Return the recordings of a part; ``paper`` is the set of 107.

    Raises:
        Refused: there is no such part.
    """
    if part == PAPER:
        return plan_set(seed)
    if part not in MORE_PARTS:
        raise Refused(f"there is no part '{part}': use {', '.join((PAPER, *MORE_PARTS))}")
    chosen = rooms_of_test(seed)
    if part == "extra":
        return list(_copies(part, chosen, seed, WANTED))
    if part == "copies-tune":
        names = [name for kind in (KITCHEN, LIVING) for name in room_names(kind)]
        rooms = [name for name in names if name not in chosen]
        return list(_copies(part, rooms, seed, WANTED_TUNING))
    if part in CHAIR_ROOMS:
        return [_row(part, f"FloorPlan{number}", seed) for number in CHAIR_ROOMS[part]]
    rooms = chosen if part == "stacks" else _other_rooms(chosen, seed)[:TUNING_STACK_ROOMS]
    rows: list[SetRow] = []
    for k, room in enumerate(rooms):
        rows.append(_row(part, room, seed, first=k * PILES_A_ROOM))
    return rows


def plan_all(seed: int = DEFAULT_SEED) -> list[SetRow]:
    """Return the recordings of all parts."""
    return [row for part in (PAPER, *MORE_PARTS) for row in plan_part(part, seed)]


def rooms_of_test(seed: int) -> list[str]:
    """Return the 34 rooms that nothing is tuned on."""
    return [row.room for row in plan_set(seed) if row.part == "default"]


def _other_rooms(chosen: list[str], seed: int) -> list[str]:
    """Return kitchens, living rooms and bedrooms that are not tested on, in seeded order."""
    names = [name for kind in (KITCHEN, LIVING, BEDROOM) for name in room_names(kind)]
    rng = np.random.default_rng([seed, SEEDS["stacks-tune"]])
    shuffled = [names[int(k)] for k in rng.permutation(len(names))]
    return [name for name in shuffled if name not in chosen]


def _row(
    part: str, room: str, seed: int, *, first: int = 0, more: tuple[tuple[str, int], ...] = ()
) -> ArrangedRow:
    kind = load_layout(room).kind
    return ArrangedRow(
        f"{part}-{room}", part, room, kind, seed + SEEDS[part], first=first, more=more
    )


def _copies(part: str, rooms: list[str], seed: int, wanted: dict[int, float]) -> list[ArrangedRow]:
    """Return the rooms with four classes each; classes and totals are spread as is wanted."""
    rng = np.random.default_rng([seed, SEEDS[part]])
    used: Counter[str] = Counter()
    totals: Counter[int] = Counter()
    rows = []
    for room in rooms:
        layout = load_layout(room)
        own = Counter(item.object_type for item in layout.objects)
        picked: list[tuple[EvaluatedClass, int]] = []
        for _ in range(CLASSES_A_ROOM):
            item, total = _pick(picked, (own, layout.kind, wanted), (used, totals), rng)
            picked.append((item, total))
            used[item.object_type] += 1
            totals[total] += 1
        more = tuple((item.object_type, total - own[item.object_type]) for item, total in picked)
        rows.append(_row(part, room, seed, more=more))
    return rows


def _pick(
    picked: list[tuple[EvaluatedClass, int]],
    room: tuple[Counter[str], str, dict[int, float]],
    counts: tuple[Counter[str], Counter[int]],
    rng: np.random.Generator,
) -> tuple[EvaluatedClass, int]:
    (own, kind, wanted), (used, totals) = room, counts
    taken = {item.object_type for item, _ in picked}
    large = sum(item.size == "large" for item, _ in picked)
    options = [
        (used[item.object_type], totals[total] / share, float(rng.random()), item, total)
        for item in CLASSES
        for total, share in wanted.items()
        if kind in item.kinds
        and item.object_type not in taken
        and own[item.object_type] < total <= item.most
        and (item.size != "large" or large < LARGE_A_ROOM)
    ]
    *_, best, total = min(options, key=lambda option: option[:3])
    return best, total
