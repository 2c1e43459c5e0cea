"""Books, boxes, newspapers and what else is of paper, with covers and prints."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np

from doro_evaluation.dressing.looks.prints import Texture, picture, stretched
from doro_evaluation.dressing.shapes.solids import (
    Maker,
    Rng,
    about_x,
    accent,
    between,
    dark,
    lathe,
    turned,
)
from doro_sim_feeder.rooms.parts import Part, Rgb, blob_part, box_part

WHITE: Rgb = (1.0, 1.0, 1.0)
PAGES: tuple[Rgb, ...] = ((0.88, 0.86, 0.78), (0.93, 0.92, 0.9), (0.8, 0.75, 0.62))
WORDS = [
    "THE",
    "PATH",
    "AHEAD",
    "HOUSE",
    "OF",
    "LIGHT",
    "COOKING",
    "ROBOTS",
    "WINTER",
    "ATLAS",
    "NIGHT",
    "GARDEN",
    "SEA",
    "FIRE",
]


def _lines(image: Texture, rows: tuple[int, int], columns: tuple[int, int], rng: Rng) -> None:
    """Draw lines of small print into an image."""
    left, right = columns
    for y in range(*rows, int(rng.integers(4, 7))):
        end = right - int(rng.integers(0, max((right - left) // 3, 1)))
        cv2.line(image, (left, y), (end, y), (90, 90, 90), 1)


def cover(rng: Rng, color: Rgb) -> Texture:
    """Return the cover of a book: its colour, words, perhaps a picture."""
    image = np.empty((128, 96, 3), np.uint8)
    image[:] = (np.asarray(color) * 255).tolist()
    ink = (245, 240, 225) if sum(color) < 1.5 else (25, 25, 30)
    if rng.random() < 0.5:
        high, wide = int(rng.integers(30, 80)), int(rng.integers(50, 97))
        left, top = (96 - wide) // 2, int(rng.integers(0, 128 - high))
        image[top : top + high, left : left + wide] = cv2.resize(picture(rng), (wide, high))
    y = int(rng.integers(20, 60))
    for _ in range(int(rng.integers(1, 4))):
        word = str(rng.choice(WORDS))
        cv2.putText(
            image, word, (6, y), cv2.FONT_HERSHEY_DUPLEX, 84 / (19 * len(word) + 20), ink, 1
        )
        y += int(rng.integers(14, 26))
    if rng.random() < 0.5:
        cv2.rectangle(image, (3, 3), (92, 124), ink, 1)
    return image


def _one_book(rng: Rng, color: Rgb, size: tuple[float, float, float]) -> list[Part]:
    """Return a closed book that lies, spine to -x, its cover on top."""
    wide, high, deep = size
    board = min(0.1 * high, 0.03)
    page = PAGES[int(rng.integers(len(PAGES)))]
    lid = box_part((-wide / 2, high - board, -deep / 2), (wide / 2, high, deep / 2), color)
    if rng.random() < 0.8:
        lid = stretched(lid, cover(rng, color))
    inset = 0.03 * wide
    return [
        box_part((-wide / 2, 0, -deep / 2), (wide / 2, board, deep / 2), color),
        lid,
        box_part((-wide / 2, 0, -deep / 2), (-wide / 2 + board, high, deep / 2), color),
        box_part(
            (-wide / 2 + board, board, -deep / 2 + inset),
            (wide / 2 - inset, high - board, deep / 2 - inset),
            page,
        ),
    ]


def _open_book(rng: Rng, color: Rgb) -> list[Part]:
    """Return an open book: two bent leaves of print on a cover."""
    parts = [box_part((-1.05, 0, -0.7), (1.05, 0.02, 0.7), color)]
    bend = between(rng, 0.06, 0.2)
    for side in (-1, 1):
        at = np.linspace(0, 1, 7)
        up = bend * np.sin(np.pi * np.sqrt(at)) + 0.05
        for k in range(6):
            low = (min(side * at[k], side * at[k + 1]), 0.02, -0.66)
            high = (max(side * at[k], side * at[k + 1]), (up[k] + up[k + 1]) / 2, 0.66)
            print_ = np.full((64, 20, 3), 238, np.uint8)
            _lines(print_, (6, 60), (0, 20), rng)
            parts.append(stretched(box_part(low, high, WHITE), print_))
    return parts


def _book(rng: Rng, color: Rgb) -> list[Part]:
    """Return a book that lies, stands or is open, or a pile of some."""
    kind, high = rng.random(), between(rng, 0.08, 0.35)
    if kind < 0.2:
        return _open_book(rng, color)
    body = _one_book(rng, color, (0.7, high, 1.0))
    if kind < 0.4:
        return [turned(part, about_x(np.pi / 2 - between(rng, 0, 0.25))) for part in body]
    if kind < 0.55:
        top = high
        for _ in range(int(rng.integers(1, 4))):
            more = between(rng, 0.08, 0.3)
            size = (0.7 * between(rng, 0.7, 1), more, between(rng, 0.7, 1))
            body += [part.moved((0, top, 0)) for part in _one_book(rng, accent(rng, color), size)]
            top += more
    return body


def _box(rng: Rng, color: Rgb) -> list[Part]:
    """Return a box: with its four flaps open, shut with tape, or with a lid."""
    wall, half = 0.02, 0.5
    inner = dark(color, 0.8)
    high, deep = between(rng, 0.4, 1.1), between(rng, 0.6, 1.0) / 2
    parts = [
        box_part((-half, 0, -deep), (half, wall, deep), inner),
        box_part((-half, 0, -deep), (-half + wall, high, deep), color),
        box_part((half - wall, 0, -deep), (half, high, deep), color),
        box_part((-half, 0, -deep), (half, high, -deep + wall), color),
        box_part((-half, 0, deep - wall), (half, high, deep), color),
    ]
    kind = rng.random()
    if kind < 0.5:
        return parts + _flaps(rng, color, (half, high, deep))
    parts.append(box_part((-half, high - 0.01, -deep), (half, high, deep), dark(color, 0.95)))
    if kind < 0.8:
        tape: Rgb = (0.75, 0.66, 0.5) if rng.random() < 0.7 else accent(rng, color)
        parts.append(box_part((-half, high * 0.75, -0.05), (half, high + 0.004, 0.05), tape))
        parts.append(
            box_part((-half - 0.003, high * 0.75, -0.05), (half + 0.003, high, 0.05), tape)
        )
    else:
        lid = high - between(rng, 0.1, 0.35)
        over = box_part(
            (-half - 0.02, lid, -deep - 0.02), (half + 0.02, high + 0.02, deep + 0.02), color
        )
        parts.append(over)
    return parts


def _flaps(rng: Rng, color: Rgb, corner: tuple[float, float, float]) -> list[Part]:
    """Return four open flaps around the top of a box that reaches from -corner to corner."""
    half, high, deep = corner
    flaps = []
    for side in (-1, 1):
        angle, long = between(rng, -0.6, 1.1), between(rng, 0.3, 0.5)
        cos, sin = np.cos(angle), np.sin(angle)
        turn = np.array([[side * cos, sin * side, 0], [-sin, cos, 0], [0, 0, 1.0]])
        flap = box_part(
            (0, -0.006, -deep), (long, 0.006, deep), dark(color, between(rng, 0.85, 1.05))
        )
        flaps.append(turned(flap, turn, (side * half, high, 0)))
        angle = between(rng, -0.6, 1.1)
        cos, sin = np.cos(angle), np.sin(angle)
        turn = np.array([[1.0, 0, 0], [0, cos, -sin], [0, side * sin, side * cos]])
        flap = box_part(
            (-half, -0.006, 0), (half, 0.006, long), dark(color, between(rng, 0.85, 1.05))
        )
        flaps.append(turned(flap, turn, (0, high, side * deep)))
    return flaps


def _tissue_box(rng: Rng, color: Rgb) -> list[Part]:
    """Return a box of tissues, cube or flat, of which one looks out."""
    size, deep = between(rng, 0.4, 1.6), between(rng, 0.45, 0.9)
    body = box_part((-1, 0, -deep), (1, size, deep), color)
    if rng.random() < 0.5:
        body = stretched(body, np.maximum(cover(rng, color), 20))
    slot = blob_part((1.0, 0.02, 0.4), (0.1, 0.1, 0.1)).moved((0, size, 0))
    square = (between(rng, 1.2, 2.2), between(rng, 0.9, 1.6))
    tissue = blob_part((0.8, between(rng, 0.3, 0.9), 0.35), (0.95, 0.95, 0.95), squareness=square)
    return [body, slot, tissue.moved((0, size * 0.92, 0))]


def _newspaper(rng: Rng, color: Rgb) -> list[Part]:
    """Return a folded newspaper: columns of print, a headline, a picture."""
    del color
    image = np.full((128, 96, 3), int(rng.integers(205, 240)), np.uint8)
    cv2.putText(image, "NEWS", (12, 20), cv2.FONT_HERSHEY_DUPLEX, 0.8, (30, 30, 30), 2)
    for column in range(3):
        _lines(image, (30, 124), (4 + 31 * column, 30 + 31 * column), rng)
    if rng.random() < 0.7:
        grey = cv2.cvtColor(cv2.resize(picture(rng), (50, 36)), cv2.COLOR_RGB2GRAY)
        image[40:76, 20:70] = grey[..., None]
    kind, high = rng.random(), between(rng, 0.03, 0.12)
    if kind < 0.2:
        roll = lathe([(0, 0), (0.12, 0), (0.12, 1), (0, 1)], WHITE)
        lying = turned(replace(roll, texture=image), about_x(np.pi / 2))
        return [lying.moved((0, 0.12, 0))]
    parts = [stretched(box_part((-0.4, 0, -0.5), (0.4, high, 0.5), WHITE), image)]
    if kind < 0.6:
        angle = between(rng, -0.4, 0.4)
        cos, sin = np.cos(angle), np.sin(angle)
        turn = np.array([[cos, 0, sin], [0, 1, 0], [-sin, 0, cos]])
        leaf = box_part((-0.4, high, -0.5), (0.38, high + 0.012, between(rng, 0.0, 0.5)), WHITE)
        parts.append(turned(stretched(leaf, image[::-1].copy()), turn))
    return parts


PAPERS: dict[str, Maker] = {
    "Book": _book,
    "Box": _box,
    "TissueBox": _tissue_box,
    "Newspaper": _newspaper,
}
