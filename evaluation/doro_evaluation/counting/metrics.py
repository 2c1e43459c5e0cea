"""Counting metrics (paper, Section V, Table II): pure functions over outcomes.

An *item* is a (recording, class) pair of which something is true or found. With the count as a
class, for each true count k:

    F1_k = 2 TP_k / (2 TP_k + FP_k + FN_k)

TP_k: items with true = found = k; FP_k: items with found = k and true != k (items whose class
is not in the room at all among them); FN_k: items with true = k and found != k. The weighted
average weighs F1_k by the number of items with true count k, k >= 1.

An instance is true if a perfect detector reports it in at least ``min_views`` views (default
1: all that can be known). One that fewer views report is neither right nor wrong: it is left
out, and so is a found one that lies within half a metre of it and of no other true one.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import msgspec
import numpy as np
from numpy.typing import NDArray

from doro_evaluation.outcomes import Outcome, Thing
from doro_mapper.assignment import assign
from doro_sim_feeder.rooms.classes import BY_TYPE

COUNTS = (1, 2, 3, 4, 5)
MOST = 12
"""Counts above are taken as this one; no room has so many."""
RADII_M = (0.5, 0.25)
PAIRED_M = 1.0
"""Centre errors are of pairs within this distance."""
RESAMPLES = 1000
Floats = NDArray[np.float64]


class Item(msgspec.Struct, frozen=True):
    """How many of a class are true and found in a recording."""

    recording: str
    room: str
    object_type: str
    true: int
    found: int


@dataclass(frozen=True)
class Pair:
    """A true instance and the found one that is taken for it."""

    object_type: str
    distance_m: float

    @property
    def furniture(self) -> bool:
        return BY_TYPE[self.object_type].size == "large"


def relevant(outcome: Outcome, min_views: int = 1) -> tuple[list[Thing], list[Thing]]:
    """Return (true, found) without what fewer than ``min_views`` views report."""
    true = [thing for thing in outcome.truth if thing.views >= min_views]
    rare = [thing for thing in outcome.truth if thing.views < min_views]
    if not rare:
        return true, list(outcome.found)
    taken = {found for _, found, _ in pair_up(true, outcome.found, RADII_M[0])}
    left = [thing for k, thing in enumerate(outcome.found) if k not in taken]
    excused = {found for _, found, _ in pair_up(rare, left, RADII_M[0])}
    kept = [thing for k, thing in enumerate(outcome.found) if k in taken]
    return true, kept + [thing for k, thing in enumerate(left) if k not in excused]


def items(outcome: Outcome, min_views: int = 1) -> list[Item]:
    """Return the items of an outcome, by class."""
    true, found = relevant(outcome, min_views)
    of_true = Counter(thing.object_type for thing in true)
    of_found = Counter(thing.object_type for thing in found)
    return [
        Item(outcome.recording, outcome.room, kind, of_true[kind], of_found[kind])
        for kind in sorted(of_true.keys() | of_found.keys())
    ]


def pairs(outcome: Outcome, radius_m: float = PAIRED_M, min_views: int = 1) -> list[Pair]:
    """Return the one-to-one pairs within a radius, per class, of least total distance."""
    true, found = relevant(outcome, min_views)
    return [
        Pair(true[index].object_type, distance)
        for index, _, distance in pair_up(true, found, radius_m)
    ]


def tally(outcome: Outcome, min_views: int = 1) -> Floats:
    """Return all counts that the metrics are ratios of; tallies of recordings add up.

    Layout: TP_k, number found = k, number true = k (each ``MOST`` long), then items with true
    > 0, those of them right, all items, sum of |true - found|, true and found instances, and
    matched ones per radius.
    """
    counts = np.zeros((3, MOST))
    known = right = error = 0
    found_items = items(outcome, min_views)
    for item in found_items:
        true, found = min(item.true, MOST), min(item.found, MOST)
        counts[0, true - 1] += true == found > 0
        counts[1, found - 1] += found > 0
        counts[2, true - 1] += true > 0
        known += item.true > 0
        right += item.true == item.found
        error += abs(item.true - item.found)
    true_all, found_all = relevant(outcome, min_views)
    matched = [len(pair_up(true_all, found_all, radius)) for radius in RADII_M]
    rest = [known, right, len(found_items), error, len(true_all), len(found_all), *matched]
    return np.concatenate([counts.ravel(), np.asarray(rest, np.float64)])


def summary(total: Floats) -> dict[str, float]:
    """Return the metrics of a sum of tallies; an undefined one is nan."""
    tp, found, true = total[: 3 * MOST].reshape(3, MOST)
    known, right, everything, error, true_all, found_all, *matched = total[3 * MOST :]
    scores = 2 * tp / np.maximum(found + true, 1e-12)
    figures: dict[str, float] = {}
    for k in COUNTS:
        nothing = found[k - 1] + true[k - 1] == 0
        figures[f"{k}/f1"] = float("nan") if nothing else float(scores[k - 1])
        figures[f"{k}/items"] = float(true[k - 1])
    figures["average/f1"] = _ratio(float((scores * true).sum()), float(true.sum()))
    figures["average/items"] = float(true.sum())
    figures["accuracy"] = _ratio(right, known)
    figures["mae"] = _ratio(error, everything)
    for radius, hits in zip(RADII_M, matched, strict=True):
        figures[f"matched_f1_{radius:g}m"] = _ratio(2 * hits, true_all + found_all)
    return figures


def room_tallies(outcomes: Sequence[Outcome], min_views: int = 1) -> dict[str, Floats]:
    """Return the sum of tallies by room: recordings of one room are not independent."""
    rooms: dict[str, Floats] = {}
    for outcome in outcomes:
        own = tally(outcome, min_views)
        rooms[outcome.room] = rooms.get(outcome.room, np.zeros_like(own)) + own
    return dict(sorted(rooms.items()))


def measure(outcomes: Sequence[Outcome], min_views: int = 1) -> dict[str, float]:
    """Return the metrics over outcomes, centre errors of pairs within 1 m included."""
    rooms = room_tallies(outcomes, min_views)
    figures = summary(np.sum(list(rooms.values()), axis=0))
    found = [pair for outcome in outcomes for pair in pairs(outcome, min_views=min_views)]
    for name, chosen in (
        ("furniture", [pair.distance_m for pair in found if pair.furniture]),
        ("others", [pair.distance_m for pair in found if not pair.furniture]),
    ):
        for percent, label in ((50, "median"), (90, "p90")):
            value = float(np.percentile(chosen, percent)) if chosen else float("nan")
            figures[f"center_error_{name}_{label}_m"] = value
    return figures


def intervals(
    outcomes: Sequence[Outcome], min_views: int = 1, seed: int = 0
) -> dict[str, tuple[float, float]]:
    """Return 95 % bootstrap intervals of :func:`summary`: rooms drawn with replacement."""
    rooms = np.array(list(room_tallies(outcomes, min_views).values()))
    rng = np.random.default_rng([seed, len(rooms)])
    weights = rng.multinomial(len(rooms), np.full(len(rooms), 1 / len(rooms)), RESAMPLES)
    drawn = [summary(weight @ rooms) for weight in weights.astype(np.float64)]
    found: dict[str, tuple[float, float]] = {}
    for name in drawn[0]:
        values = np.array([one[name] for one in drawn])
        values = values[np.isfinite(values)]
        if len(values) and not name.endswith("items"):
            low, high = np.percentile(values, (2.5, 97.5))
            found[name] = (float(low), float(high))
    return found


def _ratio(above: float, below: float) -> float:
    """Return above / below, nan where nothing is below."""
    return above / below if below else float("nan")


def pair_up(
    true: Sequence[Thing], found: Sequence[Thing], radius_m: float
) -> list[tuple[int, int, float]]:
    """Return (index of true, index of found, distance) of pairs of a class within a radius."""
    matched: list[tuple[int, int, float]] = []
    for kind in sorted({thing.object_type for thing in true}):
        rows = [k for k, thing in enumerate(true) if thing.object_type == kind]
        columns = [k for k, thing in enumerate(found) if thing.object_type == kind]
        if not columns:
            continue
        a = np.array([true[k].center_m for k in rows])
        b = np.array([found[k].center_m for k in columns])
        distance = np.linalg.norm(a[:, None] - b[None], axis=2)
        # Pairs beyond the radius cost more than all pairs within: as many as possible match.
        cost = np.where(distance <= radius_m, distance, 1e3)
        for row, column in assign(cost):
            if distance[row, column] <= radius_m:
                matched.append((rows[row], columns[column], float(distance[row, column])))
    return matched
