"""BIO labels to spans."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from doro_nlu.labels import OUTSIDE, kind_of


class Span(NamedTuple):
    """A labelled stretch of tokens, ``start`` to ``end`` (exclusive)."""

    kind: str
    start: int
    end: int
    text: str
    probability: float


def spans_of(
    tokens: Sequence[str], labels: Sequence[str], probabilities: Sequence[float]
) -> list[Span]:
    """Return the spans in order; an I- without its B- starts a span. Text is lower case."""
    spans: list[Span] = []
    start = 0
    for index in range(1, len(labels) + 1):
        going_on = index < len(labels) and (
            labels[index].startswith("I-") and kind_of(labels[index]) == kind_of(labels[start])
        )
        if going_on:
            continue
        if labels[start] != OUTSIDE:
            text = " ".join(tokens[start:index]).lower()
            lowest = min(probabilities[start:index], default=0.0)
            spans.append(Span(kind_of(labels[start]), start, index, text, lowest))
        start = index
    return spans
