"""Hashes of rows whose sum stands for a set, whatever the order."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

SEEDS = (0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F)
MIX = (0xBF58476D1CE4E5B9, 0x94D049BB133111EB)


def _mixed(values: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """Return splitmix64's finish: every bit depends on every bit."""
    x = values
    for shift, factor in zip((30, 27), MIX, strict=True):
        x = (x ^ (x >> np.uint64(shift))) * np.uint64(factor)
    return x ^ (x >> np.uint64(31))


def row_hashes(keys: NDArray[Any], weights: NDArray[Any]) -> NDArray[np.uint64]:
    """Return two 64-bit hashes (n, 2) of rows of integers (n, k) and a float32 weight (n,)."""
    bits = weights.astype("<f4").view("<u4").astype(np.uint64)
    out = np.empty((len(keys), 2), np.uint64)
    for lane, seed in enumerate(SEEDS):
        state = _mixed(bits + np.uint64(seed))
        for column in keys.T:
            state = _mixed(state ^ (column.astype(np.int64).view(np.uint64) + np.uint64(seed)))
        out[:, lane] = state
    return out
