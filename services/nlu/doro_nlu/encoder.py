"""The encoder tagger: a small BERT in ONNX, WordPiece on top of the word tokens."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import msgspec
import numpy as np

from doro_nlu.decode import Decoder
from doro_nlu.onnx_files import MODEL_FILE, VOCABULARY_FILE, Tagged, load_session, read_vocabulary
from doro_nlu.wordpiece import SPECIALS, rows_of, split_word
from doro_schemas.errors import Refused

_INPUTS = {"pieces", "mask"}
_KNOWN_WORDS = 50_000


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
        """Return the tagged sentences in their order.

        Each one is run by itself: int8 activations of a batch share one scale, so that a batch
        would make a label depend on the other sentences of it.
        """
        return [self._run(tokens) if tokens else Tagged([], [], []) for tokens in sentences]

    def _run(self, tokens: Sequence[str]) -> Tagged:
        rows, _ = rows_of([[self._ids(token) for token in tokens]])
        feed = {"pieces": rows.pieces, "mask": rows.mask}
        logits = np.asarray(self._session.run(None, feed)[0], np.float32)
        scores = [logits[row, firsts] for row, firsts in enumerate(rows.firsts)]
        return Tagged(list(tokens), *self._decoder.decode(np.concatenate(scores)))

    def _ids(self, word: str) -> list[int]:
        """Return a word's pieces; words repeat, so they are kept up to a bound."""
        found = self._split.get(word)
        if found is None:
            found = split_word(word, self._pieces)
            if len(self._split) < _KNOWN_WORDS and len(word) <= 40:
                self._split[word] = found
        return found
