"""What an evaluation set holds: observations, instances per class and count, what is seen."""

from __future__ import annotations

import json
import math
from collections import Counter
from pathlib import Path
from typing import Any

import msgspec

from doro_schemas.errors import Refused
from doro_sim_feeder.rooms.classes import CLASSES
from doro_sim_feeder.rooms.make_set import MANIFEST, RoomTruth, read_truth

PAPER_OBSERVATIONS = (167.0, 108.3)
"""Mean and standard deviation per room (paper, Section V-A)."""
PARTS = ("validation", "default", "copies", "extra", "chairs", "stacks")


class Observations(msgspec.Struct, frozen=True):
    """Observations per recording of a part of the set."""

    part: str
    recordings: int
    mean: float
    sigma: float
    least: int
    most: int


class ClassCount(msgspec.Struct, frozen=True):
    """A class in the whole set.

    Attributes:
        recordings: in which it has a visible instance.
        visible, hidden: instances seen in at least one view, and never.
        by_count: recordings by the number of visible instances, ``{"1": 12, ...}``.
    """

    object_type: str
    recordings: int
    visible: int
    hidden: int
    by_count: dict[str, int]


class SetStatistics(msgspec.Struct, frozen=True):
    """The statistics of a set."""

    observations: list[Observations]
    classes: list[ClassCount]
    missing: list[str]
    size_bytes: int
    paper_observations: tuple[float, float] = PAPER_OBSERVATIONS


def read_set(folder: Path) -> list[tuple[dict[str, Any], RoomTruth]]:
    """Return manifest row and truth of each recording.

    Raises:
        Refused: the folder has no manifest, or a truth file is missing.
    """
    try:
        manifest = json.loads((folder / MANIFEST).read_text())
    except (OSError, ValueError) as error:
        raise Refused(
            f"{folder} has no readable {MANIFEST}: make the set with 'doro rooms set --out ...'"
        ) from error
    found = []
    for row in manifest["recordings"]:
        truth = read_truth(folder / f"{row['name']}.truth.json")
        if truth is None:
            raise Refused(f"{folder / row['name']}.truth.json is missing: make the set again")
        found.append((row, truth))
    return found


def statistics(folder: Path) -> SetStatistics:
    """Return the statistics of a set; raises Refused where there is none."""
    rows = read_set(folder)
    parts = [*PARTS, "default + copies", "all"]
    return SetStatistics(
        observations=[one for part in parts if (one := _observations(part, rows)) is not None],
        classes=[_class_count(item.object_type, rows) for item in CLASSES],
        missing=[
            f"{row['name']}: {one['object_type']} {one['name']}: {one['reason']}"
            for row, _ in rows
            for one in row["missing"]
        ],
        size_bytes=sum(truth.size_bytes for _, truth in rows),
    )


def _observations(part: str, rows: list[tuple[dict[str, Any], RoomTruth]]) -> Observations | None:
    views = [
        truth.views for row, truth in rows if part == "all" or row["part"] in part.split(" + ")
    ]
    if not views:
        return None
    mean = sum(views) / len(views)
    sigma = math.sqrt(sum((count - mean) ** 2 for count in views) / len(views))
    return Observations(part, len(views), round(mean, 1), round(sigma, 1), min(views), max(views))


def _class_count(kind: str, rows: list[tuple[dict[str, Any], RoomTruth]]) -> ClassCount:
    by_count: Counter[int] = Counter()
    visible = hidden = 0
    for _, truth in rows:
        of_class = [item for item in truth.instances if item.object_type == kind]
        seen = sum(item.views > 0 for item in of_class)
        visible += seen
        hidden += len(of_class) - seen
        by_count[seen] += bool(of_class) and seen > 0
    counts = {str(count): number for count, number in sorted(by_count.items()) if number}
    return ClassCount(kind, sum(counts.values()), visible, hidden, counts)
