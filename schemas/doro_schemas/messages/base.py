"""What every message has, and the checks that several messages share."""

from __future__ import annotations

import math
from typing import ClassVar

import msgspec

MAX_IMAGE_SIDE_PX = 8192
MAX_TEXT_CHARS = 2000
BOX_TOLERANCE_PX = 0.5


class Message(msgspec.Struct, kw_only=True):
    """Base of all messages.

    Attributes:
        stamp_ns: time of the data the message is about, Unix nanoseconds. A message
            made from another one carries that one's stamp: cores read no clock.
        episode: name of the exploration the message belongs to; empty means "the
            current one".
    """

    VERSION: ClassVar[int] = 1
    SEGMENTS: ClassVar[tuple[str, ...]] = ()
    ADDED: ClassVar[dict[str, object]] = {}
    """Fields that came after the first release and their defaults: with its default such a
    field is left out on the wire, so that older bytes stay what they were. A segment that came
    later stands here as well, and is left out where it is empty."""

    stamp_ns: int = 0
    episode: str = ""


class FrameMessage(Message, kw_only=True):
    """A message about one frame of one camera.

    Attributes:
        camera: name of the camera, one key chunk.
        frame: running number of the frame in its episode, from 0.
        height_px, width_px: size of the image that boxes refer to.
    """

    camera: str = "cam0"
    frame: int
    height_px: int
    width_px: int

    def __post_init__(self) -> None:
        if self.frame < 0:
            raise ValueError(f"frame numbers start at 0, got {self.frame}")
        if not self.camera or any(char in self.camera for char in "/*$#? "):
            raise ValueError(
                f"camera '{self.camera}' is no key chunk: use letters, digits, - and _"
            )
        sides = (self.height_px, self.width_px)
        if not all(1 <= side <= MAX_IMAGE_SIDE_PX for side in sides):
            raise ValueError(f"image of {sides[0]}x{sides[1]} px: sides must be 1..8192")


def check_box(box_px: list[float], height_px: int, width_px: int) -> None:
    """Raise ValueError unless ``[xmin, ymin, xmax, ymax]`` lies in the image and has an area."""
    if len(box_px) != 4 or not all(map(math.isfinite, box_px)):
        raise ValueError(f"box {box_px} must be 4 finite numbers [xmin, ymin, xmax, ymax]")
    xmin, ymin, xmax, ymax = box_px
    if xmin >= xmax or ymin >= ymax:
        raise ValueError(f"box {box_px} is empty: xmin < xmax and ymin < ymax are needed")
    slack = BOX_TOLERANCE_PX
    if xmin < -slack or ymin < -slack or xmax > width_px + slack or ymax > height_px + slack:
        raise ValueError(f"box {box_px} lies outside its image of {width_px}x{height_px} px")


def check_probability(value: float, what: str) -> None:
    """Raise ValueError unless ``value`` is in 0..1."""
    if not 0.0 <= value <= 1.0:
        raise ValueError(f"{what} must be in 0..1, got {value}")
