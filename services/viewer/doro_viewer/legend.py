"""The legend of the map picture."""

from __future__ import annotations

from doro_viewer import map_panel as panel
from doro_viewer.colors import Rgb, mix
from doro_viewer.lettering import Canvas, Style, line, rectangle, wrap, write

LEGEND_PX = 268
LANDMARK_SHARE = 0.40
MAX_ROWS = 9
_BODY = Style(scale=0.5, color=panel.INK)
_TITLE = Style(scale=0.6, color=panel.INK, stroke_px=2)
_TEXT_PX = 28
_ROW_PX = 24
_WRAPPED_PX = 17


def draw_legend(
    canvas: Canvas,
    corner: tuple[int, int],
    asked: list[panel.Region],
    landmarks: list[panel.Region],
    *,
    matches: bool,
) -> None:
    """Draw the legend with its upper left corner at ``corner``.

    Args:
        asked: the coloured regions, a row each.
        landmarks: the pale regions, a row per class.
        matches: explain the two kinds of instance boxes.
    """
    left, top = corner
    write(canvas, "Legend", left, top + 14, _TITLE)
    y = top + 42
    rows = [(region.color, region.name) for region in asked]
    y = _rows(canvas, left, y, rows)
    rows = [
        (mix(panel.OTHER, region.color, LANDMARK_SHARE), f"{region.name} (landmark)")
        for region in landmarks
    ]
    y = _rows(canvas, left, y, rows)
    rows = [(panel.OTHER, "other things"), (panel.FLOOR, "observed floor")]
    y = _rows(canvas, left, y, [*rows, ((255, 255, 255), "not observed")])
    line(canvas, [(left, y - 5), (left + 18, y - 5)], panel.PATH, 1)
    write(canvas, "path of the camera", left + _TEXT_PX, y, _BODY)
    panel.draw_start(canvas, left + 9, y + _ROW_PX - 5)
    write(canvas, "start", left + _TEXT_PX, y + _ROW_PX, _BODY)
    if matches:
        y += 2 * _ROW_PX
        rectangle(canvas, (left, y - 12, left + 18, y), panel.INK, 2)
        write(canvas, "matches what was said", left + _TEXT_PX, y, _BODY)
        y += _ROW_PX
        rectangle(canvas, (left, y - 12, left + 18, y), panel.INK, 1)
        write(canvas, "differs, or not known to", left + _TEXT_PX, y, _BODY)


def _rows(canvas: Canvas, left: int, y: int, rows: list[tuple[Rgb, str]]) -> int:
    """Draw rows of a swatch and its meaning; return where the next row's text stands."""
    for color, text in rows[:MAX_ROWS]:
        rectangle(canvas, (left, y - 12, left + 18, y), color, -1)
        rectangle(canvas, (left, y - 12, left + 18, y), panel.FAINT, 1)
        lines = wrap(text, LEGEND_PX - _TEXT_PX - 24, _BODY, max_lines=2)
        for number, part in enumerate(lines):
            write(canvas, part, left + _TEXT_PX, y + number * _WRAPPED_PX, _BODY)
        y += _ROW_PX + _WRAPPED_PX * (len(lines) - 1)
    if len(rows) > MAX_ROWS:
        write(canvas, f"and {len(rows) - MAX_ROWS} more", left + _TEXT_PX, y, _BODY)
        y += _ROW_PX
    return y
