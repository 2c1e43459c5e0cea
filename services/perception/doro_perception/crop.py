"""What the crop net looks at: the square around a box, 96 x 96."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from doro_perception.backend import RgbImage

SIDE_PX = 96
MARGIN = 0.15
OUTSIDE = (114, 114, 114)


def cut_out(rgb: RgbImage, box_px: NDArray[Any] | list[float]) -> RgbImage:
    """Return the square around a box with 15 % margin, uint8 (96, 96, 3).

    What lies outside of the image is gray.
    """
    xmin, ymin, xmax, ymax = (float(value) for value in box_px)
    half = max(xmax - xmin, ymax - ymin) * (1 + 2 * MARGIN) / 2
    x, y = (xmin + xmax) / 2, (ymin + ymax) / 2
    left, top = int(np.floor(x - half)), int(np.floor(y - half))
    right, bottom = max(int(np.ceil(x + half)), left + 1), max(int(np.ceil(y + half)), top + 1)
    height, width = rgb.shape[:2]
    part: NDArray[Any] = rgb[max(0, top) : min(height, bottom), max(0, left) : min(width, right)]
    pads = (max(0, -top), max(0, bottom - height), max(0, -left), max(0, right - width))
    if part.size == 0:
        return np.full((SIDE_PX, SIDE_PX, 3), OUTSIDE[0], np.uint8)
    if any(pads):
        part = cv2.copyMakeBorder(
            np.ascontiguousarray(part), *pads, cv2.BORDER_CONSTANT, value=OUTSIDE
        )
    how = cv2.INTER_AREA if part.shape[0] > SIDE_PX else cv2.INTER_LINEAR
    return np.asarray(cv2.resize(part, (SIDE_PX, SIDE_PX), interpolation=how), np.uint8)
