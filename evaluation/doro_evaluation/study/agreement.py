"""Krippendorff's alpha: how far raters agree beyond chance, with gaps allowed.

Own code: the kept library for it is under the GPL, which this project cannot depend on.
Source: K. Krippendorff, Computing Krippendorff's Alpha-Reliability, 2011.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Level = Literal["ordinal", "interval"]
Floats = NDArray[np.float64]


def krippendorff_alpha(units: Sequence[Sequence[int]], level: Level = "ordinal") -> float | None:
    """Return alpha: 1 full agreement, 0 chance, below 0 systematic disagreement.

    Args:
        units: for each thing rated, its ratings, one per rater who rated it; things with
            fewer than two ratings say nothing.
        level: ``ordinal`` weighs by ranks between two values, ``interval`` by their distance.

    Returns:
        None where nothing can be compared: no unit has two ratings, or all ratings are equal.
    """
    pairable = [list(unit) for unit in units if len(unit) >= 2]
    values = sorted({rating for unit in pairable for rating in unit})
    if len(values) < 2:
        return None
    observed = _coincidences(pairable, values)
    totals = observed.sum(axis=1)
    expected = np.outer(totals, totals) - np.diag(totals)
    weights = _differences(np.array(values, np.float64), totals, level)
    disagreement = float((observed * weights).sum())
    by_chance = float((expected * weights).sum()) / (float(totals.sum()) - 1)
    return 1 - disagreement / by_chance


def _coincidences(units: Sequence[Sequence[int]], values: list[int]) -> Floats:
    """Return how often two values meet in a unit, each unit weighed by its ratings - 1."""
    matrix = np.zeros((len(values), len(values)))
    for unit in units:
        counts = np.array([unit.count(value) for value in values], np.float64)
        matrix += (np.outer(counts, counts) - np.diag(counts)) / (len(unit) - 1)
    return matrix


def _differences(values: Floats, totals: Floats, level: Level) -> Floats:
    """Return the squared difference of every two values."""
    if level == "interval":
        return np.asarray((values[:, None] - values[None, :]) ** 2)
    # Ordinal: the ratings between the two ranks, the two themselves counted half.
    middle = np.cumsum(totals) - totals / 2
    return np.asarray((middle[:, None] - middle[None, :]) ** 2)
