"""Hashes of keys, whose sum times the values stands for a set, whatever the order."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

SEED = np.uint64(0x9E3779B97F4A7C15)
MIX = np.array([0xBF58476D1CE4E5B9, 0x94D049BB133111EB, 0xD6E8FEB86659FD93], np.uint64)
SHIFT = np.array([30, 27, 32], np.uint64)


def key_hashes(keys: NDArray[np.int64]) -> NDArray[np.uint64]:
    """Return two 64-bit hashes (2, n) of integers.

    The digest of a set of (key, value) is the sum of hash times value, modulo 2^64, twice: it
    is independent of the order, and a change of a value costs one product.
    """
    x = keys.view(np.uint64) + SEED
    lanes = np.empty((2, len(keys)), np.uint64)
    x = (x ^ (x >> SHIFT[0])) * MIX[0]
    np.multiply(x ^ (x >> SHIFT[1]), MIX[1], out=lanes[0])
    np.multiply(lanes[0] ^ (lanes[0] >> SHIFT[2]), MIX[2], out=lanes[1])
    return lanes
