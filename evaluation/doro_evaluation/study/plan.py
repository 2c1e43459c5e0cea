"""The plan of a room from above: where the lettered things and their landmarks are."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from html import escape

from doro_sim_feeder.rooms.expressions import name_of
from doro_sim_feeder.rooms.truth import NO_LANDMARK, TrueInstance

SIDE_PX = 480
EDGE_PX = 14
FURNITURE_M = 0.45
"""Things with a side of this on the floor are drawn."""
WANTED, OTHER = "#ffc400", "#ffffff"
NAME_PX, LINE_PX = 17, 19
HEAD_PX = 14
SAME_NAME_PX = 90


def draw_plan(
    truth: Sequence[TrueInstance], marks: Mapping[str, str], wanted: Sequence[str]
) -> str:
    """Return the plan as an SVG in a data URI; x goes right, z up.

    Furniture is gray; what a lettered thing is on, in or near has its name.

    Args:
        marks: object ids by letter; wanted: letters in yellow.
    """
    by_id = {item.object_id: item for item in truth}
    marked = [by_id[one] for one in marks.values() if one in by_id]
    landmarks = {relation.object_id for item in marked for relation in item.relations}
    drawn = [
        item
        for item in truth
        if item.object_id in landmarks
        or (
            max(item.size_m[0], item.size_m[2]) >= FURNITURE_M
            and item.object_type not in NO_LANDMARK
        )
    ]
    frame = _Frame([*drawn, *marked])
    large_first = sorted(drawn, key=lambda item: (-item.size_m[0] * item.size_m[2], item.object_id))
    body = [_furniture(item, frame, item.object_id in landmarks) for item in large_first]
    named = [item for item in large_first if item.object_id in landmarks]
    body += _names(named, frame, marked)
    body += [
        _letter(letter, by_id[one], frame, letter in wanted)
        for letter, one in marks.items()
        if one in by_id
    ]
    svg = (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {SIDE_PX} {SIDE_PX}"'
        f' width="{SIDE_PX}" height="{SIDE_PX}" font-family="sans-serif">'
        f'<rect width="100%" height="100%" fill="#f4f4f1"/>{"".join(body)}</svg>'
    )
    return f"data:image/svg+xml;base64,{base64.b64encode(svg.encode()).decode()}"


class _Frame:
    """World x, z in metres to pixels of the plan."""

    def __init__(self, items: Sequence[TrueInstance]) -> None:
        lows = [[item.center_m[k] - item.size_m[k] / 2 for k in (0, 2)] for item in items]
        highs = [[item.center_m[k] + item.size_m[k] / 2 for k in (0, 2)] for item in items]
        self._left = min((one[0] for one in lows), default=0.0)
        self._top = max((one[1] for one in highs), default=1.0)
        width_m = max((one[0] for one in highs), default=1.0) - self._left
        height_m = self._top - min((one[1] for one in lows), default=0.0)
        inner = SIDE_PX - 2 * EDGE_PX
        self.px_per_m = inner / max(width_m, height_m, 0.1)
        self._shift_px = [
            EDGE_PX + (inner - one * self.px_per_m) / 2 for one in (width_m, height_m)
        ]

    def at(self, x_m: float, z_m: float) -> tuple[float, float]:
        """Return a point of the ground in the plan, pixels."""
        x = self._shift_px[0] + (x_m - self._left) * self.px_per_m
        return x, self._shift_px[1] + (self._top - z_m) * self.px_per_m


def _furniture(item: TrueInstance, frame: _Frame, named: bool) -> str:
    x, y = frame.at(item.center_m[0] - item.size_m[0] / 2, item.center_m[2] + item.size_m[2] / 2)
    width, height = (item.size_m[k] * frame.px_per_m for k in (0, 2))
    fill = "#c9d8e6" if named else "#e3e3df"
    return (
        f'<rect x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" height="{height:.1f}" rx="2"'
        f' fill="{fill}" stroke="#8a8a86" fill-opacity=".85"/>'
    )


def _names(
    items: Sequence[TrueInstance], frame: _Frame, letters: Sequence[TrueInstance]
) -> list[str]:
    """Return the names at the middle of their things, none over another or a letter."""
    taken = [(x, y + 5, HEAD_PX + 2.0) for x, y in (_middle(one, frame) for one in letters)]
    written: list[tuple[float, str]] = []
    out = []
    for item in items:
        x, y = _middle(item, frame)
        text = name_of(item.object_type)
        if any(text == b and abs(x - a) < SAME_NAME_PX for a, b in written):
            continue  # a shelf of many boards is named once
        written.append((x, text))
        half = len(text) * NAME_PX * 0.28
        x = min(max(x, half + 2), SIDE_PX - half - 2)
        y = max(y + 6, LINE_PX)
        while any(abs(y - b) < LINE_PX and abs(x - a) < half + c for a, b, c in taken):
            y += 3
        if y > SIDE_PX - 4:
            continue
        taken.append((x, y, half))
        out.append(
            f'<text x="{x:.1f}" y="{y:.1f}" font-size="{NAME_PX}" text-anchor="middle" fill="#223"'
            f' stroke="#fff" stroke-width="3" paint-order="stroke">{escape(text)}</text>'
        )
    return out


def _letter(letter: str, item: TrueInstance, frame: _Frame, wanted: bool) -> str:
    x, y = _middle(item, frame)
    tint = WANTED if wanted else OTHER
    return (
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{HEAD_PX}" fill="{tint}" stroke="#141414"'
        f' stroke-width="2"/><text x="{x:.1f}" y="{y + 6.5:.1f}" font-size="18"'
        f' font-weight="bold" text-anchor="middle" fill="#141414">{escape(letter)}</text>'
    )


def _middle(item: TrueInstance, frame: _Frame) -> tuple[float, float]:
    return frame.at(item.center_m[0], item.center_m[2])
