"""The crop net: what one box shows, as class, colour and material probabilities."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn import functional

from doro_perception.classes import CLASSES, COLOURS, MATERIALS
from doro_perception.crop import SIDE_PX, cut_out
from doro_perception.train.backbone import CHANNELS, COCO, MobileNetV2, read_weights, scaled
from doro_perception.train.efficientnet import (
    HEAD_CHANNELS,
    LEVELS,
    EfficientNetLite,
    packaged_lite,
    read_lite,
)
from doro_perception.train.shards import NOBODY, Frame, Image, Rng, photometric, resized

UNNAMED, NOTHING = len(CLASSES), len(CLASSES) + 1
KINDS = len(CLASSES) + 2
PER_FRAME, MIN_SIDE_PX = 6, 4
BOX_JITTER, MINED_JITTER = 0.07, 0.02
MINED_SHARE = 0.5
"""How often a box is one that the proposer found, where it found one."""
PARTLY_SIDE_SHARE = 8 / 300
"""Of the image's side: smaller things that are hidden for the most part are not taught."""
STRENGTH, STRANGE_SHARE, COARSE_SHARE, COVERED_SHARE = 0.7, 0.15, 0.25, 0.2


class CropNet(nn.Module):  # type: ignore[misc]
    """Crops (n, 3, 96, 96) in -1..1 to logits of class, colour and material.

    Args:
        backbone: gives several levels of features of images.
        width: channels of all its levels; hidden: of the layer between them and the answers.
    """

    def __init__(self, backbone: nn.Module, width: int, hidden: int) -> None:
        super().__init__()
        self.backbone = backbone
        self.norm, self.drop = nn.BatchNorm1d(width), nn.Dropout(0.2)
        self.hidden = nn.Linear(width, hidden)
        # Colour needs pixels, not shapes: the middle of the crop through 1 x 1 convolutions.
        self.pixels = nn.Sequential(nn.Conv2d(3, 32, 1), nn.ReLU(), nn.Conv2d(32, 48, 1), nn.ReLU())
        self.kind = nn.Linear(hidden, KINDS)
        self.colour = nn.Linear(hidden + 96, len(COLOURS))
        self.material = nn.Linear(hidden, len(MATERIALS))

    def forward(self, x: Tensor, restyled: Tensor | None = None) -> tuple[Tensor, Tensor, Tensor]:
        levels = self.backbone(x, restyled)
        pooled = torch.cat([level.float().mean((2, 3)) for level in levels], 1)
        hidden = functional.relu(self.hidden(self.drop(self.norm(pooled))))
        quarter = SIDE_PX // 4
        inner = self.pixels(x[:, :, quarter : 3 * quarter : 2, quarter : 3 * quarter : 2]).float()
        seen = torch.cat([inner.mean((2, 3)), inner.amax((2, 3))], 1)
        return (
            self.kind(hidden),
            self.colour(torch.cat([hidden, seen], 1)),
            self.material(hidden),
        )


def boxes_net() -> CropNet:
    """Return a net that begins from COCO's boxes: it knows small and hidden things."""
    return CropNet(MobileNetV2(read_weights(COCO)), sum(CHANNELS), 256)


def names_net() -> CropNet:
    """Return a net that begins from ImageNet's names: it learns shapes five times as fast."""
    backbone = EfficientNetLite(read_lite(packaged_lite()))
    return CropNet(backbone, sum(LEVELS.values()) + HEAD_CHANNELS, 320)


class Exported(nn.Module):  # type: ignore[misc]
    """What the ONNX file holds: uint8 crops (n, 96, 96, 3) to three logits each.

    Of several nets the mean; every second one sees the mirror image, which costs nothing more.
    """

    def __init__(self, models: list[CropNet]) -> None:
        super().__init__()
        self.models = nn.ModuleList(models)

    def forward(self, crops: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        x = scaled(crops)
        found = [
            model(x if number % 2 == 0 else x.flip(3)) for number, model in enumerate(self.models)
        ]
        kind, colour, material = (torch.stack(items).mean(0) for items in zip(*found, strict=True))
        return kind, colour, material


def batch(
    frames: list[Frame],
    shares: NDArray[np.float64],
    odds: NDArray[np.float64],
    size: int,
    rng: Rng,
) -> tuple[Any, ...]:
    """Return crops uint8 (n, 96, 96, 3), (class, colour, material) int64 (n, 3), -1 unknown, and
    which are of plain frames, bool (n,).

    Args:
        shares: how likely each frame is taken.
        odds: how likely a box of each class is taken, (KINDS - 1,).
    """
    crops: list[Image] = []
    labels: list[tuple[int, int, int]] = []
    plain: list[bool] = []
    while len(crops) < size:
        frame = frames[int(rng.choice(len(frames), p=shares))]
        image, scale = frame.image(), 1.0
        if rng.random() < 0.4:
            side = int(rng.choice([300, 300, 320]))
            scale = side / image.shape[0]
            image = resized(image, side, rng)
        boxes = frame.box * scale
        good = _taught(frame)
        if len(good):
            p = odds[frame.kind[good]]
            count = min(PER_FRAME, len(good))
            for k in rng.choice(good, count, replace=False, p=p / p.sum()):
                crop = _jittered(image, *_box_of(frame, int(k), scale, rng), rng, frame.strength)
                if crop is None:
                    continue
                colour = int(frame.colour[k])
                if rng.random() < STRANGE_SHARE * frame.strength:
                    crop, colour = _strange(crop, rng), -1
                crops.append(crop)
                labels.append((int(frame.kind[k]), colour, int(frame.material[k])))
        wrong = frame.mined[frame.mined_of == NOBODY] * scale
        for _ in range(2):
            empty = _background(image, boxes, wrong, rng, frame.strength)
            if empty is not None:
                crops.append(empty)
                labels.append((NOTHING, -1, -1))
        plain += [frame.plain] * (len(crops) - len(plain))
    return (
        torch.from_numpy(np.stack(crops[:size])),
        torch.tensor(labels[:size]),
        torch.tensor(plain[:size]),
    )


def _taught(frame: Frame) -> NDArray[np.int64]:
    """Return the rows of the things to learn: also what is hidden for the most part, where it is
    not tiny. The proposer finds such things, and nobody should be sure of them.
    """
    least = PARTLY_SIDE_SHARE * frame.image().shape[0]
    large = (frame.box[:, 2:] - frame.box[:, :2]).min(axis=1, initial=np.inf) >= least
    return np.flatnonzero((frame.kind >= 0) & (~frame.ignore | large))


def _box_of(frame: Frame, k: int, scale: float, rng: Rng) -> tuple[NDArray[np.float32], float]:
    """Return a box of a thing, the truth's or a found one, and how much to move its edges."""
    found = np.flatnonzero(frame.mined_of == k)
    if len(found) and rng.random() < MINED_SHARE:
        return frame.mined[rng.choice(found)] * scale, MINED_JITTER
    return frame.box[k] * scale, BOX_JITTER


def _jittered(
    image: Image, box: NDArray[np.float32], jitter: float, rng: Rng, strength: float
) -> Image | None:
    size = np.tile(box[2:] - box[:2], 2)
    moved = box + rng.normal(0, jitter, 4) * size
    if (moved[2:] - moved[:2]).min() < MIN_SIDE_PX:
        return None
    crop = cut_out(image, moved)
    if rng.random() < 0.5:
        crop = np.ascontiguousarray(crop[:, ::-1])
    if rng.random() < COARSE_SHARE * strength:
        crop = _coarse(crop, rng)
    if rng.random() < COVERED_SHARE * strength:
        crop = _covered(crop, rng)
    return photometric(crop, rng, strength=STRENGTH * strength)


def _strange(crop: Image, rng: Rng) -> Image:
    """Return the crop in other colours: what a thing is seldom hangs on them."""
    mixed = crop[..., rng.permutation(3)]
    if rng.random() < 0.3:
        mixed = np.repeat(mixed.mean(axis=2, keepdims=True), 3, axis=2).astype(np.uint8)
    return np.ascontiguousarray(mixed)


def _coarse(crop: Image, rng: Rng) -> Image:
    """Return the crop as a far camera gives it."""
    side = int(rng.integers(18, 64))
    small = cv2.resize(crop, (side, side), interpolation=cv2.INTER_AREA)
    return np.asarray(cv2.resize(small, (SIDE_PX, SIDE_PX)), np.uint8)


def _covered(crop: Image, rng: Rng) -> Image:
    """Return the crop with a part of it hidden."""
    size = rng.integers(SIDE_PX // 8, SIDE_PX // 2, 2)
    left, top = (int(rng.integers(0, SIDE_PX - n)) for n in size)
    covered = crop.copy()
    covered[top : top + size[1], left : left + size[0]] = rng.integers(0, 256, 3)
    return covered


def _background(
    image: Image,
    boxes: NDArray[np.float32],
    wrong: NDArray[np.float32],
    rng: Rng,
    strength: float,
) -> Image | None:
    """Return a crop that shows no thing in its middle: one that the proposer took for a thing, a
    random place, or a badly placed box.
    """
    if len(wrong) and rng.random() < MINED_SHARE:
        return _jittered(image, wrong[rng.integers(len(wrong))], MINED_JITTER, rng, strength)
    whole = image.shape[0]
    if len(boxes) and rng.random() < 0.4:
        box = boxes[int(rng.integers(len(boxes)))]
        size = box[2:] - box[:2]
        scale = rng.uniform(0.3, 1.6)
        middle = (box[:2] + box[2:]) / 2 + rng.choice([-1.0, 1.0], 2) * rng.uniform(
            0.4, 1.0, 2
        ) * size
        size = np.maximum(size * scale, 8)
    else:
        size = np.exp(rng.uniform(np.log(10), np.log(whole * 0.4))) * rng.uniform(0.6, 1.6, 2)
        middle = rng.uniform(0, whole, 2)
    box = np.concatenate([middle - size / 2, middle + size / 2])
    inside = np.clip(box, 0, whole)
    if (inside[2:] - inside[:2]).prod() < 0.6 * size.prod():
        return None
    low, high = np.maximum(box[:2], boxes[:, :2]), np.minimum(box[2:], boxes[:, 2:])
    common = np.clip(high - low, 0, None).prod(axis=1)
    union = size.prod() + (boxes[:, 2:] - boxes[:, :2]).prod(axis=1) - common
    if len(boxes) and (common / union).max() > 0.25:
        return None
    return photometric(cut_out(image, box), rng, strength=0.5 * strength)
