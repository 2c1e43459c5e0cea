"""How Rerun arranges the views: camera left, map from above right, talk below."""

from __future__ import annotations

from collections.abc import Sequence

import msgspec
import rerun.blueprint as rrb
from rerun.blueprint.encodings import TextLogColumnKind

CAMERA = "camera"
MAP = "map"
TALK = "talk"
SUMMARY = "summary"
TIMELINE = "frame"
_EYE_HEIGHT_PER_EXTENT = 1.0
_EYE_ABOVE_THINGS_M = 1.5
"""Rerun's eye has a vertical field of view of about 55 degrees; tall things come nearer."""


class Bounds(msgspec.Struct, frozen=True):
    """Ground area that the map view shows, metres, in (a, b)."""

    low_m: tuple[float, float]
    high_m: tuple[float, float]

    def covers(self, other: Bounds) -> bool:
        """Tell whether ``other`` lies inside."""
        low = all(mine <= theirs for mine, theirs in zip(self.low_m, other.low_m, strict=True))
        high = all(mine >= theirs for mine, theirs in zip(self.high_m, other.high_m, strict=True))
        return low and high

    def grown(self, by_m: float) -> Bounds:
        """Return the area with a margin on all sides."""
        return Bounds(
            low_m=(self.low_m[0] - by_m, self.low_m[1] - by_m),
            high_m=(self.high_m[0] + by_m, self.high_m[1] + by_m),
        )


def image_entity(camera: str) -> str:
    """Return the entity of a camera's colour image; its boxes hang below."""
    return f"{CAMERA}/{camera}/image"


def depth_entity(camera: str) -> str:
    """Return the entity of a camera's depth image."""
    return f"{CAMERA}/{camera}/depth"


def eye_above(bounds: Bounds) -> rrb.EyeControls3D:
    """Return an eye that looks straight down on an area, the second ground axis pointing up."""
    a_m, b_m = ((low + high) / 2 for low, high in zip(bounds.low_m, bounds.high_m, strict=True))
    extent_m = max(bounds.high_m[0] - bounds.low_m[0], bounds.high_m[1] - bounds.low_m[1])
    return rrb.EyeControls3D(
        kind=rrb.Eye3DKind.Orbital,
        position=(a_m, b_m - 1e-3, extent_m * _EYE_HEIGHT_PER_EXTENT + _EYE_ABOVE_THINGS_M),
        look_target=(a_m, b_m, 0.0),
        eye_up=(0.0, 1.0, 0.0),
    )


def _talk_columns() -> rrb.TextLogColumns:
    shown = [TextLogColumnKind.LogLevel, TextLogColumnKind.Body]
    return rrb.TextLogColumns(text_log_columns=shown)


def blueprint(cameras: Sequence[str], bounds: Bounds, *, depth: bool) -> rrb.Blueprint:
    """Return the arrangement for the cameras seen so far."""
    views: list[rrb.View] = []
    for camera in cameras:
        views.append(rrb.Spatial2DView(origin=f"/{image_entity(camera)}", name=f"Camera {camera}"))
        if depth:
            views.append(rrb.Spatial2DView(origin=f"/{depth_entity(camera)}", name="Depth"))
    above = rrb.Spatial3DView(
        origin=f"/{MAP}",
        name="Map from above",
        background=(250, 250, 250),
        line_grid=rrb.LineGrid3D(visible=True, spacing=1.0, color=(215, 215, 215)),
        eye_controls=eye_above(bounds),
    )
    left = views[0] if len(views) == 1 else rrb.Tabs(*views, active_tab=0)
    return rrb.Blueprint(
        rrb.Vertical(
            rrb.Horizontal(left, above, column_shares=[1, 1]),
            rrb.Horizontal(
                rrb.TextDocumentView(origin=f"/{SUMMARY}", name="Now"),
                rrb.TextLogView(origin=f"/{TALK}", name="Talk", columns=_talk_columns()),
                column_shares=[1, 1],
            ),
            row_shares=[5, 2],
        ),
        rrb.TimePanel(timeline=TIMELINE, state="collapsed"),
        rrb.SelectionPanel(state="hidden"),
        rrb.BlueprintPanel(state="collapsed"),
        auto_views=False,
    )
