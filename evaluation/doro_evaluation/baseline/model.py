"""The trained baseline in use: ONNX files, greedy decoding, the same answer every time."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import onnxruntime as ort
from numpy.typing import NDArray

from doro_evaluation.baseline.text import (
    BEGIN,
    END,
    OUTPUT_PIECES,
    PAD,
    UNKNOWN,
    Vocabulary,
    about,
    read_vocabulary,
)
from doro_evaluation.onnx_files import open_model
from doro_schemas.errors import Refused

ENCODER, DECODER, VOCABULARY = "encoder.onnx", "decoder.onnx", "vocabulary.json"
MODEL_DIR = Path(__file__).parent / "model"
"""The shipped model."""
MISSING = "no trained baseline: python -m doro_evaluation.baseline.train (see its README)"
NEVER = [PAD, UNKNOWN, BEGIN]
"""Pieces that are no word; the most likely other one is written instead."""

Floats = NDArray[np.float32]


class Baseline:
    """Captions and instruction to what is said (paper, Section V-D).

    Args:
        encoder: pieces (1, p) int64 to keys and values of each decoder layer,
            (layers, 2, heads, p, width).
        decoder: last piece (1, 1) int64, its place (1,) int64, ``past`` (layers, 2, heads, t,
            width) and the encoder's result to logits (pieces,) and the past with this piece.
    """

    def __init__(
        self,
        encoder: ort.InferenceSession,  # type: ignore[name-defined]
        decoder: ort.InferenceSession,  # type: ignore[name-defined]
        vocabulary: Vocabulary,
    ) -> None:
        self._encoder, self._decoder, self._vocabulary = encoder, decoder, vocabulary
        past = next(one for one in decoder.get_inputs() if one.name == "past")
        layers, two, heads, _, width = past.shape
        self._start = np.zeros((layers, two, heads, 0, width), np.float32)

    def answer(self, captions: Sequence[str], instruction: str) -> str:
        """Return what is said about the captions of one view, or of the map.

        Only captions whose noun is the instruction's are read; there may be none.

        Raises:
            Refused: the instruction is empty.
        """
        return self.answer_views([captions], instruction)

    def answer_views(self, captions: Sequence[Sequence[str]], instruction: str) -> str:
        """Return what is said about the captions of many views, joined one after the other.

        What does not fit into :data:`doro_evaluation.baseline.text.INPUT_PIECES` is cut.

        Raises:
            Refused: the instruction is empty.
        """
        if not instruction.strip():
            raise Refused("the instruction for the baseline is empty: say what is wanted")
        views = [about(view, instruction) for view in captions]
        return self._vocabulary.text(self._write(self._vocabulary.input(views, instruction)))

    def _write(self, pieces: Sequence[int]) -> list[int]:
        """Return the most likely piece after the other, up to the end."""
        (seen,) = self._encoder.run(None, {"pieces": np.array([pieces], np.int64)})
        past, last, written = self._start, BEGIN, list[int]()
        while len(written) < OUTPUT_PIECES:
            logits, past = self._decoder.run(
                None,
                {
                    "piece": np.array([[last]], np.int64),
                    "place": np.array([len(written)], np.int64),
                    "past": past,
                    "seen": seen,
                },
            )
            logits[NEVER] = -np.inf
            last = int(np.argmax(logits))
            if last == END:
                break
            written.append(last)
        return written


def load(directory: Path = MODEL_DIR) -> Baseline:
    """Return the baseline of a folder that ``export`` wrote; without a name the shipped one.

    Raises:
        Refused: a file is missing, is not the one that the vocabulary names, or is no model.
    """
    found = read_vocabulary(directory / VOCABULARY)
    encoder, decoder = (
        open_model(directory / name, found.sha256.get(name, ""), "the baseline's")
        for name in (ENCODER, DECODER)
    )
    return Baseline(encoder, decoder, Vocabulary(found.pieces))


def available(directory: Path = MODEL_DIR) -> str:
    """Return nothing where a baseline can be loaded, else a sentence that says why not."""
    if not (directory / VOCABULARY).is_file():
        return MISSING
    try:
        load(directory)
    except Refused as error:
        return str(error)
    return ""
