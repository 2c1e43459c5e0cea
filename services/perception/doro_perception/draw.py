"""Boxes and captions drawn into an image, for people."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from doro_perception.backend import RgbImage
from doro_perception.caption import caption
from doro_schemas.errors import Refused
from doro_schemas.messages import CaptionedBox, FrameCaptions

# Distinct on walls and floors alike; a caption keeps the colour of its box.
LINE_RGB = (
    (230, 25, 75),
    (0, 130, 200),
    (245, 130, 48),
    (60, 180, 75),
    (145, 30, 180),
    (240, 50, 230),
    (0, 128, 128),
)
TEXT_SCALE = 0.45


def label(box: CaptionedBox) -> str:
    """Return what is written beside a box: caption and score."""
    text = box.caption or (caption(box.graph) if box.graph is not None else "")
    return f"{text} {box.score:.2f}"


def draw_captions(rgb: RgbImage, captions: FrameCaptions) -> RgbImage:
    """Return a copy of ``rgb``, uint8 (height, width, 3), with all boxes drawn.

    Raises:
        ValueError: the captions are of an image of another size.
    """
    if rgb.shape != (captions.height_px, captions.width_px, 3):
        raise ValueError(
            f"captions of {captions.width_px}x{captions.height_px} px do not belong to an image"
            f" of shape {rgb.shape}"
        )
    canvas = np.ascontiguousarray(rgb).copy()
    for index, box in enumerate(captions.detections):
        colour = LINE_RGB[index % len(LINE_RGB)]
        left, top, right, bottom = (round(value) for value in box.box_px)
        cv2.rectangle(canvas, (left, top), (right - 1, bottom - 1), colour, 2)
        text = label(box)
        (wide, high), _ = cv2.getTextSize(text, cv2.FONT_HERSHEY_SIMPLEX, TEXT_SCALE, 1)
        x = max(0, min(left, captions.width_px - wide - 4))
        y = top if top >= high + 6 else min(top + high + 6, captions.height_px)
        cv2.rectangle(canvas, (x, y - high - 6), (x + wide + 4, y), colour, cv2.FILLED)
        cv2.putText(
            canvas,
            text,
            (x + 2, y - 4),
            cv2.FONT_HERSHEY_SIMPLEX,
            TEXT_SCALE,
            (255, 255, 255),
            1,
            cv2.LINE_AA,
        )
    return canvas


def write_png(path: Path, rgb: RgbImage) -> None:
    """Write an image as PNG.

    Raises:
        Refused: the file cannot be written.
    """
    done, data = cv2.imencode(".png", np.ascontiguousarray(rgb[..., ::-1]))
    if not done:
        raise Refused(f"{path} cannot be written: OpenCV cannot make a PNG of {rgb.shape}")
    try:
        path.write_bytes(data.tobytes())
    except OSError as error:
        raise Refused(
            f"{path} cannot be written ({error.strerror}): name another folder"
        ) from error
