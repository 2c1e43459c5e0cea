"""Hashes of keys, whose sum times the values stands for a set, whatever the order."""

from __future__ import annotations

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


def key_hashes(keys: NDArray[np.int64]) -> NDArray[np.uint64]:
    """Return two 64-bit hashes (2, n) of integers.

    The digest of a set of (key, value) is the sum of hash times value, modulo 2^64, twice: it
    is independent of the order, and a change of a value costs one product.
    """
    first = _mixed(keys.view(np.uint64) + np.uint64(SEEDS[0]))
    return np.stack([first, _mixed(first + np.uint64(SEEDS[1]))])
