"""Confidence intervals by resampling rooms (views and pairs of a room are not independent)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

import numpy as np

DRAWS = 1000
LEVEL = 0.95

T = TypeVar("T")


def interval(
    groups: Sequence[Sequence[T]],
    statistic: Callable[[list[T]], float],
    seed: int = 0,
    draws: int = DRAWS,
) -> tuple[float, float]:
    """Return the 95 % percentile interval of a statistic over resampled groups.

    Args:
        groups: the items of each room; whole rooms are drawn, with replacement.
        statistic: of a list of items; draws in which it is not a number are left out.

    Returns:
        Lower and upper bound; (nan, nan) where nothing can be computed.
    """
    full = [list(group) for group in groups if group]
    if not full:
        return float("nan"), float("nan")
    random = np.random.default_rng(seed)
    values = []
    for _ in range(draws):
        chosen = random.integers(len(full), size=len(full))
        values.append(statistic([item for index in chosen for item in full[index]]))
    found = np.asarray(values, np.float64)
    found = found[~np.isnan(found)]
    if not found.size:
        return float("nan"), float("nan")
    low, high = np.quantile(found, [(1 - LEVEL) / 2, (1 + LEVEL) / 2])
    return float(low), float(high)
