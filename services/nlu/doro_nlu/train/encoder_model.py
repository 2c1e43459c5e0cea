"""The small encoder in torch: BERT layers from all-MiniLM-L6-v2 weights, and a label head."""

from __future__ import annotations

import json
import struct
from pathlib import Path

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional

HEAD_WIDTH = 32
_EPSILON = 1e-12


def read_safetensors(path: Path) -> dict[str, Tensor]:
    """Return the float32 tensors of a safetensors file by name."""
    content = path.read_bytes()
    (size,) = struct.unpack("<Q", content[:8])
    header = json.loads(content[8 : 8 + size])
    found = {}
    for name, item in header.items():
        if name != "__metadata__" and item["dtype"] == "F32":
            start, end = item["data_offsets"]
            values = np.frombuffer(content[8 + size + start : 8 + size + end], np.float32)
            found[name] = torch.from_numpy(values.reshape(item["shape"]).copy())
    return found


class Layer(nn.Module):  # type: ignore[misc, unused-ignore]
    """A BERT layer (post-norm)."""

    def __init__(self, hidden: int, dropout: float) -> None:
        super().__init__()
        self.heads = hidden // HEAD_WIDTH
        self.qkv = nn.Linear(hidden, 3 * hidden)
        self.out = nn.Linear(hidden, hidden)
        self.norm1 = nn.LayerNorm(hidden, _EPSILON)
        self.up = nn.Linear(hidden, 4 * hidden)
        self.down = nn.Linear(4 * hidden, hidden)
        self.norm2 = nn.LayerNorm(hidden, _EPSILON)
        self.dropout = nn.Dropout(dropout)

    def forward(self, x: Tensor, bias: Tensor) -> Tensor:
        """Return the layer's output (b, p, h); ``bias`` (b, 1, 1, p) is added to the scores."""
        b, p, h = x.shape
        q, k, v = self.qkv(x).view(b, p, 3, self.heads, HEAD_WIDTH).permute(2, 0, 3, 1, 4)
        mixed = functional.scaled_dot_product_attention(q, k, v, attn_mask=bias)
        x = self.norm1(x + self.dropout(self.out(mixed.transpose(1, 2).reshape(b, p, h))))
        result: Tensor = self.norm2(x + self.dropout(self.down(functional.gelu(self.up(x)))))
        return result


class Encoder(nn.Module):  # type: ignore[misc, unused-ignore]
    """Logits (b, p, labels) of piece ids (b, p) and mask (b, p).

    Args:
        n_pieces, n_positions, n_labels: sizes of the tables.
        layers, hidden: depth and width (heads are 32 wide).
    """

    def __init__(
        self, n_pieces: int, n_positions: int, n_labels: int, *, layers: int = 3, hidden: int = 384
    ) -> None:
        super().__init__()
        self.words = nn.Embedding(n_pieces, hidden)
        self.positions = nn.Parameter(torch.zeros(n_positions, hidden))
        self.norm = nn.LayerNorm(hidden, _EPSILON)
        self.layers = nn.ModuleList(Layer(hidden, 0.1) for _ in range(layers))
        self.dropout = nn.Dropout(0.1)
        self.head = nn.Linear(hidden, n_labels)

    def forward(self, pieces: Tensor, mask: Tensor) -> Tensor:
        """Return the logits; those of padding mean nothing."""
        x = self.dropout(self.norm(self.words(pieces) + self.positions[: pieces.shape[1]]))
        bias = (mask[:, None, None, :] - 1.0) * 1e4
        for layer in self.layers:
            x = layer(x, bias)
        logits: Tensor = self.head(x)
        return logits

    def load_bert(self, tensors: dict[str, Tensor], rows: list[int]) -> None:
        """Take the first layers of a BERT; ``rows`` are the word pieces kept, in order.

        The word table is frozen: pieces that training never shows stay beside their synonyms.
        """
        with torch.no_grad():
            self.words.weight.copy_(tensors["embeddings.word_embeddings.weight"][rows])
            places = tensors["embeddings.position_embeddings.weight"][: len(self.positions)]
            kind = tensors["embeddings.token_type_embeddings.weight"][0]
            self.positions.copy_(places + kind)
            _copy(self.norm, tensors, "embeddings.LayerNorm")
            for index, layer in enumerate(self.layers):
                name = f"encoder.layer.{index}"
                for part in ("weight", "bias"):
                    joined = [tensors[f"{name}.attention.self.{x}.{part}"]
                              for x in ("query", "key", "value")]  # fmt: skip
                    getattr(layer.qkv, part).copy_(torch.cat(joined))
                _copy(layer.out, tensors, f"{name}.attention.output.dense")
                _copy(layer.norm1, tensors, f"{name}.attention.output.LayerNorm")
                _copy(layer.up, tensors, f"{name}.intermediate.dense")
                _copy(layer.down, tensors, f"{name}.output.dense")
                _copy(layer.norm2, tensors, f"{name}.output.LayerNorm")
        self.words.weight.requires_grad_(False)


def _copy(module: nn.Module, tensors: dict[str, Tensor], name: str) -> None:
    module.weight.copy_(tensors[f"{name}.weight"])
    module.bias.copy_(tensors[f"{name}.bias"])
