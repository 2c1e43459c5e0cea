"""Text in pictures: size, wrapping and drawing with OpenCV's own font."""

from __future__ import annotations

import unicodedata
from typing import Any

import cv2
import msgspec
import numpy as np
from numpy.typing import NDArray

from doro_viewer.colors import Rgb

Canvas = NDArray[np.uint8]
FONT = cv2.FONT_HERSHEY_SIMPLEX
LINE_SPACING = 1.45
_PLAIN = str.maketrans("\u2018\u2019\u201c\u201d\u2013\u2014\u2026", "''\"\"--.")


class Style(msgspec.Struct, frozen=True):
    """How text looks: ``scale`` of OpenCV's font (about 22 px per 1.0), stroke and colour."""

    scale: float = 0.5
    color: Rgb = (40, 40, 40)
    stroke_px: int = 1

    @property
    def line_px(self) -> int:
        """Distance of lines."""
        return round(22 * self.scale * LINE_SPACING)


def plain(text: str) -> str:
    """Return text that the font has: accents dropped, other signs as '?'."""
    spread = unicodedata.normalize("NFKD", " ".join(text.split()).translate(_PLAIN))
    kept = "".join(char for char in spread if not unicodedata.combining(char))
    return kept.encode("ascii", "replace").decode()


def text_width_px(text: str, style: Style) -> int:
    """Return the width of one line."""
    return int(cv2.getTextSize(text, FONT, style.scale, style.stroke_px)[0][0])


def wrap(text: str, limit_px: int, style: Style, max_lines: int = 100) -> list[str]:
    """Return the lines of a text, broken at spaces (inside a word only if it is too wide).

    What does not fit into ``max_lines`` is cut, shown by dots.
    """
    lines = [""]
    for word in plain(text).split(" "):
        rest = word
        while rest:
            candidate = f"{lines[-1]} {rest}".strip()
            if text_width_px(candidate, style) <= limit_px:
                lines[-1], rest = candidate, ""
            elif lines[-1]:
                lines.append("")
            else:
                cut = _fitting(rest, limit_px, style)
                lines[-1], rest = rest[:cut], rest[cut:]
                lines.append("")
    kept = [line for line in lines if line]
    if len(kept) > max_lines:
        kept = kept[:max_lines]
        last = kept[-1]
        while last and text_width_px(last + "...", style) > limit_px:
            last = last[:-1]
        kept[-1] = last.rstrip() + "..."
    return kept


def _fitting(word: str, limit_px: int, style: Style) -> int:
    """Return how many letters of a word fit, at least one."""
    count = len(word)
    while count > 1 and text_width_px(word[:count], style) > limit_px:
        count -= 1
    return count


def write(canvas: Canvas, text: str, left: int, baseline: int, style: Style) -> None:
    """Write one line."""
    cv2.putText(
        canvas,
        plain(text),
        (left, baseline),
        FONT,
        style.scale,
        style.color,
        style.stroke_px,
        cv2.LINE_AA,
    )


def write_lines(canvas: Canvas, lines: list[str], left: int, top: int, style: Style) -> int:
    """Write lines below ``top``; return where the next thing may begin."""
    for line in lines:
        top += style.line_px
        write(canvas, line, left, top - round(6 * style.scale), style)
    return top


def rectangle(canvas: Canvas, box: tuple[int, int, int, int], color: Rgb, stroke: int) -> None:
    """Draw (left, top, right, bottom); a stroke of -1 fills it."""
    left, top, right, bottom = box
    cv2.rectangle(canvas, (left, top), (right, bottom), color, stroke, cv2.LINE_8)


def line(canvas: Canvas, points: Any, color: Rgb, stroke: int) -> None:
    """Draw a line through points (n, 2) in pixels."""
    shape = np.asarray(points, dtype=np.float64).round().astype(np.int32).reshape(-1, 1, 2)
    cv2.polylines(canvas, [shape], False, color, stroke, cv2.LINE_AA)
