"""One colour word out of 11 for a crop, or none where the crop is not of one colour.

The 11 basic colour terms of English (Berlin and Kay); nearest prototype in CIE Lab per
pixel, then a vote. Lightness counts half, because shading moves it.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from doro_perception.backend import RgbImage

COLOURS = (
    "red",
    "blue",
    "green",
    "yellow",
    "white",
    "black",
    "orange",
    "purple",
    "brown",
    "pink",
    "gray",
)
CENTRAL_SHARE = 0.6
SAMPLE_SIDE_PX = 32
LIGHTNESS_WEIGHT = 0.5
MIN_SHARE = 0.45
MIN_LEAD = 0.15
RING_SHARE = 0.08
BACKGROUND_CELL = 10.0
BACKGROUND_SHARE = 0.08
BACKGROUND_DISTANCE = 10.0
MIN_FOREGROUND = 0.15

# sRGB 0..255. Several per name: a lit and a shaded one, and for red, brown and blue the tones
# that household things have.
_PROTOTYPES: dict[str, tuple[tuple[int, int, int], ...]] = {
    "red": ((191, 20, 18), (128, 13, 13), (217, 51, 51), (240, 30, 30), (95, 22, 24)),
    "blue": (
        (26, 56, 178),
        (38, 51, 102),
        (89, 128, 191),
        (51, 89, 217),
        (45, 140, 175),
        (50, 92, 110),
        (100, 130, 160),
    ),
    "green": ((31, 128, 41), (51, 89, 38), (115, 166, 51), (77, 140, 89), (60, 220, 60)),
    "yellow": ((224, 189, 26), (230, 217, 102), (178, 148, 26), (250, 240, 60)),
    "white": ((237, 237, 235), (210, 210, 207), (195, 190, 185)),
    "black": ((13, 13, 15), (34, 34, 34)),
    "orange": ((230, 107, 15), (191, 97, 26), (250, 150, 30)),
    "purple": ((107, 33, 133), (76, 30, 102), (140, 76, 166)),
    "brown": ((92, 51, 23), (140, 97, 56), (64, 38, 20), (166, 128, 84), (100, 55, 45)),
    "pink": ((230, 122, 153), (204, 89, 128), (250, 180, 200)),
    "gray": ((115, 115, 117), (153, 153, 153), (77, 77, 79)),
}


def to_lab(rgb: RgbImage) -> NDArray[np.float32]:
    """Return CIE Lab (D65) of sRGB, float32, same shape; L 0..100."""
    scaled = np.ascontiguousarray(rgb, dtype=np.float32) / np.float32(255.0)
    return cv2.cvtColor(scaled, cv2.COLOR_RGB2LAB).astype(np.float32, copy=False)


def central_crop(rgb: RgbImage, box_px: list[float]) -> RgbImage:
    """Return the middle ``CENTRAL_SHARE`` of a box in each direction, at least 1 x 1 px."""
    height_px, width_px = rgb.shape[:2]
    half_w = (box_px[2] - box_px[0]) * CENTRAL_SHARE / 2
    half_h = (box_px[3] - box_px[1]) * CENTRAL_SHARE / 2
    middle_x, middle_y = (box_px[0] + box_px[2]) / 2, (box_px[1] + box_px[3]) / 2
    left = min(max(int(middle_x - half_w), 0), width_px - 1)
    top = min(max(int(middle_y - half_h), 0), height_px - 1)
    right = min(max(int(np.ceil(middle_x + half_w)), left + 1), width_px)
    bottom = min(max(int(np.ceil(middle_y + half_h)), top + 1), height_px)
    return rgb[top:bottom, left:right]


def surroundings(rgb: RgbImage, box_px: list[float]) -> RgbImage:
    """Return the pixels just outside a box, (n, 3); empty where the box fills the image."""
    height_px, width_px = rgb.shape[:2]
    margin_x = max(2.0, (box_px[2] - box_px[0]) * RING_SHARE)
    margin_y = max(2.0, (box_px[3] - box_px[1]) * RING_SHARE)
    left, right = max(0, int(box_px[0] - margin_x)), min(width_px, int(box_px[2] + margin_x))
    top, bottom = max(0, int(box_px[1] - margin_y)), min(height_px, int(box_px[3] + margin_y))
    outside = np.ones((bottom - top, right - left), dtype=np.bool_)
    inner_top, inner_left = max(0, int(box_px[1]) - top), max(0, int(box_px[0]) - left)
    inner_bottom, inner_right = int(np.ceil(box_px[3])) - top, int(np.ceil(box_px[2])) - left
    outside[inner_top:inner_bottom, inner_left:inner_right] = False
    return rgb[top:bottom, left:right][outside]


def foreground(pixels: NDArray[np.float32], around: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the Lab pixels (n, 3) that are unlike the surroundings (m, 3).

    What shows through a chair or below a table has the colour of floor and wall, which also
    lie around the box. Where hardly anything would be left, everything stays.
    """
    if len(around) == 0:
        return pixels
    cells, owner, counts = np.unique(
        np.floor(around / BACKGROUND_CELL).astype(np.int64),
        axis=0,
        return_inverse=True,
        return_counts=True,
    )
    unlike = np.ones(len(pixels), dtype=np.bool_)
    for index in range(len(cells)):
        if counts[index] >= BACKGROUND_SHARE * len(around):
            mean = around[owner.ravel() == index].mean(axis=0)
            unlike &= np.linalg.norm(pixels - mean, axis=1) > BACKGROUND_DISTANCE
    return pixels[unlike] if unlike.mean() >= MIN_FOREGROUND else pixels


def colour_votes(pixels: NDArray[np.float32]) -> NDArray[np.float64]:
    """Return the share of Lab pixels (n, 3) nearest to each of ``COLOURS``, (11,), sum 1."""
    owners = [index for index, name in enumerate(COLOURS) for _ in _PROTOTYPES[name]]
    rows = np.array([[rgb for name in COLOURS for rgb in _PROTOTYPES[name]]], dtype=np.uint8)
    difference = pixels[:, None, :] - to_lab(rows)
    difference[..., 0] *= np.float32(np.sqrt(LIGHTNESS_WEIGHT))
    nearest = np.square(difference).sum(axis=2).argmin(axis=1)
    counts = np.bincount(np.array(owners)[nearest], minlength=len(COLOURS))
    votes: NDArray[np.float64] = counts / counts.sum()
    return votes


def colour_name(crop: RgbImage, around: RgbImage | None = None) -> str | None:
    """Return the colour of a crop, or None where no colour holds enough of it.

    Args:
        crop: uint8 (height, width, 3), not empty.
        around: uint8 (m, 3), pixels around the thing; what is like them does not vote.
    """
    side_h = min(SAMPLE_SIDE_PX, crop.shape[0])
    side_w = min(SAMPLE_SIDE_PX, crop.shape[1])
    # Samples, not means: averaging would mix a thin thing with what shows through it.
    small = cv2.resize(
        np.ascontiguousarray(crop), (side_w, side_h), interpolation=cv2.INTER_NEAREST
    )
    pixels = to_lab(small.astype(np.uint8, copy=False)).reshape(-1, 3)
    if around is not None and len(around) > 0:
        pixels = foreground(pixels, to_lab(around[None]).reshape(-1, 3))
    votes = colour_votes(pixels)
    first, second = np.argsort(-votes, kind="stable")[:2]
    if votes[first] < MIN_SHARE or votes[first] - votes[second] < MIN_LEAD:
        return None
    return COLOURS[first]


def colour_of_box(rgb: RgbImage, box_px: list[float]) -> str | None:
    """Return the colour of the thing in a box ``[xmin, ymin, xmax, ymax]`` px, or None."""
    return colour_name(central_crop(rgb, box_px), surroundings(rgb, box_px))
