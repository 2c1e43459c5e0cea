"""Settings of the next-view planner, table ``[mapper.planner]``."""

from __future__ import annotations

import msgspec


class PlannerSettings(msgspec.Struct, frozen=True, kw_only=True):
    """What may be tuned; defaults from bedrooms only.

    Attributes:
        every: without being asked for goals, one is published after so many frames; 0: never.
            A robot that asks gets one after each frame.
        voxel_m, reach_m: edge of a voxel; how far from the first camera space is kept.
        sight_m: nothing is expected to be noticed farther away.
        small_m, least_px: a thing of that size must be so many pixels to be found (with 37 %).
        trust: share of the detector's chance that is believed: the rest is asked for again.
        per_top_voxel, per_side_voxel, per_unknown_voxel: things expected in a voxel that is a
            surface to stand on, another surface, or never seen.
        tentative, twins, unclear: what it is worth to see a thing again that was seen once, to
            see two alike in one view, to see a thing from another side.
        asked: factor on things of the class that the instruction is about.
        travel_per_m: views are ranked by gain / (1 + travel_per_m * way).
        least_gain: below it exploration is done.
        budget: views that are ray-cast per goal at most.
        max_views: reachable views kept; more are thinned evenly.
        radius_m: the robot's, for views that the mapper proposes itself.
        yaws, horizons_deg: directions tried where the robot leaves them open.
    """

    every: int = 10
    voxel_m: float = 0.2
    reach_m: float = 20.0
    sight_m: float = 5.0
    small_m: float = 0.10
    least_px: float = 6.0
    trust: float = 0.7
    per_top_voxel: float = 0.02
    per_side_voxel: float = 0.005
    per_unknown_voxel: float = 0.01
    tentative: float = 0.5
    twins: float = 0.4
    unclear: float = 0.1
    asked: float = 3.0
    travel_per_m: float = 0.1
    least_gain: float = 0.2
    budget: int = 96
    max_views: int = 4096
    radius_m: float = 0.2
    yaws: int = 8
    horizons_deg: tuple[float, ...] = (0.0, 30.0)

    def __post_init__(self) -> None:
        lengths = (self.voxel_m, self.reach_m, self.sight_m, self.small_m, self.least_px)
        if min(lengths) <= 0 or min(self.budget, self.max_views, self.yaws) < 1:
            raise ValueError("lengths, budget, max_views and yaws of the planner must be > 0")
        if self.every < 0 or self.travel_per_m < 0 or not self.horizons_deg:
            raise ValueError("every and travel_per_m must not be negative, horizons_deg not empty")
