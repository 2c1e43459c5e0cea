"""Letting a thing go above its place: where it comes to rest, if it is free there."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from doro_sim_feeder.rooms.contact import Around, Body
from doro_sim_feeder.rooms.instances import Instance
from doro_sim_feeder.rooms.parts import Part, place
from doro_sim_feeder.rooms.scene import RESTING_M

Points = NDArray[np.float64]
RAISED_M = 0.04


def at_rest(
    shape: tuple[Part, ...],
    yaw_deg: float,
    position_m: Points,
    others: Sequence[Instance],
    *,
    raised_m: float = RAISED_M,
    sinks_m: float = RAISED_M,
) -> tuple[Part, ...] | None:
    """Return the parts where they come to rest on the triangles below.

    Args:
        shape: the parts around their origin, standing on it.
        position_m: float64 (3,), where the origin is expected to end up.
        raised_m: from how far above it is let go.
        sinks_m: how far below the expected place it may end.

    Returns:
        None where nothing is below within reach, or where surfaces would cross.
    """
    parts = place(shape, yaw_deg, position_m)
    body = Body(parts)
    around = Around(list(others), body.low, body.high)
    rise_m = raised_m - around.drop_m(body, raised_m) + RESTING_M
    if not -sinks_m < rise_m < raised_m:
        return None
    if around.crosses(body, np.array([0.0, rise_m, 0.0])):
        return None
    return tuple(part.moved((0, rise_m, 0)) for part in parts)
