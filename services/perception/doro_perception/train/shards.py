"""Shards of labelled frames (written by ``doro_evaluation.perception_frames``) as samples."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from queue import Queue
from threading import Thread
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.uint8]
Rng = np.random.Generator


@dataclass(frozen=True)
class Frame:
    """One labelled frame; columns as in the shard."""

    jpeg: NDArray[np.uint8]
    box: NDArray[np.float32]
    kind: NDArray[np.int16]
    colour: NDArray[np.int8]
    material: NDArray[np.int8]
    ignore: NDArray[np.bool_]

    def image(self) -> Image:
        """Return the picture, RGB."""
        decoded = cv2.imdecode(self.jpeg, cv2.IMREAD_COLOR)
        if decoded is None:
            raise ValueError("a frame of a shard is no JPEG: render the shard again")
        return np.ascontiguousarray(decoded[..., ::-1], dtype=np.uint8)


class Shards:
    """All frames of a folder; :meth:`refresh` finds shards that came later."""

    def __init__(self, folder: Path, pattern: str = "train-*.npz") -> None:
        self._folder, self._pattern = folder, pattern
        self._seen: set[str] = set()
        self.frames: list[Frame] = []
        self.refresh()

    def refresh(self) -> None:
        for path in sorted(self._folder.glob(self._pattern)):
            if path.name in self._seen or path.name.endswith(".part.npz"):
                continue
            self._seen.add(path.name)
            self.frames += _read(path)


def _read(path: Path) -> list[Frame]:
    with np.load(path) as data:
        columns = {name: data[name] for name in data.files}
    starts = np.concatenate([[0], columns["ends"]])
    names = ("box", "kind", "colour", "material", "ignore")
    edges = np.searchsorted(columns["frame"], np.arange(len(starts)))
    return [
        Frame(
            columns["jpeg"][starts[k] : starts[k + 1]].copy(),
            *(columns[name][edges[k] : edges[k + 1]] for name in names),
        )
        for k in range(len(starts) - 1)
    ]


def photometric(image: Image, rng: Rng, strength: float = 1.0) -> Image:
    """Return the image under another light, camera and compression."""
    x: NDArray[Any] = image.astype(np.float32)
    if rng.random() < 0.7:
        x = x * rng.uniform(1 - 0.35 * strength, 1 + 0.35 * strength)
        x += rng.uniform(-20, 20) * strength
    if rng.random() < 0.5:
        mean = x.mean()
        x = (x - mean) * rng.uniform(1 - 0.3 * strength, 1 + 0.35 * strength) + mean
    if rng.random() < 0.5:
        gray = x.mean(2, keepdims=True)
        x = gray + (x - gray) * rng.uniform(1 - 0.4 * strength, 1 + 0.4 * strength)
    if rng.random() < 0.4:
        x = x * rng.uniform(1 - 0.1 * strength, 1 + 0.1 * strength, (1, 1, 3))
    if rng.random() < 0.3:
        x = 255 * (np.clip(x, 0, 255) / 255) ** rng.uniform(0.75, 1.35)
    if rng.random() < 0.2:
        x = cv2.GaussianBlur(x, (0, 0), float(rng.uniform(0.4, 1.0)))
    if rng.random() < 0.3:
        x = x + rng.normal(0, rng.uniform(2, 8), x.shape)
    done: Image = np.clip(x, 0, 255).astype(np.uint8)
    return done


def resized(image: Image, side_px: int, rng: Rng | None = None) -> Image:
    """Return the image at another size; with ``rng`` now and then without smoothing."""
    if image.shape[0] == side_px and image.shape[1] == side_px:
        return image
    how = cv2.INTER_AREA if image.shape[0] > side_px else cv2.INTER_LINEAR
    if rng is not None and rng.random() < 0.3:
        how = cv2.INTER_NEAREST
    return np.asarray(cv2.resize(image, (side_px, side_px), interpolation=how), np.uint8)


def prefetched(make: Callable[[Rng], Any], seed: int, depth: int = 4) -> Iterator[Any]:
    """Yield endless batches made by a thread: OpenCV works while torch does."""
    queue: Queue[Any] = Queue(depth)

    def work() -> None:
        rng = np.random.default_rng(seed)
        while True:
            queue.put(make(rng))

    Thread(target=work, daemon=True).start()
    while True:
        yield queue.get()
