"""The files of a tagger: the model and its vocabulary, checked when they are loaded."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import NamedTuple, TypeVar

import msgspec
import onnxruntime as ort

from doro_schemas.errors import Refused

MODEL_FILE = "model.onnx"
VOCABULARY_FILE = "vocabulary.json"
T = TypeVar("T", bound=msgspec.Struct)


class Tagged(NamedTuple):
    """A tagged sentence: tokens, BIO labels and the probability of each label (0..1)."""

    tokens: list[str]
    labels: list[str]
    probabilities: list[float]


def read_vocabulary(path: Path, kind: type[T]) -> T:
    """Return the vocabulary of a model.

    Raises:
        Refused: missing or unreadable file, or one of another kind of tagger.
    """
    try:
        return msgspec.json.decode(path.read_bytes(), type=kind)
    except (OSError, msgspec.DecodeError) as error:
        raise Refused(
            f"the tagger's vocabulary {path} cannot be read ({error}): reinstall doro-nlu or"
            " set nlu.model_dir to a directory with a trained model"
        ) from error


def load_session(path: Path, sha256: str) -> ort.InferenceSession:  # type: ignore[name-defined]
    """Return the model on one thread.

    Raises:
        Refused: the file is missing, damaged, or not the one with this digest (empty = any).
    """
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
