"""MobileNetV2 with the weights of the COCO SSDLite, read by name from its ONNX file.

Batch norms are folded into the convolutions, padding is TensorFlow's SAME, so that the
activations equal those of the file (to 4e-6).
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import onnx
import torch
from numpy.typing import NDArray
from onnx import numpy_helper
from torch import Tensor, nn
from torch.nn import functional

COCO = Path(__file__).resolve().parents[1] / "models" / "coco_ssdlite" / "coco_ssd_lite.onnx"
Weights = dict[str, tuple[NDArray[np.float32], NDArray[np.float32]]]
STRIDES = {1: 2, 3: 2, 6: 2, 13: 2}
BLOCKS = 17
TINY_PX = 4
CHANNELS = (24, 32, 96, 320)
"""Of the four levels, at strides 4, 8, 16 and 32."""


def read_weights(path: Path) -> Weights:
    """Return (weight, bias) of each convolution by layer name, what follows it folded in."""
    graph = onnx.load(str(path)).graph
    values = {item.name: numpy_helper.to_array(item) for item in graph.initializer}
    # A halved file (see halve.py) casts its constants back.
    for node in graph.node:
        if node.op_type == "Cast" and node.input[0] in values:
            values[node.output[0]] = values[node.input[0]].astype(np.float32)
    users: dict[str, list[Any]] = {}
    for node in graph.node:
        for name in node.input:
            users.setdefault(name, []).append(node)
    found: Weights = {}
    for node in graph.node:
        if node.op_type != "Conv":
            continue
        weight = values[node.input[1]].astype(np.float32)
        bias = np.zeros(len(weight), np.float32)
        if len(node.input) > 2:
            bias = values[node.input[2]].astype(np.float32)
        found[_layer(node)] = _folded(node.output[0], weight, bias, users, values)
    return found


def _layer(node: Any) -> str:
    name = str(node.input[1])
    if not name.startswith(("FeatureE", "BoxP")) or "const_fold" in name:
        name = str(node.name)
    for word in (
        "FeatureExtractor/MobilenetV2/",
        "/Conv2D/merged_input:0",
        "/depthwise_weights_fused_bn",
        "/weights:0",
    ):
        name = name.replace(word, "")
    return name.removesuffix("/depthwise") if name.endswith("depthwise/depthwise") else name


def _folded(
    output: str,
    weight: NDArray[np.float32],
    bias: NDArray[np.float32],
    users: dict[str, list[Any]],
    values: dict[str, Any],
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Follow the output of a convolution through what is linear and fold that in."""
    while len(users.get(output, [])) == 1:
        node = users[output][0]
        constant = next((values[x] for x in node.input if x != output and x in values), None)
        if node.op_type == "Mul" and constant is not None:
            scale = constant.reshape(-1)
            weight, bias = weight * scale[:, None, None, None], bias * scale
        elif node.op_type == "Add" and constant is not None:
            bias = bias + constant.reshape(-1)
        elif node.op_type == "BatchNormalization":
            gain, offset, mean, variance = (values[name] for name in node.input[1:5])
            epsilon = next((a.f for a in node.attribute if a.name == "epsilon"), 1e-5)
            scale = gain / np.sqrt(variance + epsilon)
            weight, bias = weight * scale[:, None, None, None], (bias - mean) * scale + offset
        elif node.op_type not in ("Sum", "Transpose", "Squeeze", "Unsqueeze", "Identity"):
            break
        output = node.output[0]
    return weight.astype(np.float32), bias.astype(np.float32)


class Conv(nn.Module):  # type: ignore[misc]
    """A convolution with bias and SAME padding, then ReLU6 where ``active``."""

    def __init__(
        self, values: tuple[NDArray[np.float32], NDArray[np.float32]], stride: int, *, active: bool
    ) -> None:
        super().__init__()
        weight, bias = values
        out, per_group, side, _ = weight.shape
        groups = out if per_group == 1 and side > 1 and out > 3 else 1
        self.conv = nn.Conv2d(per_group * groups, out, side, stride, groups=groups)
        self.conv.weight.data = torch.from_numpy(weight.copy())
        self.conv.bias.data = torch.from_numpy(bias.copy())
        self.side, self.stride, self.active = side, stride, active

    def forward(self, x: Tensor) -> Tensor:
        conv = self.conv
        half = self.side // 2
        if self.side > 1 and self.stride == 1:
            y = self._level(x, half)
        elif self.side > 1:
            pad = [
                p
                for n in (x.shape[-1], x.shape[-2])
                for p in ((half - 1, half) if n % 2 == 0 else (half, half))
            ]
            y = self._precise(functional.pad(x, pad), self.stride, 0)
        else:
            y = conv(x)
        return functional.relu6(y, inplace=True) if self.active else y

    def _level(self, x: Tensor, half: int) -> Tensor:
        if self.side > 3 and x.shape[-1] <= TINY_PX and torch.is_grad_enabled():
            return self._as_matrices(x, half)
        if self.side > 3:
            return self._precise(x, 1, half)
        conv = self.conv
        return functional.conv2d(x, conv.weight, conv.bias, 1, half, 1, conv.groups)

    def _precise(self, x: Tensor, stride: int, padding: int) -> Tensor:
        """In bfloat16 the backward pass of a strided or wide depthwise convolution is slow."""
        conv = self.conv
        if conv.groups > 1 and torch.is_autocast_enabled("cpu") and torch.is_grad_enabled():
            with torch.autocast("cpu", enabled=False):
                y = functional.conv2d(
                    x.float(), conv.weight, conv.bias, stride, padding, 1, conv.groups
                )
                return y.bfloat16()
        return functional.conv2d(x, conv.weight, conv.bias, stride, padding, 1, conv.groups)

    def _as_matrices(self, x: Tensor, half: int) -> Tensor:
        """The same as a product with one matrix a channel: ten times as fast on tiny maps."""
        count, channels, high, wide = x.shape
        place = torch.arange(high)
        step = place[:, None] - place[None, :] + half
        known = (step >= 0) & (step < self.side)
        tap = step.clamp(0, self.side - 1)
        taps = (tap[:, None, :, None] * self.side + tap[None, :, None, :]).reshape(-1)
        used = (known[:, None, :, None] & known[None, :, None, :]).reshape(high * wide, -1)
        weight = self.conv.weight.reshape(channels, -1)[:, taps]
        matrices = (weight.reshape(channels, *used.shape) * used).to(x.dtype)
        y = torch.bmm(x.permute(1, 0, 2, 3).reshape(channels, count, -1), matrices)
        y = y.reshape(channels, count, high, wide).permute(1, 0, 2, 3)
        return y + self.conv.bias.to(x.dtype)[:, None, None]


def mixed_styles(x: Tensor, restyled: Tensor) -> Tensor:
    """Return features whose channel means and spreads are partly another sample's.

    MixStyle (Zhou et al., 2021): what a thing is does not depend on how its picture was made, and
    rendered training pictures are all made in one way.

    Args:
        x: (n, c, h, w); restyled: bool (n,), which samples.
    """
    y = x.float()
    mean, spread = y.mean((2, 3), keepdim=True), y.std((2, 3), keepdim=True) + 1e-5
    other = torch.randperm(len(x))
    kept = torch.distributions.Beta(0.2, 0.2).sample((len(x), 1, 1, 1))
    kept = torch.where(restyled[:, None, None, None], kept, torch.ones(()))
    new_mean = kept * mean + (1 - kept) * mean[other]
    new_spread = kept * spread + (1 - kept) * spread[other]
    result: Tensor = (y - mean) / spread * new_spread + new_mean
    return result.to(x.dtype)


class Block(nn.Module):  # type: ignore[misc]
    """An inverted residual block: its convolutions, and the input added where shapes allow."""

    def __init__(self, layers: list[Conv], stride: int) -> None:
        super().__init__()
        self.layers = nn.Sequential(*layers)
        self.residual = stride == 1 and layers[0].conv.in_channels == layers[-1].conv.out_channels

    def forward(self, x: Tensor) -> Tensor:
        y = self.layers(x)
        return x + y if self.residual else y


def block(weights: Weights, number: int, stride: int) -> Block:
    """Return one of MobileNetV2's blocks."""
    name = "expanded_conv" + (f"_{number}" if number else "")
    layers = [Conv(weights[f"{name}/expand"], 1, active=True)] if number else []
    layers.append(Conv(weights[f"{name}/depthwise"], stride, active=True))
    layers.append(Conv(weights[f"{name}/project"], 1, active=False))
    return Block(layers, stride)


class MobileNetV2(nn.Module):  # type: ignore[misc]
    """Returns the features at strides 4, 8, 16 and 32 of images (n, 3, h, w) in -1..1.

    The stem and the first three blocks are not trained: they are general and cost most time.
    """

    def __init__(self, weights: Weights) -> None:
        super().__init__()
        self.stem = Conv(weights["Conv"], 2, active=True)
        self.blocks = nn.ModuleList(
            block(weights, number, STRIDES.get(number, 1)) for number in range(BLOCKS)
        )

    def forward(
        self, x: Tensor, restyled: Tensor | None = None
    ) -> tuple[Tensor, Tensor, Tensor, Tensor]:
        """Return the four levels; ``restyled``, bool (n,): whose style is mixed with another's."""
        with torch.no_grad():
            x = self.stem(x)
            for block in self.blocks[:3]:
                x = block(x)
            x = x if restyled is None else mixed_styles(x, restyled)
        found = [x]
        for first, end in ((3, 6), (6, 13), (13, BLOCKS)):
            for block in self.blocks[first:end]:
                x = block(x)
            found.append(x)
        return found[0], found[1], found[2], found[3]


def scaled(images: Tensor) -> Tensor:
    """Return uint8 images (n, h, w, 3) as the backbone takes them, (n, 3, h, w) in -1..1."""
    return images.permute(0, 3, 1, 2).float() / 127.5 - 1.0
