"""Which views ought to have seen a thing (MAPPER study, point 7)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from doro_mapper.views import Bools, Floats, Views

EXPECT_SHARE = 0.45
EXPECT_FILL = 0.5
EXPECT_AREA_SHARE = 1 / 600

Ints = NDArray[np.int64]


def should_see(
    views: Views, center_m: Floats, size_m: float, area_m2: float, probe_m: NDArray[np.float32]
) -> Ints:
    """Return the slots of the views that ought to have seen a thing.

    At least 45 % of its points in the image and not occluded, and large enough.
    """
    slots = views.near(center_m, size_m)
    if not len(slots):
        return slots
    visible, depth = views.visible(probe_m, slots, max(0.06, 0.35 * size_m))
    middle = np.sort(depth, axis=1)[:, depth.shape[1] // 2]
    per_m2, image = views.image_px(slots)
    share = visible.mean(axis=1)
    enough = large_enough(area_m2, share, middle, per_m2 / image)
    return np.asarray(slots[(share >= EXPECT_SHARE) & enough])


def large_enough(area_m2: Any, share: Floats, depth_m: Floats, per_m2: Any) -> Bools:
    """Tell whether the part in view takes enough of the image for a detector."""
    range_m = np.maximum(depth_m, 0.1)
    shown = area_m2 * per_m2 / range_m**2 * EXPECT_FILL * share
    return np.asarray(shown >= EXPECT_AREA_SHARE)
