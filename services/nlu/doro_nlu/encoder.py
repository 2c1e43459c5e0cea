"""The encoder tagger: a small BERT in ONNX, WordPiece on top of the word tokens."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from doro_nlu.decode import Decoder
from doro_nlu.onnx_files import MODEL_FILE, VOCABULARY_FILE, Tagged, load_session, read_vocabulary
from doro_nlu.wordpiece import SPECIALS, rows_of, split_word
from doro_schemas.errors import Refused

_INPUTS = {"pieces", "mask"}
_KNOWN_WORDS = 50_000
_SLACK = 2
"""Pieces that sentences of one batch may differ by: padding costs as much as words."""
_BATCH = 32
Scores = NDArray[np.float32]


class Pieces(msgspec.Struct, frozen=True):
    """What belongs to an encoder's model file.

    Attributes:
        labels: in the order of the model's scores.
        pieces: word pieces, their index is their id.
        model_sha256: hex digest of the model file; empty = not checked.
    """

    labels: list[str]
    pieces: list[str]
    model_sha256: str = ""


class EncoderTagger:
    """A BERT-family encoder, run by onnxruntime on one thread.

    Args:
        directory: holds ``model.onnx`` and ``vocabulary.json``.

    Raises:
        Refused: a file is missing, cannot be read, or the two do not belong together.
    """

    def __init__(self, directory: Path) -> None:
        vocabulary = read_vocabulary(directory / VOCABULARY_FILE, Pieces)
        self.labels = tuple(vocabulary.labels)
        self._pieces = {piece: index for index, piece in enumerate(vocabulary.pieces)}
        self._split: dict[str, list[int]] = {}
        self._decoder = Decoder(self.labels)
        self._session = load_session(directory / MODEL_FILE, vocabulary.model_sha256)
        self._check(directory, vocabulary)

    def _check(self, directory: Path, vocabulary: Pieces) -> None:
        """Refuse a vocabulary of another model: by inputs, labels and the last piece's id."""
        inputs = {item.name for item in self._session.get_inputs()}
        width = self._session.get_outputs()[0].shape[-1]
        specials = tuple(vocabulary.pieces[: len(SPECIALS)])
        if inputs != _INPUTS or width != len(self.labels) or specials != SPECIALS:
            raise Refused(
                f"the tagger in {directory} has inputs {sorted(inputs)} and {width} labels, but its"
                f" vocabulary lists {len(self.labels)} labels and begins with {list(specials)}:"
                " take model and vocabulary of one run"
            )
        last = len(vocabulary.pieces) - 1
        rows, _ = rows_of([[[last]]])
        try:
            self._session.run(None, {"pieces": rows.pieces, "mask": rows.mask})
        except Exception as error:  # onnxruntime has no public base class of its errors
            raise Refused(
                f"the vocabulary in {directory} lists {len(self._pieces)} pieces, more than its"
                " model has: take both of one run"
            ) from error

    def knows(self, word: str) -> bool:
        """Tell whether a word (any case) is a piece of its own in the vocabulary."""
        return word.lower() in self._pieces

    def tag(self, sentences: Sequence[Sequence[str]]) -> list[Tagged]:
        """Return the tagged sentences in their order; those of like length run at once.

        The scales of the int8 activations are fixed, so that a sentence has the same labels in
        any batch.
        """
        split = [[self._ids(token) for token in tokens] for tokens in sentences]
        lengths = [sum(len(ids) for ids in words) for words in split]
        order = sorted((at for at, words in enumerate(split) if words), key=lengths.__getitem__)
        found = [Tagged([], [], []) for _ in sentences]
        while order:
            first = lengths[order[0]]
            size = next((n for n, at in enumerate(order) if lengths[at] > first + _SLACK), None)
            batch, order = order[:size][:_BATCH], order[min(size or _BATCH, _BATCH) :]
            scores = self._scores([split[at] for at in batch])
            for at, logits in zip(batch, scores, strict=True):
                found[at] = Tagged(list(sentences[at]), *self._decoder.decode(logits))
        return found

    def _scores(self, split: Sequence[Sequence[Sequence[int]]]) -> list[Scores]:
        """Return the logits (t, labels) of sentences given as pieces per word."""
        rows, owners = rows_of(split)
        feed = {"pieces": rows.pieces, "mask": rows.mask}
        logits = np.asarray(self._session.run(None, feed)[0], np.float32)
        parts: list[list[Scores]] = [[] for _ in split]
        for row, (owner, firsts) in enumerate(zip(owners, rows.firsts, strict=True)):
            parts[owner].append(logits[row, firsts])
        return [np.concatenate(part) if len(part) > 1 else part[0] for part in parts]

    def _ids(self, word: str) -> list[int]:
        """Return a word's pieces; words repeat, so they are kept up to a bound."""
        found = self._split.get(word)
        if found is None:
            found = split_word(word, self._pieces)
            if len(self._split) < _KNOWN_WORDS and len(word) <= 40:
                self._split[word] = found
        return found
