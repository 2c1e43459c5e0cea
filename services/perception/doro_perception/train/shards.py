"""Shards of labelled frames (written by ``doro_evaluation.dressing.frames``) as samples."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from queue import Queue
from threading import Thread
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from doro_perception.backend import intersection_over_union

SHOWS_IOU, NOBODY_IOU = 0.5, 0.3
MILD = 0.4
NOBODY, UNCLEAR = -1, -2
Image = NDArray[np.uint8]
Rng = np.random.Generator


@dataclass(frozen=True)
class Frame:
    """One labelled frame; columns as in the shard.

    Attributes:
        plain: as the evaluation renders; varied: with other furniture than the room has.
        mined: what a proposer takes for things, (n, 4) px; empty where nobody looked.
        mined_of: the row of ``box`` that a proposal shows, or one of ``NOBODY``, ``UNCLEAR``.
    """

    jpeg: NDArray[np.uint8]
    box: NDArray[np.float32]
    kind: NDArray[np.int16]
    colour: NDArray[np.int8]
    material: NDArray[np.int8]
    ignore: NDArray[np.bool_]
    plain: bool = False
    varied: bool = False
    mined: NDArray[np.float32] = field(default_factory=lambda: np.zeros((0, 4), np.float32))
    mined_of: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))
    decoded: list[Image] = field(default_factory=list, compare=False)

    @property
    def strength(self) -> float:
        """How often and how strongly samples are changed: plain frames are to be learned as they
        are, dressed ones against being made for one renderer.
        """
        return MILD if self.plain else 1.0

    def image(self) -> Image:
        """Return the picture, RGB; decoded once, not to be written into."""
        if self.decoded:
            return self.decoded[0]
        decoded = cv2.imdecode(self.jpeg, cv2.IMREAD_COLOR)
        if decoded is None:
            raise ValueError("a frame of a shard is no JPEG: render the shard again")
        self.decoded.append(np.ascontiguousarray(decoded[..., ::-1], dtype=np.uint8))
        return self.decoded[0]


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
            self.frames += read_frames(path)


def mined_path(shard: Path) -> Path:
    """Return where the proposals of a shard are (``doro_perception.train.mine``)."""
    return shard.with_name(f"mined-{shard.name}")


def read_frames(path: Path) -> list[Frame]:
    """Return the frames of a shard, with what was mined of them."""
    with np.load(path) as data:
        columns = {name: data[name] for name in data.files}
    starts = np.concatenate([[0], columns["ends"]])
    names = ("box", "kind", "colour", "material", "ignore")
    edges = np.searchsorted(columns["frame"], np.arange(len(starts)))
    frames = [
        Frame(
            jpeg=columns["jpeg"][starts[k] : starts[k + 1]].copy(),
            **{name: columns[name][edges[k] : edges[k + 1]] for name in names},
            plain=bool(columns.get("plain", False)),
            varied=bool(columns.get("varied", False)),
        )
        for k in range(len(starts) - 1)
    ]
    mined = mined_path(path)
    if not mined.exists():
        return frames
    with np.load(mined) as data:
        boxes, ends = data["box"], np.concatenate([[0], data["ends"]])
    return [
        replace(frame, mined=own, mined_of=shown_by(own, frame))
        for frame, own in zip(frames, np.split(boxes, ends[1:-1]), strict=True)
    ]


def shown_by(proposals: NDArray[np.float32], frame: Frame) -> NDArray[np.int64]:
    """Return by proposal the row of the thing that it shows, ``NOBODY`` or ``UNCLEAR``.

    Args:
        proposals: (n, 4) px.
    """
    of = np.full(len(proposals), NOBODY, np.int64)
    known = ~frame.ignore & (frame.kind >= 0)
    for row, proposal in enumerate(proposals.astype(np.float64)):
        if not len(frame.box):
            break
        overlaps = intersection_over_union(proposal, frame.box.astype(np.float64))
        best = int(overlaps.argmax())
        if overlaps[best] >= SHOWS_IOU and known[best]:
            of[row] = best
        elif overlaps[best] >= NOBODY_IOU or _inside(proposal, frame.box[~known]):
            of[row] = UNCLEAR
    return of


def _inside(box: NDArray[np.float64], others: NDArray[np.float32]) -> bool:
    """Tell whether at least half of a box lies in one of others."""
    size = np.clip(np.minimum(box[2:], others[:, 2:]) - np.maximum(box[:2], others[:, :2]), 0, None)
    return bool((size.prod(axis=1) >= 0.5 * (box[2:] - box[:2]).prod()).any())


def photometric(image: Image, rng: Rng, strength: float = 1.0) -> Image:
    """Return the image under another light, camera and compression.

    Light, contrast, saturation and tint are one affine map of the colours.
    """
    matrix, offset = np.eye(3), np.zeros(3)
    if rng.random() < 0.7:
        matrix *= rng.uniform(1 - 0.35 * strength, 1 + 0.35 * strength)
        offset += rng.uniform(-20, 20) * strength
    if rng.random() < 0.5:
        mean = float((matrix @ np.asarray(cv2.mean(image)[:3]) + offset).mean())
        contrast = rng.uniform(1 - 0.3 * strength, 1 + 0.35 * strength)
        matrix *= contrast
        offset = (offset - mean) * contrast + mean
    if rng.random() < 0.5:
        share = rng.uniform(1 - 0.4 * strength, 1 + 0.4 * strength)
        blend = share * np.eye(3) + (1 - share) / 3
        matrix, offset = blend @ matrix, blend @ offset
    if rng.random() < 0.4:
        tint = np.diag(rng.uniform(1 - 0.1 * strength, 1 + 0.1 * strength, 3))
        matrix, offset = tint @ matrix, tint @ offset
    x: NDArray[Any] = cv2.transform(image, np.column_stack([matrix, offset]))
    if rng.random() < 0.3:
        gamma = rng.uniform(0.75, 1.35)
        x = cv2.LUT(x, (255 * (np.arange(256) / 255) ** gamma).astype(np.uint8))
    if rng.random() < 0.2:
        x = cv2.GaussianBlur(x, (0, 0), float(rng.uniform(0.4, 1.0)))
    if rng.random() < 0.3:
        noise = rng.standard_normal(x.shape, np.float32) * np.float32(rng.uniform(2, 8))
        x = np.clip(x + noise, 0, 255).astype(np.uint8)
    done: Image = np.ascontiguousarray(x, dtype=np.uint8)
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
