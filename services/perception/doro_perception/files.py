"""Image files as frames, for people who try a detector on pictures."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from doro_perception.backend import RgbImage
from doro_perception.core import Perception
from doro_perception.image import JPEG_START, PNG_START, decode, jpeg_size, png_size
from doro_schemas.errors import Refused
from doro_schemas.messages import ColorFrame, FrameCaptions


def describe_file(core: Perception, path: Path, number: int = 0) -> tuple[RgbImage, FrameCaptions]:
    """Return a file's pixels, RGB, and what is seen in it.

    Raises:
        Refused: no such file, no JPEG or PNG, or an image that the core refuses.
    """
    frame = read_frame(path, number)
    (message,) = core.color_frame(frame)
    if not isinstance(message, FrameCaptions):
        raise TypeError(f"perception answered with {type(message).__name__}")
    return decode(frame), message


def read_frame(path: Path, number: int = 0) -> ColorFrame:
    """Return a JPEG or PNG file as a colour frame.

    Raises:
        Refused: no such file, or no JPEG or PNG.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise Refused(f"image {path} cannot be read ({error.strerror}): name a file") from error
    if data.startswith(JPEG_START):
        size = jpeg_size(data)
    elif data.startswith(PNG_START):
        size = png_size(data)
    else:
        raise Refused(f"image {path} is neither JPEG nor PNG: convert it")
    if size is None:
        raise Refused(f"image {path} has no readable header: its data is corrupt")
    if min(size) < 1:
        raise Refused(f"image {path} is empty ({size[1]} x {size[0]} px)")
    try:
        return ColorFrame(
            frame=number,
            height_px=size[0],
            width_px=size[1],
            encoding="jpeg" if data.startswith(JPEG_START) else "png",
            data=np.frombuffer(data, np.uint8),
        )
    except ValueError as error:
        raise Refused(f"image {path} cannot be taken: {error}") from error
