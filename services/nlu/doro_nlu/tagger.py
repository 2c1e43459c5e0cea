"""The tagger: tokens to BIO labels (paper, Section IV-A), behind one interface."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple, Protocol

import msgspec
import numpy as np
import onnxruntime as ort

from doro_nlu.decode import Decoder
from doro_nlu.features import FIRST_FREE, encode
from doro_schemas.errors import Refused

MODEL_FILE = "model.onnx"
VOCABULARY_FILE = "vocabulary.json"
DEFAULT_MODEL = Path(__file__).parent / "models" / "bilstm"
_INPUTS = {"words", "chars", "lengths"}


class Tagged(NamedTuple):
    """A tagged sentence: tokens, BIO labels and the probability of each label (0..1)."""

    tokens: list[str]
    labels: list[str]
    probabilities: list[float]


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
        vocabulary = load_vocabulary(directory / VOCABULARY_FILE)
        self.labels = tuple(vocabulary.labels)
        self._words = {word: FIRST_FREE + i for i, word in enumerate(vocabulary.words)}
        self._chars = {char: FIRST_FREE + i for i, char in enumerate(vocabulary.chars)}
        self._decoder = Decoder(self.labels)
        self._session = _load_session(directory / MODEL_FILE, vocabulary.model_sha256)
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


def load_vocabulary(path: Path) -> Vocabulary:
    """Return the vocabulary of a model.

    Raises:
        Refused: missing or unreadable file.
    """
    try:
        return msgspec.json.decode(path.read_bytes(), type=Vocabulary)
    except (OSError, msgspec.DecodeError) as error:
        raise Refused(
            f"the tagger's vocabulary {path} cannot be read ({error}): reinstall doro-nlu or"
            " set nlu.model_dir to a directory with a trained model"
        ) from error


def _load_session(path: Path, sha256: str) -> ort.InferenceSession:  # type: ignore[name-defined]
    if not path.is_file():
        raise Refused(
            f"the tagger's model {path} is missing: reinstall doro-nlu or set nlu.model_dir to a"
            " directory with a trained model"
        )
    content = path.read_bytes()
    if sha256 and hashlib.sha256(content).hexdigest() != sha256:
        raise Refused(
            f"the tagger's model {path} is not the one its vocabulary belongs to, or it is"
            " damaged (sha256 differs): reinstall doro-nlu or train it again with"
            " 'python -m doro_nlu.train'"
        )
    options = ort.SessionOptions()  # type: ignore[attr-defined]
    options.intra_op_num_threads = 1
    options.inter_op_num_threads = 1
    options.log_severity_level = 4
    try:
        return ort.InferenceSession(  # type: ignore[attr-defined]
            content, sess_options=options, providers=["CPUExecutionProvider"]
        )
    except Exception as error:  # onnxruntime has no public base class of its errors
        first_line = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise Refused(
            f"the tagger's model {path} is no usable ONNX file ({first_line}): reinstall doro-nlu"
            " or train it again with 'python -m doro_nlu.train'"
        ) from error
