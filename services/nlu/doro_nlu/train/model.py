"""The network in torch: word embedding + character CNN, two Bi-LSTM layers, logits."""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.nn.utils.rnn import pack_padded_sequence, pad_packed_sequence

from doro_nlu.features import FIRST_FREE, PAD, UNKNOWN


class BiLstm(nn.Module):  # type: ignore[misc, unused-ignore]
    """Logits (b, t, labels) of word ids (b, t) and character ids (b, t, w).

    Args:
        n_words, n_chars, n_labels: sizes of the tables.
        hidden: units per direction of each of the two layers.
        unknown_share: share of words that training shows as unknown.
        vectors: (n_words - FIRST_FREE, d) pretrained word vectors to begin with; None = random.
    """

    def __init__(
        self,
        n_words: int,
        n_chars: int,
        n_labels: int,
        *,
        hidden: int = 96,
        unknown_share: float = 0.2,
        vectors: Tensor | None = None,
    ) -> None:
        super().__init__()
        self.unknown_share = unknown_share
        width = 48 if vectors is None else vectors.shape[1]
        self.words = nn.Embedding(n_words, width, padding_idx=PAD)
        if vectors is not None:
            with torch.no_grad():
                self.words.weight[FIRST_FREE:] = vectors
        self.chars = nn.Embedding(n_chars, 16, padding_idx=PAD)
        self.conv = nn.Conv1d(16, 96, kernel_size=3, padding=1)
        self.layer1 = nn.LSTM(width + 96, hidden, batch_first=True, bidirectional=True)
        self.layer2 = nn.LSTM(2 * hidden, hidden, batch_first=True, bidirectional=True)
        self.dropout = nn.Dropout(0.3)
        self.head = nn.Linear(2 * hidden, n_labels)

    def forward(self, word_ids: Tensor, char_ids: Tensor, lengths: Tensor) -> Tensor:
        """Return the logits; what lies beyond a sentence's length means nothing."""
        if self.training:
            hide = torch.rand(word_ids.shape) < self.unknown_share
            word_ids = torch.where(hide & (word_ids != PAD), UNKNOWN, word_ids)
        b, t, w = char_ids.shape
        letters = self.chars(char_ids.reshape(b * t, w)).transpose(1, 2)
        shapes = torch.relu(self.conv(letters).amax(dim=2)).reshape(b, t, -1)
        x = self.dropout(torch.cat([self.words(word_ids), shapes], dim=2))
        for layer in (self.layer1, self.layer2):
            packed = pack_padded_sequence(x, lengths, batch_first=True, enforce_sorted=False)
            x, _ = pad_packed_sequence(layer(packed)[0], batch_first=True, total_length=t)
            x = self.dropout(x)
        logits: Tensor = self.head(x)
        return logits
