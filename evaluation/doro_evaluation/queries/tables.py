"""Tables III and IV as text and flat figures, with the paper's printed figures beside."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import msgspec
from rich.table import Table

from doro_evaluation.bootstrap import Score
from doro_evaluation.figures import Figure
from doro_evaluation.queries.scores import QueryScores, score_queries
from doro_evaluation.queries.systems import QueryOutcome

Row = tuple[str, str]
"""A table (``single-view``: Table III, ``multi-view``: Table IV) and a system in it."""
METRICS = {
    "qa": "QA",
    "aa": "AA",
    "aa_states": "AA, 4 states",
    "bleu": "BLEU-4",
    "bertscore": "BERTScore",
    "cosine": "cosine",
}
PAPER: dict[Row, dict[str, float]] = {
    ("single-view", "ours"): {"qa": 0.85, "aa": 0.94, "bleu": 0.81, "bertscore": 0.90},
    ("single-view", "baseline"): {"qa": 0.45, "aa": 0.92, "bleu": 0.75, "bertscore": 0.82},
    ("multi-view", "ours"): {"qa": 0.77, "aa": 0.91, "bleu": 0.77, "bertscore": 0.87},
    ("multi-view", "ours_one_view"): {"qa": 0.69, "aa": 0.87, "bleu": 0.71, "bertscore": 0.84},
    ("multi-view", "baseline_one_view"): {"qa": 0.37, "aa": 0.90, "bleu": 0.64, "bertscore": 0.70},
    ("multi-view", "baseline_captions"): {"qa": 0.07, "aa": 0.51, "bleu": 0.26, "bertscore": 0.36},
    ("multi-view", "baseline_aggregated"): {
        "qa": 0.67,
        "aa": 0.82,
        "bleu": 0.56,
        "bertscore": 0.69,
    },
}
"""The paper's Tables III and IV as printed; "ours" are its rows of DoRO."""
TABLES = {
    "single-view": "Table III: one view, judged by what the detector delivered of it",
    "multi-view": "Table IV: all views merged; one view: judged by the whole room",
}
SUFFIX = {
    "single-view": "",
    "single-view-shown": "_shown",
    "multi-view": "",
    "one-view": "_one_view",
}
NAMES = {
    "ours": "ours",
    "ours_shown": "ours, judged by all that the view shows",
    "ours_one_view": "ours, one view",
    "paper_literal": "paper_literal",
    "paper_literal_shown": "paper_literal, judged by all that the view shows",
    "paper_literal_one_view": "paper_literal, one view",
    "baseline": "baseline",
    "baseline_shown": "baseline, judged by all that the view shows",
    "baseline_one_view": "baseline, one view",
    "baseline_captions": "baseline, all views' captions joined",
    "baseline_aggregated": "baseline, our aggregation as text",
}
"""Rows of both tables in their order."""
BASELINE_ROWS: tuple[Row, ...] = (
    ("single-view", "baseline"),
    ("multi-view", "baseline_one_view"),
    ("multi-view", "baseline_captions"),
    ("multi-view", "baseline_aggregated"),
)


def row_of(view: str, system: str) -> Row:
    """Return the table and the row of it that a view and a system give."""
    table = "single-view" if view.startswith("single-view") else "multi-view"
    return table, system + SUFFIX[view]


def score_all(outcomes: Sequence[QueryOutcome]) -> dict[Row, QueryScores]:
    """Return the figures of every row, in the order of the tables."""
    rows: dict[Row, list[QueryOutcome]] = defaultdict(list)
    for one in sorted(outcomes, key=lambda one: (one.pair.id, one.system, one.view)):
        rows[row_of(one.view, one.system)].append(one)
    ordered = sorted(rows, key=lambda row: (list(TABLES).index(row[0]), list(NAMES).index(row[1])))
    return {row: score_queries(rows[row]) for row in ordered}


def figures_of(scores: Mapping[Row, QueryScores]) -> dict[str, Figure]:
    """Return ``<table>/<system>/<metric>`` with the bounds of the 95 % interval."""
    figures: dict[str, Figure] = {}
    for (table, system), row in scores.items():
        name = f"{table}/{system}"
        figures[f"{name}/pairs"] = row.pairs
        for metric in (*METRICS, "state_accuracy"):
            score: Score | None = getattr(row, metric)
            if score is not None:
                figures[f"{name}/{metric}"] = round(score.value, 4)
                figures[f"{name}/{metric}_low"] = round(score.low, 4)
                figures[f"{name}/{metric}_high"] = round(score.high, 4)
        for fault, count in row.faults.items():
            figures[f"{name}/faults/{fault.replace(' ', '_')}"] = count
    return figures


def tables_of(
    scores: Mapping[Row, QueryScores], missing: str = "", only: Iterable[str] = tuple(TABLES)
) -> list[Table]:
    """Return each table: our systems, what is missing of the baseline, then the paper's rows.

    Args:
        missing: why rows of the baseline are not there, with the command that makes it.
        only: which tables.
    """
    tables = []
    for name in only:
        table = Table("system", "pairs", *METRICS.values(), "wrong by", title=TABLES[name])
        for (own, system), row in scores.items():
            if own == name:
                cells = [_cell(getattr(row, metric)) for metric in METRICS]
                faults = ", ".join(f"{fault} {count}" for fault, count in row.faults.items())
                table.add_row(NAMES[system], str(row.pairs), *cells, faults)
        for row_name in BASELINE_ROWS if missing else ():
            if row_name[0] == name and row_name not in scores:
                table.add_row(NAMES[row_name[1]], "", *[""] * len(METRICS), missing)
        table.add_section()
        for (own, system), printed in PAPER.items():
            if own == name:
                label = NAMES[system].replace("ours", "DoRO")
                cells = [f"{printed[m]:.2f}" if m in printed else "" for m in METRICS]
                table.add_row(f"paper: {label}", "600", *cells, "")
        tables.append(table)
    return tables


def write_cases(path: Path, outcomes: Sequence[QueryOutcome]) -> int:
    """Write every pair with what was said, what is true and why it is wrong, as JSON lines."""
    lines = []
    for one in sorted(outcomes, key=lambda one: (one.view, one.system, one.pair.id)):
        verdict = one.verdict
        lines.append(
            msgspec.json.encode(
                {
                    "id": one.pair.id,
                    "view": one.view,
                    "system": one.system,
                    "instruction": one.pair.instruction,
                    "said": verdict.text,
                    "state": verdict.said,
                    "true_state": verdict.true,
                    "fault": verdict.fault,
                    "reference": verdict.references[0] if verdict.references else "",
                }
            )
        )
    path.write_bytes(b"\n".join(lines) + b"\n")
    return len(lines)


def _cell(score: Score | None) -> str:
    return "" if score is None else f"{score.value:.3f} [{score.low:.2f}, {score.high:.2f}]"
