"""Tagging: F1 per label of each tagger (paper, Section V-A, Table I)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rich.table import Table

from doro_evaluation.bootstrap import Score, f1, share, tallied
from doro_evaluation.figures import Figure
from doro_nlu.labels import LABELS, OUTSIDE
from doro_nlu.tagger import Tagger, load_tagger
from doro_nlu.train.annotate import Example
from doro_nlu.train.evaluate import Report, evaluate, held_out_examples, read_gold

SHIPPED = ("default", "bilstm")
BATCH = 64
GENERATED, GOLD = "generated", "gold_dev"
SUMMARIES = {
    "weighted F1 without O": "weighted_f1",
    "weighted F1 with O": "weighted_f1_with_o",
    "entity F1": "entity_f1",
    "sentences all right": "sentence_accuracy",
}

Reports = dict[tuple[str, str], Report]
"""Reports by (name of the tagger, name of the test set)."""


def load_taggers(bert_base: Path | None) -> dict[str, Tagger]:
    """Return the shipped taggers, and bert-base where its directory is given.

    Raises:
        Refused: a model cannot be loaded.
    """
    taggers = {name: load_tagger(None, name) for name in SHIPPED}
    if bert_base is not None:
        taggers["bert-base"] = load_tagger(bert_base)
    return taggers


def test_sets(seed: int, gold: Path | None) -> dict[str, list[Example]]:
    """Return the labelled test sentences by name.

    Args:
        seed: of the generated sentences, whose templates no training uses.
        gold: JSON lines with ``tokens`` and ``labels``; None leaves that set out.
    """
    sets = {GENERATED: held_out_examples(seed)}
    if gold is not None:
        sets[GOLD] = read_gold(gold)
    return sets


def score(
    taggers: Mapping[str, Tagger], sets: Mapping[str, Sequence[Example]]
) -> Iterator[tuple[tuple[str, str], Report]]:
    """Yield the report of each tagger on each set, as they are done."""
    for name, tagger in taggers.items():
        for where, examples in sets.items():
            yield (name, where), evaluate(tagger, examples)


def intervals(tagger: Tagger, examples: Sequence[Example], seed: int = 0) -> dict[str, Score]:
    """Return by metric the 95 % interval over sentences: each label's F1 and the weighted ones."""
    labels = list(dict.fromkeys((*tagger.labels, *LABELS)))
    place = {label: k for k, label in enumerate(labels)}
    counts = np.zeros((len(examples), 3, len(labels)))
    whole = np.zeros(len(examples))
    for start in range(0, len(examples), BATCH):
        chunk = examples[start : start + BATCH]
        for row, tagged in enumerate(tagger.tag([e.tokens for e in chunk]), start):
            wanted = examples[row].labels
            whole[row] = tagged.labels == wanted
            for want, got in zip(wanted, tagged.labels, strict=True):
                counts[row, 0, place[want]] += want == got
                counts[row, 1, place[got]] += 1
                counts[row, 2, place[want]] += 1
    flat = counts.reshape(len(examples), -1)
    inside = [k for k, label in enumerate(labels) if label != OUTSIDE]
    found = {
        "weighted_f1": tallied(flat, partial(_weighted, kept=inside), seed),
        "weighted_f1_with_o": tallied(flat, partial(_weighted, kept=range(len(labels))), seed),
        "sentence_accuracy": tallied(np.column_stack([whole, np.ones(len(whole))]), share, seed),
    }
    for label, k in place.items():
        if counts[:, 2, k].any():
            found[f"{label}/f1"] = tallied(counts[:, :, k], f1, seed)
    return found


def _weighted(sums: NDArray[np.float64], kept: Sequence[int]) -> NDArray[np.float64]:
    """Return the F1 over labels, weighted by their true number, of summed counts."""
    right, said, true = np.moveaxis(sums.reshape(len(sums), 3, -1)[:, :, list(kept)], 1, 0)
    each = 2 * right / np.maximum(said + true, 1)
    return np.asarray((each * true).sum(axis=1) / true.sum(axis=1))


def interval_figures(found: Mapping[tuple[str, str], Mapping[str, Score]]) -> dict[str, Figure]:
    """Return the bounds as flat figures, ``tagging/<tagger>/<set>/<metric>_low`` and ``_high``."""
    return {
        f"tagging/{name}/{where}/{metric}_{bound}": round(getattr(score, bound), 4)
        for (name, where), scores in found.items()
        for metric, score in scores.items()
        for bound in ("low", "high")
    }


def figures_of(reports: Reports) -> dict[str, Figure]:
    """Return the reports as flat figures, ``tagging/<tagger>/<set>/<metric>``."""
    figures: dict[str, Figure] = {}
    for (name, where), report in reports.items():
        start = f"tagging/{name}/{where}"
        for metric in SUMMARIES.values():
            figures[f"{start}/{metric}"] = round(getattr(report, metric), 4)
        figures[f"{start}/sentences"] = report.sentences
        figures[f"{start}/tokens"] = report.tokens
        for label, scored in report.labels.items():
            if scored.support:
                figures[f"{start}/{label}/f1"] = round(scored.f1, 4)
                figures[f"{start}/{label}/tokens"] = scored.support
    return figures


def table_of(reports: Reports) -> Table:
    """Return the table: a row per label with the F1 of each tagger and set, as the paper's."""
    columns = list(reports)
    table = Table(title="F1 per label (paper, Table I: weighted .94 BERT, .93 Bi-LSTM)")
    table.add_column("label")
    for where in dict.fromkeys(where for _, where in columns):
        table.add_column(f"tokens\n{where}", justify="right")
    for name, where in columns:
        table.add_column(f"{name}\n{where}", justify="right")
    for label in LABELS:
        supports = {where: reports[name, where].labels[label].support for name, where in columns}
        cells = [
            f"{reports[key].labels[label].f1:.3f}" if supports[key[1]] else "-" for key in columns
        ]
        table.add_row(label, *(str(count) for count in supports.values()), *cells)
    table.add_section()
    blanks = [""] * len({where for _, where in columns})
    for title, metric in SUMMARIES.items():
        cells = [f"{getattr(reports[key], metric):.3f}" for key in columns]
        table.add_row(title, *blanks, *cells)
    return table
