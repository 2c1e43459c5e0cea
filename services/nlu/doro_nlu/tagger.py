"""The tagger: tokens to BIO labels (paper, Section IV-A), behind one interface."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Protocol

import msgspec
import numpy as np

from doro_nlu.decode import Decoder
from doro_nlu.encoder import EncoderTagger
from doro_nlu.features import FIRST_FREE, encode
from doro_nlu.onnx_files import MODEL_FILE, VOCABULARY_FILE, Tagged, load_session, read_vocabulary
from doro_schemas.errors import Refused

__all__ = ["DEFAULT_MODEL", "MODEL_FILE", "SHIPPED", "VOCABULARY_FILE", "BiLstmTagger",
           "EncoderTagger", "Tagged", "Tagger", "Vocabulary", "load_tagger"]  # fmt: skip
_MODELS = Path(__file__).parent / "models"
DEFAULT_MODEL = _MODELS / "bilstm"
SHIPPED = {"bilstm": DEFAULT_MODEL, "default": _MODELS / "encoder"}
_INPUTS = {"words", "chars", "lengths"}


class Tagger(Protocol):
    """What tags token sequences."""

    labels: tuple[str, ...]

    def tag(self, sentences: Sequence[Sequence[str]]) -> list[Tagged]:
        """Return the tagged sentences, in order; an empty one has no labels."""
        ...

    def knows(self, word: str) -> bool:
        """Tell whether a word is in the tagger's vocabulary."""
        ...


class Vocabulary(msgspec.Struct, frozen=True):
    """What belongs to a model file.

    Attributes:
        labels: in the order of the model's scores.
        words, chars: ids count from ``FIRST_FREE`` in this order.
        model_sha256: hex digest of the model file; empty = not checked.
    """

    labels: list[str]
    words: list[str]
    chars: list[str]
    model_sha256: str = ""


class BiLstmTagger:
    """The shipped Bi-LSTM, run by onnxruntime on one thread.

    Args:
        directory: holds ``model.onnx`` and ``vocabulary.json``; None = the shipped model.

    Raises:
        Refused: a file is missing, cannot be read, or the two do not belong together.
    """

    def __init__(self, directory: Path | None = None) -> None:
        directory = DEFAULT_MODEL if directory is None else directory
        vocabulary = read_vocabulary(directory / VOCABULARY_FILE, Vocabulary)
        self.labels = tuple(vocabulary.labels)
        self._words = {word: FIRST_FREE + i for i, word in enumerate(vocabulary.words)}
        self._chars = {char: FIRST_FREE + i for i, char in enumerate(vocabulary.chars)}
        self._decoder = Decoder(self.labels)
        self._session = load_session(directory / MODEL_FILE, vocabulary.model_sha256)
        self._check(directory)

    def _check(self, directory: Path) -> None:
        """Refuse a vocabulary of another model: by labels, and by running the last word's id."""
        inputs = {item.name for item in self._session.get_inputs()}
        width = self._session.get_outputs()[0].shape[-1]
        if inputs != _INPUTS or width != len(self.labels):
            raise Refused(
                f"the tagger in {directory} has inputs {sorted(inputs)} and {width} labels, but its"
                f" vocabulary lists {len(self.labels)} labels: take model and vocabulary of one run"
            )
        last = [*list(self._words)[-1:], *list(self._chars)[-1:]]
        try:
            self.tag([last])
        except Exception as error:  # onnxruntime has no public base class of its errors
            raise Refused(
                f"the vocabulary in {directory} lists {len(self._words)} words and"
                f" {len(self._chars)} characters, more than its model has: take both of one run"
            ) from error

    def knows(self, word: str) -> bool:
        """Tell whether a word (any case) is in the vocabulary."""
        return word.lower() in self._words

    def tag(self, sentences: Sequence[Sequence[str]]) -> list[Tagged]:
        """Return the tagged sentences of one batch, run at once, in their order."""
        full = [tokens for tokens in sentences if tokens]
        results = iter(self._run(full) if full else [])
        return [next(results) if tokens else Tagged([], [], []) for tokens in sentences]

    def _run(self, sentences: Sequence[Sequence[str]]) -> list[Tagged]:
        words, chars, lengths = encode(sentences, self._words, self._chars)
        feed = {"words": words, "chars": chars, "lengths": lengths}
        logits = np.asarray(self._session.run(None, feed)[0], np.float32)
        tagged = []
        for row, tokens in enumerate(sentences):
            labels, probabilities = self._decoder.decode(logits[row, : len(tokens)])
            tagged.append(Tagged(list(tokens), labels, probabilities))
        return tagged


class _Kind(msgspec.Struct, frozen=True):
    """The field that tells the encoder's vocabulary from the Bi-LSTM's."""

    pieces: list[str] | None = None


def load_tagger(directory: Path | None = None, name: str = "default") -> Tagger:
    """Return a tagger: that of a directory (its vocabulary tells the kind), else a shipped one.

    Args:
        directory: holds ``model.onnx`` and ``vocabulary.json``; None = shipped.
        name: of the shipped ones: ``bilstm`` or ``default`` (the encoder); ``bert-base`` is run
            from its directory only.

    Raises:
        Refused: unknown name, or the model cannot be loaded.
    """
    if directory is None and name == "bert-base":
        raise Refused(
            "the tagger bert-base is not shipped (440 MB): train it as models/bert_base/README.md"
            " says and set nlu.model_dir to its directory"
        )
    if directory is None and name not in SHIPPED:
        raise Refused(f"no tagger is called '{name}': set nlu.tagger to {' or '.join(SHIPPED)}")
    directory = SHIPPED[name] if directory is None else directory
    if read_vocabulary(directory / VOCABULARY_FILE, _Kind).pieces is None:
        return BiLstmTagger(directory)
    return EncoderTagger(directory)
