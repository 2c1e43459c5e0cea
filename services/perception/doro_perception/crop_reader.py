"""What the crop net says of boxes: on several threads each takes some of the boxes.

onnxruntime's own threads share the work of each layer, which are small here: ten crops take three
quarters of the time on two threads. Two halves on two threads take little more than half of it.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from doro_perception.backend import RgbImage
from doro_perception.classes import CLASSES, COLOURS, MATERIALS
from doro_perception.crop import cut_out
from doro_perception.sessions import Session
from doro_schemas.errors import Refused

LEAST_ROWS = 2
"""A net adds up a single crop in another order than several: no thread has just one of them, so
that the number of threads changes no bit."""
OUTPUTS = {"kind": len(CLASSES) + 2, "color": len(COLOURS), "material": len(MATERIALS)}


class CropReader:
    """The crop net of a captioner.

    Args:
        threads: how many boxes are looked at at once.
        advice: what to do about a file that cannot be used.

    Raises:
        Refused: the file is missing, corrupt or another model.
    """

    def __init__(self, path: Path, threads: int, advice: str) -> None:
        self._session = Session(path, 1, advice)
        self._session.need({"crops": "tensor(uint8)"}, dict.fromkeys(OUTPUTS, "tensor(float)"))
        self._threads = threads
        self._others = ThreadPoolExecutor(threads - 1, "crops") if threads > 1 else None

    def logits(self, rgb: RgbImage, boxes: NDArray[np.float64]) -> list[NDArray[np.float32]]:
        """Return logits of class, colour and material of n boxes, float32 (n, classes + 2),
        (n, 11), (n, 9).

        Raises:
            Refused: the model fails, or gives other shapes.
        """
        count = max(1, min(self._threads, len(boxes) // LEAST_ROWS))
        first, *rest = np.array_split(boxes, count)
        if self._others is None or not rest:
            return self._some(rgb, first)
        later = [self._others.submit(self._some, rgb, part) for part in rest]
        parts = [self._some(rgb, first), *(item.result() for item in later)]
        return [np.concatenate(column) for column in zip(*parts, strict=True)]

    def _some(self, rgb: RgbImage, boxes: NDArray[np.float64]) -> list[NDArray[np.float32]]:
        crops = np.stack([cut_out(rgb, box) for box in boxes])
        found: list[Any] = self._session.run(list(OUTPUTS), {"crops": crops})
        widths = tuple(OUTPUTS.values())
        if any(item.shape != (len(crops), n) for item, n in zip(found, widths, strict=True)):
            raise Refused(
                f"model {self._session.path.name} gives {[item.shape for item in found]} for"
                f" {len(crops)} crops, not {widths} columns: {self._session.advice}"
            )
        return found
