"""The best BIO sequence for a table of scores (Viterbi), and what each label is worth."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from doro_nlu.labels import may_follow

Scores = NDArray[np.float64]
FORBIDDEN = -1e9


class Decoder:
    """Viterbi over label scores with the BIO constraint.

    Args:
        labels: the model's labels, in the order of its scores.
    """

    def __init__(self, labels: Sequence[str]) -> None:
        self.labels = tuple(labels)
        self._starts = np.array([FORBIDDEN if label.startswith("I-") else 0.0 for label in labels])
        self._steps = np.array(
            [[0.0 if may_follow(a, b) else FORBIDDEN for b in labels] for a in labels]
        )
        self._allowed = self._steps == 0.0

    def decode(self, logits: NDArray[np.float32]) -> tuple[list[str], list[float]]:
        """Return labels and their probabilities for logits (t, labels); ties: the earlier label."""
        if not len(logits):
            return [], []
        log_p = log_softmax(logits.astype(np.float64))
        path = log_p.argmax(axis=1)
        legal = self._allowed[path[:-1], path[1:]].all() and self._starts[path[0]] == 0.0
        if not legal:  # else the labels that are best one by one are the best sequence, too
            path = self._viterbi(log_p)
        chosen = np.exp(log_p[np.arange(len(path)), path])
        return [self.labels[index] for index in path], chosen.tolist()

    def _viterbi(self, log_p: Scores) -> NDArray[np.intp]:
        """Return the label indices of the best legal sequence for log-probabilities (t, labels)."""
        back = np.zeros(log_p.shape, np.intp)
        best = log_p[0] + self._starts
        columns = np.arange(log_p.shape[1])
        for row in range(1, len(log_p)):
            scores = best[:, None] + self._steps
            back[row] = scores.argmax(axis=0)
            best = scores[back[row], columns] + log_p[row]
        path = np.zeros(len(log_p), np.intp)
        path[-1] = best.argmax()
        for row in range(len(log_p) - 1, 0, -1):
            path[row - 1] = back[row, path[row]]
        return path


def log_softmax(logits: Scores) -> Scores:
    """Return the log-softmax over the last axis, float64."""
    shifted = logits - logits.max(axis=-1, keepdims=True)
    result: Scores = shifted - np.log(np.exp(shifted).sum(axis=-1, keepdims=True))
    return result
