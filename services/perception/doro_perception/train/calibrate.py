"""Fits what is fitted after the training: temperatures, the score's scale, the material prior.

``python -m doro_perception.train.calibrate --models DIR --data DIR --calibration DIR`` writes
``calibration.json`` into the folder of the models. Rooms of the calibration are in neither the
training nor the test. Without ``--data`` the material prior of the file there stays.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from doro_perception.backend import intersection_over_union
from doro_perception.captioner import (
    CALIBRATION,
    Calibration,
    Candidates,
    Captioner,
    Read,
    read_calibration,
)
from doro_perception.classes import CLASSES, MATERIALS
from doro_perception.settings import PerceptionSettings
from doro_perception.train.shards import Frame, Shards

IOU = 0.5
PRIOR_COUNT = 1.0
TEMPERATURES = np.exp(np.linspace(np.log(0.5), np.log(4.0), 43))
DETECTOR_SHARES = (0.0, 0.1, 0.2, 0.3, 0.45, 0.6, 0.8, 1.0)
"""At most 1: with more the proposer, which sees a whole rendered room, outvotes the crop nets."""
CLASS_SHARES = (0.3, 0.4, 0.5, 0.6, 0.7, 0.8)
PRIOR_SHARES = (0.0, 0.25, 0.5, 0.75, 1.0, 1.5)
NEWTON_STEPS = 60
Floats = NDArray[np.float64]


def material_prior(shards: Shards) -> tuple[tuple[float, ...], ...]:
    """Return how often a thing of each class is of each material in the training frames.

    Frames dressed anew or with varied furniture have materials at random and say nothing of that:
    where there are others, only those count.
    """
    counts = np.full((len(CLASSES), len(MATERIALS)), PRIOR_COUNT / len(MATERIALS))
    plain = [frame for frame in shards.frames if frame.plain and not frame.varied]
    for frame in plain or shards.frames:
        known = (frame.kind >= 0) & (frame.kind < len(CLASSES)) & (frame.material >= 0)
        np.add.at(counts, (frame.kind[known], frame.material[known]), 1.0)
    share = counts / counts.sum(axis=1, keepdims=True)
    return tuple(tuple(round(float(v), 4) for v in row) for row in share)


def temperature(logits: Floats, labels: NDArray[np.int64]) -> float:
    """Return the divisor of the logits of least cross entropy (Guo et al. 2017)."""
    known = labels >= 0
    if not known.any():
        return 1.0
    losses = []
    for value in TEMPERATURES:
        scaled = logits[known] / value
        shifted = scaled - scaled.max(axis=1, keepdims=True)
        picked = shifted[np.arange(known.sum()), labels[known]]
        losses.append(float((np.log(np.exp(shifted).sum(axis=1)) - picked).mean()))
    return round(float(TEMPERATURES[int(np.argmin(losses))]), 3)


def platt(raw: Floats, right: NDArray[np.bool_]) -> tuple[float, float]:
    """Return scale and offset of the logit of least cross entropy (Platt 1999), by Newton."""
    clipped = np.clip(raw, 1e-4, 1 - 1e-4)
    x = np.column_stack([np.log(clipped / (1 - clipped)), np.ones(len(raw))])
    weight = np.array([1.0, 0.0])
    for _ in range(NEWTON_STEPS):
        p = 1 / (1 + np.exp(-np.clip(x @ weight, -30, 30)))
        gradient = x.T @ (p - right) + 1e-3 * (weight - [1.0, 0.0])
        bend = (x * (p * (1 - p))[:, None]).T @ x + 1e-3 * np.eye(2)
        weight = weight - np.linalg.solve(bend, gradient)
    return round(float(weight[0]), 4), round(float(weight[1]), 4)


class Seen(msgspec.Struct, frozen=True):
    """The proposals of a frame, what the crop net says of them, and what they are of.

    ``truth``: class of the truth at a proposal's place, -1: none, -2: one that is ignored.
    """

    found: Candidates
    read: Read
    truth: NDArray[np.int64]


def look(captioner: Captioner, frames: list[Frame]) -> list[Seen]:
    """Return what the captioner sees of frames, before any fusion."""
    rows = []
    for frame in frames:
        image = frame.image()
        found = captioner.propose(image)
        if not len(found.boxes):
            continue
        named = (frame.kind >= 0) & (frame.kind < len(CLASSES))
        ignored = frame.ignore | ~named
        truth = np.full(len(found.boxes), -1, np.int64)
        for k, box in enumerate(found.boxes):
            overlaps = intersection_over_union(box, frame.box.astype(np.float64))
            best = int(overlaps.argmax()) if len(overlaps) else -1
            if best >= 0 and overlaps[best] >= IOU:
                truth[k] = -2 if ignored[best] else int(frame.kind[best])
        rows.append(Seen(found, captioner.read(image, found.boxes), truth))
    return rows


def attribute_logits(captioner: Captioner, frames: list[Frame]) -> list[tuple[Floats, Any]]:
    """Return (log probabilities, labels) of class, colour and material of the truth's boxes."""
    parts: tuple[list[Any], ...] = ([], [], [])
    labels: tuple[list[Any], ...] = ([], [], [])
    for frame in frames:
        good = ~frame.ignore & (frame.kind >= 0)
        if not good.any():
            continue
        read = captioner.read(frame.image(), frame.box[good].astype(np.float64))
        pairs: tuple[tuple[Floats, NDArray[Any]], ...] = (
            (read.kinds, frame.kind),
            (read.colors, frame.colour),
            (read.materials, frame.material),
        )
        for k, (value, label) in enumerate(pairs):
            parts[k].append(np.log(np.maximum(value, 1e-9)))
            labels[k].append(label[good].astype(np.int64))
    return [
        (np.concatenate(part), np.concatenate(label))
        for part, label in zip(parts, labels, strict=True)
    ]


def fit(captioner: Captioner, frames: list[Frame], start: Calibration) -> Calibration:
    """Return the calibration that suits the frames."""
    kinds, colors, materials = attribute_logits(captioner, frames)
    use = msgspec.structs.replace(
        start,
        temperature=temperature(*kinds),
        color_temperature=temperature(*colors),
        material_temperature=temperature(*materials),
    )
    # Rooms dressed anew are of any material: of the prior only plain frames tell.
    plain = [frame for frame in frames if frame.plain] or frames
    known, _, made_of = attribute_logits(captioner, plain)
    use = msgspec.structs.replace(use, prior_share=_prior_share(use, known, made_of))
    captioner.calibration = use
    seen = look(captioner, frames)
    best: tuple[float, Calibration, Any] | None = None
    for detector_share in DETECTOR_SHARES:
        for class_share in CLASS_SHARES:
            tried = msgspec.structs.replace(
                use, detector_share=detector_share, class_share=class_share
            )
            raw, right = _scored(captioner, seen, tried)
            area = _area(raw, right)
            if best is None or area > best[0]:
                best = (area, tried, (raw, right))
    assert best is not None
    scale, offset = platt(*best[2])
    return msgspec.structs.replace(best[1], scale=scale, offset=offset)


def _prior_share(use: Calibration, kinds: Any, materials: Any) -> float:
    """Return the exponent of the prior of least cross entropy, of boxes of a known class."""
    prior = np.asarray(use.material_prior)
    known = (materials[1] >= 0) & (kinds[1] >= 0) & (kinds[1] < len(CLASSES))
    share = np.exp(kinds[0][:, : len(CLASSES)] / use.temperature)
    share /= share.sum(axis=1, keepdims=True)
    image = np.exp(materials[0] / use.material_temperature)
    losses = []
    for power in PRIOR_SHARES:
        mixed = image * np.maximum(share @ prior, 1e-3) ** power
        right = mixed[np.arange(len(mixed)), np.maximum(materials[1], 0)] / mixed.sum(axis=1)
        losses.append(float(-np.log(right[known]).mean()))
    return PRIOR_SHARES[int(np.argmin(losses))]


def _scored(captioner: Captioner, seen: list[Seen], use: Calibration) -> tuple[Floats, Any]:
    """Return raw scores and whether the best class is right, ignored places left out."""
    captioner.calibration = msgspec.structs.replace(use, scale=1.0, offset=0.0)
    raws, rights = [], []
    for item in seen:
        kinds, raw = captioner.fuse(item.found, item.read)
        asked = item.truth != -2
        best = kinds[:, : len(CLASSES)].argmax(axis=1)
        raws.append(raw[asked])
        rights.append((best == item.truth)[asked])
    return np.concatenate(raws), np.concatenate(rights)


def _area(raw: Floats, right: NDArray[np.bool_]) -> float:
    """Return the area under precision over the number of right ones, all classes in one."""
    ordered = right[np.argsort(-raw, kind="stable")]
    hits = np.cumsum(ordered)
    precision = hits / np.arange(1, len(hits) + 1)
    return float((precision * ordered).sum())


def prior_of(path: Path, data: Path | None) -> tuple[tuple[float, ...], ...]:
    """Return the material prior of training shards; without them that of a calibration file.

    Raises:
        Refused: there are no shards, and the file is missing or damaged.
    """
    return read_calibration(path).material_prior if data is None else material_prior(Shards(data))


def main() -> None:
    """Fit and write the calibration."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--models", type=Path, required=True)
    parser.add_argument("--data", type=Path, help="training shards, for the prior")
    parser.add_argument("--calibration", type=Path, required=True)
    arguments = parser.parse_args()
    path = arguments.models / CALIBRATION
    start = Calibration(material_prior=prior_of(path, arguments.data))
    path.write_bytes(msgspec.json.format(msgspec.json.encode(start), indent=1) + b"\n")
    captioner = Captioner(PerceptionSettings(captioner=str(arguments.models)))
    frames = Shards(arguments.calibration, "calibration-*.npz").frames
    found = fit(captioner, frames, start)
    path.write_bytes(msgspec.json.format(msgspec.json.encode(found), indent=1) + b"\n")
    shown = {k: v for k, v in msgspec.to_builtins(found).items() if k != "material_prior"}
    print(f"{len(frames)} frames: {shown}")


if __name__ == "__main__":
    main()
