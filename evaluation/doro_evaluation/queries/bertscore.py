"""BERTScore and sentence cosine, offline (paper, Section V-D: "BERT score").

BERTScore (Zhang et al., 2020): every piece of the one text is matched with the most similar piece
of the other by the cosine of their states after a layer of BERT; recall is the mean over the
reference's pieces, precision over the candidate's, F1 their harmonic mean. No idf weights, no
rescaling: bert-score has no baseline for this encoder. The encoder is all-MiniLM-L6-v2, layer
5 of 6, as bert-score takes of other encoders with six layers. Begin and end do not count.

With the weights in float32 the values are those of the package ``bert-score`` 0.3.12 (largest
difference on 50 pairs: see ``data/minilm/README.md``); shipped are weights in int8.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from doro_evaluation.baseline.text import read_vocabulary
from doro_evaluation.onnx_files import open_model
from doro_nlu.tokens import tokenize
from doro_nlu.wordpiece import BEGIN, END, ROW_PIECES, split_word
from doro_schemas.errors import Refused

MODEL_DIR = Path(__file__).parents[1] / "data" / "minilm"
MODEL, VOCABULARY = "model.onnx", "vocabulary.json"
LAYERS, LAYER = 6, 5
BATCH = 64
MARKS = 2
"""Begin and end."""
Floats = NDArray[np.float32]


class Embedded:
    """A sentence: unit states of begin, pieces and end (p, h), and its unit mean state (h,)."""

    __slots__ = ("pieces", "whole")

    def __init__(self, pieces: Floats, whole: Floats) -> None:
        self.pieces, self.whole = pieces, whole


class Similarity:
    """BERTScore and cosine of texts; every text is embedded once.

    Args:
        directory: with ``model.onnx`` and ``vocabulary.json``.

    Raises:
        Refused: a file is missing or damaged.
    """

    def __init__(self, directory: Path = MODEL_DIR) -> None:
        found = read_vocabulary(directory / VOCABULARY)
        self._session = open_model(
            directory / MODEL, found.sha256.get(MODEL, ""), "BERTScore's encoder"
        )
        self._ids = {name: number for number, name in enumerate(found.pieces)}
        self._known: dict[str, Embedded] = {}

    def embed(self, texts: Iterable[str]) -> list[Embedded]:
        """Return the embeddings of texts, in order; new ones in batches of one length."""
        wanted = list(texts)
        by_length: dict[int, list[tuple[str, list[int]]]] = defaultdict(list)
        for text in dict.fromkeys(wanted):
            if text not in self._known:
                pieces = self._pieces(text)
                by_length[len(pieces)].append((text, pieces))
        for length in sorted(by_length):
            group = by_length[length]
            for start in range(0, len(group), BATCH):
                self._run(group[start : start + BATCH])
        return [self._known[text] for text in wanted]

    def f1(self, candidate: str, reference: str) -> float:
        """Return BERTScore's F1 of two texts; 0 where one has no pieces."""
        one, other = self.embed([candidate, reference])
        return _f1(one.pieces, other.pieces)

    def best_f1(
        self, candidates: Sequence[str], references: Sequence[Sequence[str]]
    ) -> list[float]:
        """Return for each candidate the highest F1 over its references."""
        self.embed(_all_texts(candidates, references))
        return [
            max((self.f1(text, other) for other in dict.fromkeys(others)), default=0.0)
            for text, others in zip(candidates, references, strict=True)
        ]

    def best_cosine(
        self, candidates: Sequence[str], references: Sequence[Sequence[str]]
    ) -> list[float]:
        """Return for each candidate the highest cosine of mean states over its references."""
        self.embed(_all_texts(candidates, references))
        known = self._known
        return [
            max((float(known[text].whole @ known[other].whole) for other in others), default=0.0)
            for text, others in zip(candidates, references, strict=True)
        ]

    def _pieces(self, text: str) -> list[int]:
        ids = [piece for word in tokenize(text) for piece in split_word(word, self._ids)]
        return [BEGIN, *ids[: ROW_PIECES - 2], END]

    def _run(self, group: Sequence[tuple[str, list[int]]]) -> None:
        pieces = np.array([ids for _, ids in group], np.int64)
        states, last = (np.asarray(array) for array in self._session.run(None, {"pieces": pieces}))
        for (text, _), state, end in zip(group, states, last, strict=True):
            self._known[text] = Embedded(_unit(state), _unit(end.mean(axis=0, keepdims=True))[0])


_shared: dict[Path, Similarity] = {}


def available(directory: Path = MODEL_DIR) -> str:
    """Return nothing where the metrics can be had, else a sentence that says why not."""
    try:
        shared(directory)
    except Refused as error:
        return str(error)
    return ""


def shared(directory: Path = MODEL_DIR) -> Similarity:
    """Return the metrics of a folder, loaded once in a process."""
    if directory not in _shared:
        _shared[directory] = Similarity(directory)
    return _shared[directory]


def bertscore(candidates: Sequence[str], references: Sequence[Sequence[str]]) -> list[float]:
    """Return for each candidate its best BERTScore F1 over its references."""
    return shared().best_f1(candidates, references)


def cosine(candidates: Sequence[str], references: Sequence[Sequence[str]]) -> list[float]:
    """Return for each candidate its best sentence cosine over its references."""
    return shared().best_cosine(candidates, references)


def _f1(candidate: Floats, reference: Floats) -> float:
    if len(candidate) <= MARKS or len(reference) <= MARKS:
        return 0.0
    alike = candidate @ reference.T
    # As in bert-score: begin and end weigh nothing, but a piece may be most similar to them.
    precision = float(alike[1:-1].max(axis=1).mean())
    recall = float(alike[:, 1:-1].max(axis=0).mean())
    return 2 * precision * recall / (precision + recall) if precision + recall > 0 else 0.0


def _unit(rows: Floats) -> Floats:
    """Return rows of length one."""
    lengths: Floats = np.maximum(np.linalg.norm(rows, axis=-1, keepdims=True), 1e-12)
    return np.asarray(rows / lengths, np.float32)


def _all_texts(candidates: Sequence[str], references: Sequence[Sequence[str]]) -> Iterable[str]:
    yield from candidates
    for others in references:
        yield from others
