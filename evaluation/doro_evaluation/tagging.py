"""Tagging: F1 per label of each tagger (paper, Section V-A, Table I)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from rich.table import Table

from doro_evaluation.figures import Figure
from doro_nlu.labels import LABELS
from doro_nlu.tagger import Tagger, load_tagger
from doro_nlu.train.annotate import Example
from doro_nlu.train.evaluate import Report, evaluate, held_out_examples, read_gold

SHIPPED = ("default", "bilstm")
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
