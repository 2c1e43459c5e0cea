"""Robust geometry of things from several measurements each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from doro_mapper.views import Bools, Floats

Ints = NDArray[np.int64]

QUANTILE = 0.2
SHARES = np.array([0.5] * 3 + [QUANTILE] * 3 + [1 - QUANTILE] * 3)
MEDIANS = np.array([0.5] * 6)
FEW = 3
NOISE_M = 0.01
"""Standard deviation of a measurement that no number of views averages away."""


@dataclass(frozen=True, slots=True)
class Geometry:
    """Of n things: centre, association box, extent, covariance of the centre."""

    center: Floats
    low: Floats
    high: Floats
    outer_low: Floats
    outer_high: Floats
    spread_m2: Floats


def _quantiles(ordered: Floats, count: Ints, share: Floats) -> Floats:
    """Return quantiles (n, k) with linear interpolation of sorted (n, k, m), inf-padded.

    Args:
        count: (n,) values that are there.
        share: (k,) of each column.
    """
    last = (count - 1)[:, None]
    place = share * last
    below = place.astype(np.int64)
    row, column = np.arange(len(ordered))[:, None], np.arange(len(share))
    first = ordered[row, column, below]
    second = ordered[row, column, np.minimum(below + 1, last)]
    return np.asarray(first + (place - below) * (second - first))


def robust_geometry(place: Floats, weight: Floats, border: Bools, valid: Bools) -> Geometry:
    """Return the geometry of n things from up to m measurements each.

    Measurements far from the median count less; the box runs from the 20 % quantile of the low
    corners to the 80 % quantile of the high ones (study, point 4). The extent is the median over
    views: a view's own bounds hold some background or miss a side. Views cut off by the
    image's border are left out where there are others.

    Args:
        place: (n, m, 15) centre, low, high, outer low, outer high.
        weight: (n, m).
        border: (n, m) the view cuts the thing off.
        valid: (n, m) the first so many measurements are there.
    """
    count = valid.sum(axis=1)
    few = (count < FEW)[:, None]
    own = place.transpose(0, 2, 1).copy()
    ordered = np.where(valid[:, None], own[:, :9], np.inf)
    ordered.sort(axis=2)
    middle, lower, upper = np.split(_quantiles(ordered, count, SHARES), 3, axis=1)
    off = own[:, :3] - middle[:, :, None]
    away = np.sqrt(off[:, 0] ** 2 + off[:, 1] ** 2 + off[:, 2] ** 2)
    scale = _quantiles(np.sort(np.where(valid, away, np.inf))[:, None], count, SHARES[:1]) + 0.02
    robust = weight * np.exp(-0.5 * np.minimum(away / (2 * scale), 6) ** 2) + 1e-9
    weight = np.where(valid, np.where(few, weight, robust), 0.0)
    weight = weight / weight.sum(axis=1, keepdims=True)
    own *= valid[:, None]
    mean = (own[:, :9] @ weight[:, :, None])[:, :, 0]
    low = np.where(few, mean[:, 3:6], lower)
    high = np.where(few, mean[:, 6:9], upper)
    center = np.where(few, mean[:, :3], 0.5 * mean[:, :3] + 0.25 * (low + high))
    whole = valid & ~border
    whole |= valid & ~whole.any(axis=1, keepdims=True)
    shown = np.where(whole[:, None], own[:, 9:], np.inf)
    shown.sort(axis=2)
    outer = _quantiles(shown, whole.sum(axis=1), MEDIANS)
    off = (own[:, :3] - mean[:, :3, None]) * valid[:, None]
    spread = (off * weight[:, None]) @ off.transpose(0, 2, 1)
    effective = 1 / np.maximum((weight**2).sum(axis=1), 1e-12)
    spread = spread / np.maximum(effective - 1, 1.0)[:, None, None] + NOISE_M**2 * np.eye(3)
    spread[few[:, 0]] += np.eye(3) * 0.05**2
    return Geometry(center, low, high, outer[:, :3], outer[:, 3:], spread)
