"""Why an item was counted wrongly, as far as places and views tell.

True and found instances of a class are paired one to one within half a metre; what is left over
on either side has a cause by the first rule that fits. These are rules of thumb for people who
look for what to mend; no figure of the paper depends on them.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np

from doro_evaluation.bootstrap import share, tallied
from doro_evaluation.counting.metrics import COUNTS, RADII_M, items, pair_up
from doro_evaluation.figures import Figure
from doro_evaluation.outcomes import Outcome, Thing

FEW = 2
BESIDE_M = 1.0
SAME_PLACE_M = 0.3

RARE = "seen in one or two views only"
MERGED = "taken for the one beside it"
RENAMED = "found under another name"
LOST = "not found, though three views or more show it"
TWICE = "one thing counted twice"
OTHER = "another thing under its name"
NOTHING = "nothing of the class is there"
BINS = (1, 2, 3, 6, 11, 21, 51)
"""Where the classes of "number of views that show it" begin."""
REASONS = (RARE, MERGED, RENAMED, LOST, TWICE, OTHER, NOTHING)


def reasons_of(outcome: Outcome, object_type: str) -> list[str]:
    """Return a cause for each true instance left over, then for each found one."""
    true = [one for one in outcome.truth if one.object_type == object_type]
    found = [one for one in outcome.found if one.object_type == object_type]
    pairs = pair_up(true, found, RADII_M[0])
    taken_true, taken_found = {pair[0] for pair in pairs}, {pair[1] for pair in pairs}
    paired = [true[k] for k in sorted(taken_true)]
    causes = [_missed(one, paired, outcome) for k, one in enumerate(true) if k not in taken_true]
    causes += [_added(one, paired, outcome) for k, one in enumerate(found) if k not in taken_found]
    return causes


def causes(outcomes: Sequence[Outcome]) -> Counter[str]:
    """Return how often each cause stands behind a wrong item, in the order of the rules."""
    counts: Counter[str] = Counter()
    for outcome in outcomes:
        for item in items(outcome):
            if item.true != item.found:
                counts.update(reasons_of(outcome, item.object_type))
    return Counter({name: counts[name] for name in REASONS if counts[name]})


def figures_of(runs: Mapping[tuple[str, str], Sequence[Outcome]]) -> dict[str, Figure]:
    """Return ``causes/<system>/<errors>/<cause>`` and ``seen/<system>/<errors>/<views>/found``.

    The latter is the share of true instances, shown by so many views, with a found one of their
    class within half a metre; 95 % intervals over rooms.
    """
    figures: dict[str, Figure] = {}
    for (system, errors), outcomes in runs.items():
        wrong = [item for one in outcomes for item in items(one) if item.true != item.found]
        figures[f"causes/{system}/{errors}/wrong_items"] = len(wrong)
        for cause, count in causes(outcomes).items():
            figures[f"causes/{system}/{errors}/{_key(cause)}"] = count
        for k in COUNTS:
            behind = Counter(
                cause
                for one in outcomes
                for item in items(one)
                if item.true == k != item.found
                for cause in reasons_of(one, item.object_type)
            )
            for cause, count in sorted(behind.items()):
                figures[f"causes/{system}/{errors}/of_{k}/{_key(cause)}"] = count
        figures |= _seen(f"seen/{system}/{errors}", outcomes)
    return figures


def _key(cause: str) -> str:
    return cause.replace(",", "").replace(" ", "_")


def _seen(name: str, outcomes: Sequence[Outcome]) -> dict[str, Figure]:
    rooms = {room: k for k, room in enumerate(sorted({one.room for one in outcomes}))}
    counts = np.zeros((len(BINS), len(rooms), 2))
    for outcome in outcomes:
        found = {pair[0] for pair in pair_up(outcome.truth, outcome.found, RADII_M[0])}
        for k, thing in enumerate(outcome.truth):
            row = int(np.searchsorted(BINS, thing.views, side="right")) - 1
            counts[row, rooms[outcome.room]] += (k in found, 1)
    figures: dict[str, Figure] = {}
    for least, tallies in zip(BINS, counts, strict=True):
        if not tallies.any():
            continue
        score = tallied(tallies, share)
        start = f"{name}/{least}"
        figures[f"{start}/things"] = int(tallies[:, 1].sum())
        figures[f"{start}/found"] = round(score.value, 4)
        figures[f"{start}/found_low"] = round(score.low, 4)
        figures[f"{start}/found_high"] = round(score.high, 4)
    return figures


def _missed(thing: Thing, paired: Sequence[Thing], outcome: Outcome) -> str:
    if thing.views <= FEW:
        return RARE
    others = [one for one in outcome.found if one.object_type != thing.object_type]
    if _nearest_m(thing, others) <= SAME_PLACE_M and _nearest_m(thing, paired) > BESIDE_M:
        return RENAMED
    return MERGED if _nearest_m(thing, paired) <= BESIDE_M + _half_m(thing) else LOST


def _added(thing: Thing, paired: Sequence[Thing], outcome: Outcome) -> str:
    if _nearest_m(thing, paired) <= BESIDE_M + _half_m(thing):
        return TWICE
    others = [one for one in outcome.truth if one.object_type != thing.object_type]
    return OTHER if _nearest_m(thing, others) <= SAME_PLACE_M else NOTHING


def _nearest_m(thing: Thing, others: Sequence[Thing]) -> float:
    apart = [float(np.linalg.norm(np.subtract(thing.center_m, one.center_m))) for one in others]
    return min(apart, default=float("inf"))


def _half_m(thing: Thing) -> float:
    return max(thing.size_m) / 2
