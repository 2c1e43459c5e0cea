"""The box proposer: a feature pyramid with two centre heads (TTFNet, Liu et al. 2020).

Things below ``SPLIT_PX`` are found at stride 4, furniture at stride 8. Each head gives a heat
map per class (the last class: a thing without a name) and the four distances to the edges.
"""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from torch.nn import functional

from doro_perception.classes import CLASSES
from doro_perception.train.backbone import CHANNELS, MobileNetV2, Weights, scaled
from doro_perception.train.shards import Frame, Rng, photometric, resized

SIDE_PX = 512
STRIDES = (4, 8)
KINDS = len(CLASSES) + 1
SPLIT_PX = (38.0, 56.0)
"""Square root of the area: below the second, small; above the first, large; between, both."""
SPREAD = 0.54
START_LOGIT = -4.6
BOX_SCALE = 4.0
CANDIDATES = 60


def pointwise(inputs: int, outputs: int) -> nn.Sequential:
    return nn.Sequential(
        nn.Conv2d(inputs, outputs, 1, bias=False), nn.BatchNorm2d(outputs), nn.ReLU(inplace=True)
    )


def separable(inputs: int, outputs: int, side: int = 3) -> nn.Sequential:
    return nn.Sequential(
        nn.Conv2d(inputs, inputs, side, padding=side // 2, groups=inputs, bias=False),
        nn.BatchNorm2d(inputs),
        *pointwise(inputs, outputs),
    )


class Refined(nn.Module):  # type: ignore[misc]
    """Two residual separable convolutions; untrained they give back what they get (from ReLUs)."""

    def __init__(self, channels: int, side: int = 3) -> None:
        super().__init__()
        self.steps = nn.ModuleList(
            nn.Sequential(
                nn.Conv2d(channels, channels, side, padding=side // 2, groups=channels, bias=False),
                nn.BatchNorm2d(channels),
                nn.ReLU(inplace=True),
                nn.Conv2d(channels, channels, 1, bias=False),
                nn.BatchNorm2d(channels),
            )
            for _ in range(2)
        )
        for step in self.steps:
            step[-1].weight.data.zero_()

    def forward(self, x: Tensor) -> Tensor:
        for step in self.steps:
            x = functional.relu(x + step(x))
        return x


class Head(nn.Module):  # type: ignore[misc]
    """Heat logits (n, KINDS, h, w) and distances to left, top, right, bottom in strides."""

    def __init__(self, channels: int) -> None:
        super().__init__()
        self.heat = nn.Sequential(separable(channels, channels), nn.Conv2d(channels, KINDS, 1))
        self.edges = nn.Sequential(separable(channels, channels), nn.Conv2d(channels, 4, 1))
        self.heat[-1].bias.data.fill_(START_LOGIT)
        self.heat[-1].weight.data *= 0.3
        self.edges[-1].bias.data.fill_(1.0)

    def forward(self, x: Tensor) -> tuple[Tensor, Tensor]:
        return self.heat(x), functional.softplus(self.edges(x).float()) * BOX_SCALE


class Proposer(nn.Module):  # type: ignore[misc]
    """Two heads over the pyramid; input (n, 3, 512, 512) in -1..1."""

    def __init__(self, weights: Weights) -> None:
        super().__init__()
        self.backbone = MobileNetV2(weights)
        c2, c3, c4, c5 = CHANNELS
        self.side5, self.side4 = pointwise(c5, 128), pointwise(c4, 128)
        self.side3, self.side2 = pointwise(c3, 96), pointwise(c2, 64)
        self.context = separable(128, 128, 5)
        self.down4, self.down3, self.down2 = (
            separable(128, 96),
            separable(96, 96),
            separable(64, 64),
        )
        self.narrow = pointwise(96, 64)
        self.deep5, self.deep4 = Refined(128, 5), Refined(96, 5)
        self.deep3, self.deep2 = Refined(96, 5), Refined(64)
        self.small, self.large = Head(64), Head(96)

    def forward(self, x: Tensor, restyled: Tensor | None = None) -> list[tuple[Tensor, Tensor]]:
        c2, c3, c4, c5 = self.backbone(x, restyled)
        p5 = self.side5(c5)
        p5 = self.deep5(p5 + self.context(p5))
        p4 = self.deep4(self.down4(_doubled(p5) + self.side4(c4)))
        p3 = self.deep3(self.down3(_doubled(p4) + self.side3(c3)))
        p2 = self.deep2(self.down2(_doubled(self.narrow(p3)) + self.side2(c2)))
        return [self.small(p2), self.large(p3)]


def _doubled(x: Tensor) -> Tensor:
    return functional.interpolate(x, scale_factor=2, mode="nearest")


class Exported(nn.Module):  # type: ignore[misc]
    """What the ONNX file holds: uint8 image (1, 512, 512, 3) to candidate boxes.

    Outputs: boxes (1, 2 K, 4) edges in pixels of the input, scores (1, 2 K) of the class whose
    peak it is, kinds (1, 2 K, KINDS) what the heat says of every class at that place.
    """

    def __init__(self, model: Proposer, candidates: int = CANDIDATES) -> None:
        super().__init__()
        self.model, self.candidates = model, candidates

    def forward(self, image: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        found = [
            self._peaks(heat, edges, stride)
            for (heat, edges), stride in zip(self.model(scaled(image)), STRIDES, strict=True)
        ]
        boxes, scores, kinds = (torch.cat(items, 1) for items in zip(*found, strict=True))
        return boxes, scores, kinds

    def _peaks(self, heat: Tensor, edges: Tensor, stride: int) -> tuple[Tensor, Tensor, Tensor]:
        heat = torch.sigmoid(heat.float())
        around = functional.max_pool2d(heat, 3, 1, 1)
        high, wide = heat.shape[-2:]
        peaks = (heat * (around == heat).float()).flatten(1)
        scores, index = torch.topk(peaks, self.candidates)
        place = index % (high * wide)
        # Peaks of two classes for one thing may lie in neighbouring cells.
        kinds = around.flatten(2).gather(2, place[:, None].expand(-1, KINDS, -1)).transpose(1, 2)
        y, x = (place // wide).float() + 0.5, (place % wide).float() + 0.5
        edge = edges.flatten(2).gather(2, place[:, None].expand(-1, 4, -1))
        boxes = torch.stack(
            [x - edge[:, 0], y - edge[:, 1], x + edge[:, 2], y + edge[:, 3]], dim=-1
        )
        return boxes * stride, scores, kinds


def sample(
    frame: Frame, rng: Rng, side_px: int = SIDE_PX
) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
    """Return an augmented image and rows of (xmin, ymin, xmax, ymax, kind, ignore).

    A smaller side is a smaller window on the same scales, not a smaller picture.
    """
    image = frame.image()
    whole = image.shape[0]
    crop, x0, y0 = int(whole * side_px / SIDE_PX), 0, 0
    if rng.random() < 0.5:
        crop = int(crop * rng.uniform(0.45, 1.0))
    if crop < whole:
        x0, y0 = rng.integers(0, whole - crop + 1, 2).tolist()
        good = np.flatnonzero(~frame.ignore & (frame.kind >= 0))
        if len(good) and rng.random() < 0.6:
            box = frame.box[rng.choice(good)]
            middle = (box[:2] + box[2:]) / 2 - crop * rng.uniform(0.2, 0.8, 2)
            x0, y0 = np.clip(middle, 0, whole - crop).astype(int).tolist()
    part = image[y0 : y0 + crop, x0 : x0 + crop]
    if rng.random() < 0.25:  # the simulator's own frames have 300 px and no smooth edges
        part = resized(np.ascontiguousarray(part), min(crop, 300), rng)
    part = resized(np.ascontiguousarray(part), side_px)
    boxes = (frame.box - [x0, y0, x0, y0]) * (side_px / crop)
    area = (boxes[:, 2:] - boxes[:, :2]).prod(axis=1)
    cut = np.clip(boxes, 0, side_px)
    size = cut[:, 2:] - cut[:, :2]
    ignore = frame.ignore | (size.prod(axis=1) < 0.35 * area) | (size.min(axis=1) < 4)
    rows = np.column_stack([cut, frame.kind, ignore]).astype(np.float32)[size.min(axis=1) >= 2]
    if rng.random() < 0.5:
        part = np.ascontiguousarray(part[:, ::-1])
        rows[:, [0, 2]] = side_px - rows[:, [2, 0]]
    return photometric(part, rng, frame.strength), rows


def targets(
    rows: list[NDArray[np.float32]], stride: int, side_px: int = SIDE_PX
) -> tuple[Tensor, ...]:
    """Return what each cell of the heat may cost (n, KINDS, h, w), the flat places of the
    centres, edges (n, 4, h, w) in pixels and their weights (n, h, w).
    """
    side = side_px // stride
    heat = np.zeros((len(rows), KINDS, side, side), np.float32)
    mask = np.ones((len(rows), 1, side, side), np.float32)
    edges = np.zeros((len(rows), 4, side, side), np.float32)
    weight = np.zeros((len(rows), side, side), np.float32)
    for k, boxes in enumerate(rows):
        _paint(boxes, stride, (heat[k], mask[k, 0], edges[k], weight[k]))
    centres = np.flatnonzero(heat == 1)
    cost = (1 - heat) ** 2
    cost *= cost * mask
    return tuple(torch.from_numpy(item) for item in (cost, centres, edges, weight))


def _paint(boxes: NDArray[np.float32], stride: int, out: tuple[Any, ...]) -> None:
    heat, mask, edges, weight = out
    side = heat.shape[-1]
    size = np.sqrt((boxes[:, 2:4] - boxes[:, :2]).prod(axis=1))
    mine = size < SPLIT_PX[1] if stride == STRIDES[0] else size > SPLIT_PX[0]
    ignored = (boxes[:, 5] > 0) | (boxes[:, 4] < 0)
    for x0, y0, x1, y1 in boxes[ignored, :4]:
        if (x1 - x0) * (y1 - y0) < 0.3 * SIDE_PX**2:
            low, high = (int(y0 // stride), int(x0 // stride)), (y1 / stride, x1 / stride)
            mask[low[0] : int(np.ceil(high[0])), low[1] : int(np.ceil(high[1]))] = 0
    rows, columns = np.mgrid[0:side, 0:side].astype(np.float32)
    chosen = np.flatnonzero(mine & ~ignored)
    for k in chosen[np.argsort(-size[chosen])]:
        x0, y0, x1, y1, kind, _ = boxes[k].tolist()
        wide, high = (x1 - x0) / stride, (y1 - y0) / stride
        cx = min(side - 1, int((x0 + x1) / 2 / stride))
        cy = min(side - 1, int((y0 + y1) / 2 / stride))
        reach_x, reach_y = int(max(1, SPREAD * wide / 2)), int(max(1, SPREAD * high / 2))
        u = slice(max(0, cx - reach_x), min(side, cx + reach_x + 1))
        v = slice(max(0, cy - reach_y), min(side, cy + reach_y + 1))
        bend_x, bend_y = max(SPREAD * wide / 6, 0.45), max(SPREAD * high / 6, 0.45)
        bell = np.exp(
            -((columns[v, u] - cx) ** 2) / (2 * bend_x**2)
            - (rows[v, u] - cy) ** 2 / (2 * bend_y**2)
        )
        heat[int(kind), v, u] = np.maximum(heat[int(kind), v, u], bell)
        heat[int(kind), cy, cx] = 1
        mask[v, u] = 1
        here = bell > 0.05
        bell = np.where(here, bell, 0)
        share = bell * np.log(max(2.0, wide * high) + 1) / max(float(bell.sum()), 1e-6)
        weight[v, u] = np.where(here, share, weight[v, u])
        for number, value in enumerate((x0, y0, x1, y1)):
            edges[number, v, u] = np.where(here, value, edges[number, v, u])


def losses(
    heat: Tensor, edges: Tensor, target: tuple[Tensor, ...], stride: int
) -> tuple[Tensor, Tensor]:
    """Return the Gaussian focal loss and the weighted GIoU loss of one head."""
    cost, centres, box, weight = target
    logit = heat.float().contiguous()
    p = torch.sigmoid(logit)
    miss = (functional.softplus(logit) * p * p * cost).sum()
    peaks = logit.flatten()[centres]
    hit = (functional.softplus(-peaks) * torch.sigmoid(-peaks) ** 2).sum()
    side = heat.shape[-1]
    at = torch.arange(side) + 0.5
    y, x = torch.meshgrid(at, at, indexing="ij")
    e = edges.float()
    have = [(x - e[:, 0]), (y - e[:, 1]), (x + e[:, 2]), (y + e[:, 3])]
    have = [item * stride for item in have]
    wide = (torch.minimum(have[2], box[:, 2]) - torch.maximum(have[0], box[:, 0])).clamp(min=0)
    high = (torch.minimum(have[3], box[:, 3]) - torch.maximum(have[1], box[:, 1])).clamp(min=0)
    common = wide * high
    union = (have[2] - have[0]) * (have[3] - have[1]) - common
    union = union + (box[:, 2] - box[:, 0]) * (box[:, 3] - box[:, 1])
    around = (torch.maximum(have[2], box[:, 2]) - torch.minimum(have[0], box[:, 0])) * (
        torch.maximum(have[3], box[:, 3]) - torch.minimum(have[1], box[:, 1])
    )
    giou = common / union.clamp(min=1e-3) - (around - union) / around.clamp(min=1e-3)
    boxes = ((1 - giou) * weight).sum() / weight.sum().clamp(min=1)
    return (hit + miss) / max(len(centres), 8), boxes


def batch(
    frames: list[Frame],
    odds: NDArray[np.float64],
    size: int,
    rng: Rng,
    side_px: int = SIDE_PX,
) -> tuple[Any, ...]:
    """Return images uint8 (n, side, side, 3), the targets of both heads, and which images are of
    plain frames, bool (n,).
    """
    chosen = rng.choice(len(frames), size, p=odds)
    pairs = [sample(frames[int(k)], rng, side_px) for k in chosen]
    plain = torch.tensor([frames[int(k)].plain for k in chosen])
    images = torch.from_numpy(np.stack([image for image, _ in pairs]))
    rows = [row for _, row in pairs]
    return images, [targets(rows, stride, side_px) for stride in STRIDES], plain


cv2.setNumThreads(1)
