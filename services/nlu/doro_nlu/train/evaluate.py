"""Figures of a tagger: precision, recall and F1 per label over tokens, and whole sentences.

``python -m doro_nlu.train.evaluate [--gold FILE]`` measures the shipped tagger (no torch needed)
on held-out templates or on labelled sentences (JSON lines with ``tokens`` and ``labels``).
"""

from __future__ import annotations

import argparse
import itertools
import json
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import msgspec

from doro_nlu.labels import OUTSIDE
from doro_nlu.spans import spans_of
from doro_nlu.tagger import Tagger, load_tagger
from doro_nlu.train.annotate import Example
from doro_nlu.train.generate import Generator

HELD_OUT_SENTENCES = 3000


class LabelScore(msgspec.Struct, frozen=True):
    """Token-level figures of one label."""

    precision: float
    recall: float
    f1: float
    support: int


class Report(msgspec.Struct, frozen=True):
    """Figures over a set; the weighted F1 is over labels other than O, weighted by support.

    ``entity_f1`` counts whole spans: type and both ends have to be right.
    """

    sentences: int
    tokens: int
    weighted_f1: float
    weighted_f1_with_o: float
    sentence_accuracy: float
    labels: dict[str, LabelScore]
    entity_f1: float


def evaluate(tagger: Tagger, examples: Sequence[Example], batch: int = 64) -> Report:
    """Return the report of a tagger on labelled sentences."""
    right: Counter[str] = Counter()
    said: Counter[str] = Counter()
    gold: Counter[str] = Counter()
    whole = hits = spans = 0
    for start in range(0, len(examples), batch):
        chunk = examples[start : start + batch]
        for example, tagged in zip(chunk, tagger.tag([e.tokens for e in chunk]), strict=True):
            whole += tagged.labels == example.labels
            ours, theirs = _entities(tagged.labels), _entities(example.labels)
            hits += len(ours & theirs)
            spans += len(ours) + len(theirs)
            for want, got in zip(example.labels, tagged.labels, strict=True):
                gold[want] += 1
                said[got] += 1
                right[want] += want == got
    known = dict.fromkeys((*tagger.labels, *sorted(gold)))
    scores = {label: _score(right[label], said[label], gold[label]) for label in known}
    return Report(
        sentences=len(examples),
        tokens=gold.total(),
        weighted_f1=_weighted({k: v for k, v in scores.items() if k != OUTSIDE}),
        weighted_f1_with_o=_weighted(scores),
        sentence_accuracy=whole / max(len(examples), 1),
        labels=scores,
        entity_f1=2 * hits / max(spans, 1),
    )


def _entities(labels: Sequence[str]) -> set[tuple[str, int, int]]:
    spans = spans_of([""] * len(labels), labels, [1.0] * len(labels))
    return {(span.kind, span.start, span.end) for span in spans}


def _score(right: int, said: int, gold: int) -> LabelScore:
    precision = right / said if said else 0.0
    recall = right / gold if gold else 0.0
    f1 = 2 * precision * recall / (precision + recall) if right else 0.0
    return LabelScore(precision, recall, f1, gold)


def _weighted(scores: dict[str, LabelScore]) -> float:
    total = sum(score.support for score in scores.values())
    return sum(score.f1 * score.support for score in scores.values()) / max(total, 1)


def table(report: Report) -> str:
    """Return the report as a Markdown table."""
    rows = ["| label | precision | recall | F1 | tokens |", "|---|---|---|---|---|"]
    rows += [
        f"| {label} | {s.precision:.3f} | {s.recall:.3f} | {s.f1:.3f} | {s.support} |"
        for label, s in report.labels.items()
    ]
    rows.append(
        f"\nWeighted F1 without O {report.weighted_f1:.3f}, with O {report.weighted_f1_with_o:.3f};"
        f" entity F1 {report.entity_f1:.3f};"
        f" sentences all right {report.sentence_accuracy:.3f} of {report.sentences}."
    )
    return "\n".join(rows)


def held_out_examples(seed: int) -> list[Example]:
    """Return sentences of the frames that training never saw."""
    return list(itertools.islice(Generator(seed + 500, held_out=True), HELD_OUT_SENTENCES))


def read_gold(path: Path) -> list[Example]:
    """Return the labelled sentences of a JSON-lines file with ``tokens`` and ``labels``."""
    rows = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]
    return [Example(row["tokens"], row["labels"]) for row in rows]


def main() -> None:
    """Print the table of a tagger."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--model", type=Path, help="directory of a model; default: the shipped one")
    parser.add_argument("--tagger", default="default", help="of the shipped ones")
    parser.add_argument("--gold", type=Path, help="labelled sentences; default: held-out templates")
    parser.add_argument("--seed", type=int, default=7)
    arguments = parser.parse_args()
    examples = read_gold(arguments.gold) if arguments.gold else held_out_examples(arguments.seed)
    print(table(evaluate(load_tagger(arguments.model, arguments.tagger), examples)))


if __name__ == "__main__":
    main()
