"""Seeded variations of light and view, for training data."""

from __future__ import annotations

import numpy as np

from doro_sim_feeder.rooms.exploration import View
from doro_sim_feeder.rooms.footprints import Rect
from doro_sim_feeder.rooms.lighting import Lighting

HORIZON_RANGE_DEG = (-25, 55)
HEIGHT_JITTER_M = 0.15


def random_lighting(room: Rect, seed: int) -> Lighting:
    """Return a seeded light: lamp anywhere over the middle half, warm to cold, dim to bright."""
    rng = np.random.default_rng([seed, 11])
    share = rng.uniform(0.25, 0.75, 2)
    warmth = float(rng.uniform(-1, 1))
    tint = (1 + 0.12 * warmth, 1.0, 1 - 0.16 * warmth)
    side = float(rng.uniform(-0.12, 0.12))
    return Lighting(
        lamp_m=(
            float(room.x_low + share[0] * (room.x_high - room.x_low)),
            float(rng.uniform(1.9, 2.35)),
            float(room.z_low + share[1] * (room.z_high - room.z_low)),
        ),
        lamp_color=tint,
        ambient_color=(1 + 0.05 * warmth, 1.0, 1 - 0.06 * warmth),
        lamp=float(rng.uniform(0.3, 0.8)),
        ambient=float(rng.uniform(0.3, 0.55)),
        side=side,
        head=float(rng.uniform(0.0, 0.2)),
        exposure=float(rng.uniform(0.75, 1.15)),
        gamma=float(rng.uniform(0.75, 1.05)),
    )


def random_view(view: View, seed: int) -> View:
    """Return the view turned to a random yaw and horizon, the camera a little up or down.

    For training data only: an exploration has the robot's own camera (45 and 30 degree steps).
    """
    rng = np.random.default_rng([seed, 12])
    x, y, z = view.position_m
    return View(
        position_m=(x, y + float(rng.uniform(-HEIGHT_JITTER_M, HEIGHT_JITTER_M)), z),
        yaw_deg=int(rng.integers(360)),
        horizon_deg=int(rng.integers(HORIZON_RANGE_DEG[0], HORIZON_RANGE_DEG[1] + 1)),
    )
