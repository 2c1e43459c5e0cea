"""From the bytes of a colour frame to pixels, with the size checked before decoding."""

from __future__ import annotations

import cv2
import numpy as np

from doro_perception.backend import RgbImage
from doro_schemas.errors import Refused
from doro_schemas.messages import ColorFrame

JPEG_START, JPEG_END = b"\xff\xd8\xff", b"\xff\xd9"
PNG_START, PNG_END = b"\x89PNG\r\n\x1a\n", b"IEND\xaeB`\x82"
# Start-of-frame markers carry the size; C4, C8 and CC lie in their range and are none.
JPEG_SIZE_MARKERS = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}


def decode(frame: ColorFrame) -> RgbImage:
    """Return the frame's pixels, uint8 (height, width, 3) RGB.

    Raises:
        Refused: bytes that are no such file, cut short, or of another size than declared.
    """
    if frame.encoding == "rgb8":
        return np.ascontiguousarray(frame.data)
    data = frame.data.tobytes()
    what = f"the {frame.encoding} image of camera '{frame.camera}', frame {frame.frame},"
    start, end = (JPEG_START, JPEG_END) if frame.encoding == "jpeg" else (PNG_START, PNG_END)
    if not data.startswith(start):
        raise _refuse(frame, f"{what} is no {frame.encoding} file: send the whole file's bytes")
    if not data.rstrip(b"\x00").endswith(end):
        raise _refuse(frame, f"{what} is cut short: its last bytes are missing, send it again")
    size = jpeg_size(data) if frame.encoding == "jpeg" else png_size(data)
    _check_size(frame, what, size)
    flags = cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION
    try:
        bgr = cv2.imdecode(np.frombuffer(data, dtype=np.uint8), flags)
    except cv2.error as error:
        raise _refuse(frame, f"{what} cannot be decoded ({error.err}): send it again") from error
    if bgr is None:
        raise _refuse(frame, f"{what} cannot be decoded: its data is corrupt, send it again")
    _check_size(frame, what, (bgr.shape[0], bgr.shape[1]))
    return np.ascontiguousarray(bgr[:, :, ::-1]).astype(np.uint8, copy=False)


def png_size(data: bytes) -> tuple[int, int] | None:
    """Return (height, width) from a PNG's first chunk, or None."""
    if len(data) < 24 or data[12:16] != b"IHDR":
        return None
    return int.from_bytes(data[20:24], "big"), int.from_bytes(data[16:20], "big")


def jpeg_size(data: bytes) -> tuple[int, int] | None:
    """Return (height, width) from a JPEG's start-of-frame segment, or None."""
    at = 2
    while at + 9 <= len(data) and data[at] == 0xFF:
        marker = data[at + 1]
        if marker == 0xFF:  # fill byte
            at += 1
        elif marker in JPEG_SIZE_MARKERS:
            high, wide = data[at + 5 : at + 7], data[at + 7 : at + 9]
            return int.from_bytes(high, "big"), int.from_bytes(wide, "big")
        else:
            at += 2 + int.from_bytes(data[at + 2 : at + 4], "big")
    return None


def _check_size(frame: ColorFrame, what: str, size: tuple[int, int] | None) -> None:
    """Raise Refused unless ``size`` (height, width) is the declared one."""
    if size is None:
        raise _refuse(frame, f"{what} has no readable header: its data is corrupt, send it again")
    if size != (frame.height_px, frame.width_px):
        raise _refuse(
            frame,
            f"{what} is {size[1]}x{size[0]} px but is declared as"
            f" {frame.width_px}x{frame.height_px}: declare the size of the file",
        )


def _refuse(frame: ColorFrame, reason: str) -> Refused:
    return Refused(reason, episode=frame.episode, frame=frame.frame)
