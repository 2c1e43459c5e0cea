"""How well boxes, names, colours and materials are told: pure functions over detections.

Average precision is that of PASCAL VOC with all points: detections of a class over all images,
best first, each takes the truth that it overlaps most (IoU >= .5) unless that is taken. What
falls on an ignored truth (too small or hidden to ask for) counts neither way.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from doro_perception.backend import Detection, intersection_over_union

IOU = 0.5
IGNORED_IOU = 0.4
BINS = 10
LEAST_TRUTHS = 3
CERTAIN = 0.05
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Truth:
    """What an image shows.

    Attributes:
        boxes: (n, 4) edges, px.
        names: of each box; several words where any of them is right ("table").
        ignore: (n,) too small or hidden, or of no class that is asked for.
        colours: of each box, None where it has no name; materials: all that are right.
    """

    boxes: Floats
    names: tuple[frozenset[str], ...]
    ignore: NDArray[np.bool_]
    colours: tuple[str | None, ...] = ()
    materials: tuple[frozenset[str], ...] = ()


@dataclass
class Tally:
    """What is collected over images."""

    rows: dict[str, list[tuple[float, bool]]] = field(default_factory=dict)
    truths: dict[str, int] = field(default_factory=dict)
    certain: list[tuple[float, bool]] = field(default_factory=list)
    counts: dict[str, list[int]] = field(default_factory=dict)

    def note(self, name: str, right: bool) -> None:
        """Count one more of a share."""
        pair = self.counts.setdefault(name, [0, 0])
        pair[0] += int(right)
        pair[1] += 1

    def share(self, name: str) -> float:
        right, all_of = self.counts.get(name, [0, 0])
        return right / all_of if all_of else float("nan")


def add_image(tally: Tally, truth: Truth, found: Sequence[Detection]) -> None:
    """Add an image's detections, the nameless ones among them."""
    for names, ignored in zip(truth.names, truth.ignore, strict=True):
        if not ignored:
            key = _key(names)
            tally.truths[key] = tally.truths.get(key, 0) + 1
    boxes = np.array([item.box_px for item in found], np.float64).reshape(-1, 4)
    _add_precision(tally, truth, found, boxes)
    for k, own in enumerate(truth.boxes):
        if truth.ignore[k]:
            continue
        overlaps = intersection_over_union(own, boxes) if len(boxes) else np.zeros(0)
        best = int(overlaps.argmax()) if len(overlaps) else -1
        seen = best >= 0 and overlaps[best] >= IOU
        tally.note("recall", seen)
        if seen and found[best].name:
            words = [name for name, _ in found[best].classes]
            tally.note("top1", words[:1] != [] and words[0] in truth.names[k])
            tally.note("top3", any(word in truth.names[k] for word in words[:3]))
            _add_attributes(tally, truth, k, found[best])


def _add_attributes(tally: Tally, truth: Truth, k: int, item: Detection) -> None:
    if truth.colours and truth.colours[k] and item.colors:
        tally.note("colour", item.colors[0][0] == truth.colours[k])
    if truth.materials and truth.materials[k] and item.materials:
        tally.note("material", item.materials[0][0] in truth.materials[k])


def _key(names: frozenset[str]) -> str:
    return "/".join(sorted(names))


def _add_precision(tally: Tally, truth: Truth, found: Sequence[Detection], boxes: Floats) -> None:
    """Note for each class whether its detections of this image are right, best first."""
    keys = {word: _key(names) for names in truth.names for word in names}
    rows: list[tuple[float, str, int]] = []
    for number, item in enumerate(found):
        lead = item.classes[0][1] if item.classes else 1.0
        told: dict[str, float] = {}
        for word, share in item.classes[:3] or (((item.name, 1.0),) if item.name else ()):
            key = keys.get(word, word)
            told[key] = max(told.get(key, 0.0), item.score * share / max(lead, 1e-9))
        rows += [(score, key, number) for key, score in told.items()]
    taken: set[tuple[str, int]] = set()
    for score, key, number in sorted(rows, key=lambda row: (-row[0], row[1], row[2])):
        item, box = found[number], boxes[number]
        overlaps = intersection_over_union(box, truth.boxes) if len(truth.boxes) else np.zeros(0)
        mine = [
            k
            for k in np.argsort(-overlaps, kind="stable").tolist()
            if overlaps[k] >= IOU
            and _key(truth.names[k]) == key
            and not truth.ignore[k]
            and (key, k) not in taken
        ]
        if mine:
            taken.add((key, mine[0]))
        elif any(truth.ignore[k] and overlaps[k] >= IGNORED_IOU for k in range(len(truth.boxes))):
            continue
        tally.rows.setdefault(key, []).append((score, bool(mine)))
        if key == keys.get(item.name, item.name) and score >= CERTAIN:
            tally.certain.append((score, bool(mine)))


def average_precision(rows: Sequence[tuple[float, bool]], truths: int) -> float:
    """Return the area under the precision-recall curve of one class."""
    if not rows or not truths:
        return 0.0
    right = np.array([hit for _, hit in sorted(rows, key=lambda row: -row[0])], np.float64)
    hits = np.cumsum(right)
    precision = np.maximum.accumulate((hits / np.arange(1, len(hits) + 1))[::-1])[::-1]
    steps = np.diff(np.concatenate([[0.0], hits / truths]))
    return float((steps * precision).sum())


def mean_precision(tally: Tally, classes: Sequence[str] = ()) -> tuple[float, dict[str, float]]:
    """Return mAP@.5 over the classes with enough truths, and each class's.

    Args:
        classes: only these; empty: all.
    """
    each = {
        key: average_precision(tally.rows.get(key, []), count)
        for key, count in sorted(tally.truths.items())
        if count >= LEAST_TRUTHS and (not classes or key in classes)
    }
    return (float(np.mean(list(each.values()))) if each else float("nan")), each


def at_threshold(tally: Tally, threshold: float) -> tuple[float, float]:
    """Return precision and recall of named detections at a score, over all classes."""
    kept = [hit for score, hit in tally.certain if score >= threshold]
    all_of = sum(tally.truths.values())
    precision = sum(kept) / len(kept) if kept else float("nan")
    return precision, sum(kept) / all_of if all_of else float("nan")


def reliability(certain: Sequence[tuple[float, bool]]) -> list[tuple[float, float, int]]:
    """Return (mean score, share right, number) of ten bins of scores; empty bins left out."""
    if not certain:
        return []
    scores = np.array([score for score, _ in certain])
    hits = np.array([hit for _, hit in certain], np.float64)
    bins = np.minimum((scores * BINS).astype(int), BINS - 1)
    return [
        (float(scores[bins == k].mean()), float(hits[bins == k].mean()), int((bins == k).sum()))
        for k in range(BINS)
        if (bins == k).any()
    ]


def calibration_error(certain: Sequence[tuple[float, bool]]) -> float:
    """Return the expected calibration error over ten bins (Guo et al. 2017)."""
    rows = reliability(certain)
    total = sum(count for *_, count in rows)
    if not total:
        return float("nan")
    return sum(abs(score - share) * count for score, share, count in rows) / total
