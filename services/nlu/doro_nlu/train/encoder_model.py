"""The encoder in torch: the first layers of a BERT, and a label head."""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.nn import functional

HEADS = 12
"""Of MiniLM (32 wide each) and of bert-base (64 wide each)."""
_EPSILON = 1e-12


class Layer(nn.Module):  # type: ignore[misc, unused-ignore]
    """A BERT layer (post-norm)."""

    def __init__(self, hidden: int, inner: int, dropout: float) -> None:
        super().__init__()
        self.qkv = nn.Linear(hidden, 3 * hidden)
        self.out = nn.Linear(hidden, hidden)
        self.norm1 = nn.LayerNorm(hidden, _EPSILON)
        self.up = nn.Linear(hidden, inner)
        self.down = nn.Linear(inner, hidden)
        self.norm2 = nn.LayerNorm(hidden, _EPSILON)
        self.dropout = nn.Dropout(dropout)

    def forward(self, x: Tensor, bias: Tensor) -> Tensor:
        """Return the layer's output (b, p, h); ``bias`` (b, 1, 1, p) is added to the scores."""
        b, p, h = x.shape
        q, k, v = self.qkv(x).view(b, p, 3, HEADS, h // HEADS).permute(2, 0, 3, 1, 4)
        mixed = functional.scaled_dot_product_attention(q, k, v, attn_mask=bias.to(q.dtype))
        x = self.norm1(x + self.dropout(self.out(mixed.transpose(1, 2).reshape(b, p, h))))
        result: Tensor = self.norm2(x + self.dropout(self.down(functional.gelu(self.up(x)))))
        return result


class Encoder(nn.Module):  # type: ignore[misc, unused-ignore]
    """Logits (b, p, labels) of piece ids (b, p) and mask (b, p).

    Args:
        n_pieces, n_positions, n_labels: sizes of the tables.
        layers, hidden, inner: depth, width, and width inside the feed-forward part.
    """

    def __init__(
        self,
        n_pieces: int,
        n_positions: int,
        n_labels: int,
        *,
        layers: int = 3,
        hidden: int = 384,
        inner: int = 0,
    ) -> None:
        super().__init__()
        self.words = nn.Embedding(n_pieces, hidden)
        self.positions = nn.Parameter(torch.zeros(n_positions, hidden))
        self.norm = nn.LayerNorm(hidden, _EPSILON)
        width = inner or 4 * hidden
        self.layers = nn.ModuleList(Layer(hidden, width, 0.1) for _ in range(layers))
        self.dropout = nn.Dropout(0.1)
        self.head = nn.Linear(hidden, n_labels)

    def states(self, pieces: Tensor, mask: Tensor) -> Tensor:
        """Return the last hidden states (b, p, h)."""
        x = self.dropout(self.norm(self.words(pieces) + self.positions[: pieces.shape[1]]))
        bias = (mask[:, None, None, :] - 1.0) * 1e4
        for layer in self.layers:
            x = layer(x, bias)
        return x

    def forward(self, pieces: Tensor, mask: Tensor) -> Tensor:
        """Return the logits; those of padding mean nothing."""
        logits: Tensor = self.head(self.states(pieces, mask))
        return logits

    def load_bert(self, tensors: dict[str, Tensor], rows: list[int]) -> None:
        """Take the first layers of a BERT; ``rows`` are the word pieces kept, in order.

        The word table is frozen: pieces that training never shows stay beside their synonyms. A
        feed-forward part narrower than the source's keeps the units with the largest weights.
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
                up, down = (tensors[f"{name}.{x}.dense.weight"] for x in ("intermediate", "output"))
                units = (up.norm(dim=1) * down.norm(dim=0)).topk(layer.up.out_features).indices
                units = units.sort().values
                layer.up.weight.copy_(up[units])
                layer.up.bias.copy_(tensors[f"{name}.intermediate.dense.bias"][units])
                layer.down.weight.copy_(down[:, units])
                layer.down.bias.copy_(tensors[f"{name}.output.dense.bias"])
                _copy(layer.norm2, tensors, f"{name}.output.LayerNorm")
        self.words.weight.requires_grad_(False)


def _copy(module: nn.Module, tensors: dict[str, Tensor], name: str) -> None:
    module.weight.copy_(tensors[f"{name}.weight"])
    module.bias.copy_(tensors[f"{name}.bias"])
