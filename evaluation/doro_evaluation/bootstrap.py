"""Confidence intervals by resampling rooms (views and pairs of a room are not independent)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

import msgspec
import numpy as np
from numpy.typing import NDArray

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


Statistic = Callable[[NDArray[np.float64]], NDArray[np.float64]]
"""Of summed tallies (n, k): the figure of each row, (n,); not a number where undefined."""


class Score(msgspec.Struct, frozen=True):
    """A figure with its 95 % interval."""

    value: float
    low: float
    high: float


def tallied(
    tallies: NDArray[np.float64], statistic: Statistic, seed: int = 0, draws: int = DRAWS
) -> Score:
    """Return a figure of summed tallies, with its interval over resampled rooms.

    Args:
        tallies: (rooms, k), what the figure is computed of, summed by room; whole rooms are
            drawn, with replacement.
    """
    if not len(tallies):
        return Score(float("nan"), float("nan"), float("nan"))
    random = np.random.default_rng(seed)
    weights = random.multinomial(len(tallies), np.full(len(tallies), 1 / len(tallies)), draws)
    with np.errstate(divide="ignore", invalid="ignore"):
        value = float(statistic(tallies.sum(axis=0)[None])[0])
        drawn = statistic(weights.astype(np.float64) @ tallies)
    drawn = drawn[np.isfinite(drawn)]
    if not drawn.size:
        return Score(value, float("nan"), float("nan"))
    low, high = np.quantile(drawn, [(1 - LEVEL) / 2, (1 + LEVEL) / 2])
    return Score(value, float(low), float(high))


def share(sums: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return column 0 over column 1: a share, or a mean."""
    return np.asarray(sums[:, 0] / sums[:, 1])


def f1(sums: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return F1 of (hits, said, true)."""
    return np.asarray(2 * sums[:, 0] / (sums[:, 1] + sums[:, 2]))


def bounds(name: str, flags: Sequence[tuple[str, bool]]) -> dict[str, float]:
    """Return ``<name>_share`` of what is true, ``_share_low`` and ``_share_high``.

    Args:
        flags: (room, whether it is right); rooms are drawn.
    """
    rooms = sorted({room for room, _ in flags})
    tallies = np.zeros((len(rooms), 2))
    for room, right in flags:
        tallies[rooms.index(room)] += (right, 1)
    score = tallied(tallies, share)
    values = {"": score.value, "_low": score.low, "_high": score.high}
    return {f"{name}_share{end}": round(value, 4) for end, value in values.items()}
