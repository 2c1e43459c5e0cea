"""The baseline's network in torch: an encoder-decoder whose two halves begin as one BERT.

As in BERT2BERT and in the paper (Fig. 4): both halves take the layers of a pretrained encoder, the
decoder looks only backwards, and its attention to the encoder is new. One word table serves
encoder, decoder and output.
"""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.nn import functional

from doro_nlu.train.encoder_model import HEADS, Encoder, Layer

FAR = -1e4


class DecoderLayer(Layer):
    """A BERT layer with attention to the encoder's states between its two parts."""

    def __init__(self, hidden: int, inner: int, dropout: float) -> None:
        super().__init__(hidden, inner, dropout)
        self.ask = nn.Linear(hidden, hidden)
        self.look = nn.Linear(hidden, 2 * hidden)
        self.take = nn.Linear(hidden, hidden)
        self.norm_seen = nn.LayerNorm(hidden, self.norm1.eps)
        # Scores spread from the start, and what is attended to is handed on as it is: as one word
        # table serves both sides, attending to a word already makes it likelier to be written.
        for fresh in (self.ask, self.look):
            nn.init.normal_(fresh.weight, std=hidden**-0.5)
            nn.init.zeros_(fresh.bias)
        with torch.no_grad():
            self.look.weight[hidden:].copy_(torch.eye(hidden))
            self.take.weight.copy_(torch.eye(hidden))
            self.take.bias.zero_()

    def seen(self, states: Tensor) -> Tensor:
        """Return keys and values (2, b, heads, p, h / heads) of the encoder's states (b, p, h)."""
        b, p, h = states.shape
        return self.look(states).view(b, p, 2, HEADS, h // HEADS).permute(2, 0, 3, 1, 4)

    def own(self, x: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Return queries, keys and values (b, heads, t, h / heads) of x (b, t, h)."""
        b, t, h = x.shape
        q, k, v = self.qkv(x).view(b, t, 3, HEADS, h // HEADS).permute(2, 0, 3, 1, 4)
        return q, k, v

    def after_own(self, x: Tensor, mixed: Tensor) -> Tensor:
        """Return x with what self-attention found, (b, t, h)."""
        b, t, h = x.shape
        found = self.out(mixed.transpose(1, 2).reshape(b, t, h))
        result: Tensor = self.norm1(x + self.dropout(found))
        return result

    def after_seen(self, x: Tensor, seen: Tensor, bias: Tensor) -> Tensor:
        """Return the layer's output from x after self-attention, (b, t, h).

        Args:
            seen: of :meth:`seen`; bias: (b, 1, 1, p), added to the scores.
        """
        b, t, h = x.shape
        query = self.ask(x).view(b, t, HEADS, h // HEADS).transpose(1, 2)
        mixed = functional.scaled_dot_product_attention(
            query, seen[0], seen[1], attn_mask=bias.to(query.dtype)
        )
        found = self.take(mixed.transpose(1, 2).reshape(b, t, h))
        x = self.norm_seen(x + self.dropout(found))
        result: Tensor = self.norm2(x + self.dropout(self.down(functional.gelu(self.up(x)))))
        return result


class EncoderDecoder(nn.Module):  # type: ignore[misc, unused-ignore]
    """Logits (b, t, pieces) of the next piece, of input (b, p), its mask and output (b, t).

    Args:
        n_pieces: of the vocabulary; n_positions: of the longer of input and output.
        layers: of the encoder, and of the decoder.
    """

    def __init__(
        self,
        n_pieces: int,
        n_positions: int,
        *,
        layers: tuple[int, int],
        hidden: int,
        dropout: float = 0.0,
    ) -> None:
        super().__init__()
        self.encoder = Encoder(n_pieces, n_positions, 1, layers=layers[0], hidden=hidden)
        del self.encoder.head
        self.norm = nn.LayerNorm(hidden, self.encoder.norm.eps)
        self.layers = nn.ModuleList(
            DecoderLayer(hidden, 4 * hidden, dropout) for _ in range(layers[1])
        )
        self.dropout = nn.Dropout(dropout)
        self.bias = nn.Parameter(torch.zeros(n_pieces))
        for module in self.encoder.modules():
            if isinstance(module, nn.Dropout):
                module.p = dropout

    def load_bert(self, tensors: dict[str, Tensor], rows: list[int]) -> None:
        """Let both halves begin as the first layers of a BERT; ``rows`` are the pieces kept."""
        self.encoder.load_bert(tensors, rows)
        self.encoder.words.weight.requires_grad_(True)
        self.norm.load_state_dict(self.encoder.norm.state_dict())
        for own, source in zip(self.layers, self.encoder.layers, strict=False):
            own.load_state_dict(source.state_dict(), strict=False)

    def embedded(self, pieces: Tensor, positions: Tensor) -> Tensor:
        """Return the decoder's input (b, t, h) of pieces (b, t) at positions (t, h)."""
        return self.dropout(self.norm(self.encoder.words(pieces) + positions))

    def logits(self, x: Tensor) -> Tensor:
        """Return the logits of the decoder's last states."""
        return functional.linear(x, self.encoder.words.weight, self.bias)

    def forward(self, pieces: Tensor, mask: Tensor, written: Tensor) -> Tensor:
        """Return the logits for every place of ``written``, whose first piece is the begin."""
        states = self.encoder.states(pieces, mask)
        bias = (mask[:, None, None, :] - 1.0) * -FAR
        length = written.shape[1]
        later = torch.full((length, length), FAR).triu(1)
        x = self.embedded(written, self.encoder.positions[:length])
        for layer in self.layers:
            query, key, value = layer.own(x)
            mixed = functional.scaled_dot_product_attention(
                query, key, value, attn_mask=later.to(query.dtype)
            )
            x = layer.after_seen(layer.after_own(x, mixed), layer.seen(states), bias)
        return self.logits(x)
