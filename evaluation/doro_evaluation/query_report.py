"""Tables III and IV as text and flat figures, with the paper's printed figures beside."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path

import msgspec
from rich.table import Table

from doro_evaluation.figures import Figure
from doro_evaluation.queries import QueryOutcome
from doro_evaluation.scores import QueryScores, Score, score_queries

Row = tuple[str, str]
"""A view (``multi-view``, ``single-view``, ``image``) and a system."""
METRICS = {"qa": "QA", "aa": "AA", "aa_states": "AA, 4 states", "bleu": "BLEU-4"}
PAPER: dict[Row, dict[str, float]] = {
    ("multi-view", "DoRO"): {"qa": 0.77, "aa": 0.91, "bleu": 0.77},
    ("multi-view", "baseline, our aggregator"): {"qa": 0.67, "aa": 0.82, "bleu": 0.56},
    ("multi-view", "baseline, captions joined"): {"qa": 0.07, "aa": 0.51, "bleu": 0.26},
    ("single-view", "DoRO"): {"qa": 0.69, "aa": 0.87, "bleu": 0.71},
    ("single-view", "baseline"): {"qa": 0.37, "aa": 0.90, "bleu": 0.64},
    ("image", "DoRO"): {"qa": 0.85, "aa": 0.94, "bleu": 0.81},
    ("image", "baseline"): {"qa": 0.45, "aa": 0.92, "bleu": 0.75},
}
"""The paper's Tables III and IV as printed."""
VIEWS = {
    "multi-view": "all views merged (Table IV)",
    "single-view": "one view, judged by the room (Table IV)",
    "image": "one view, judged by what it shows (Table III)",
}


def score_all(outcomes: Sequence[QueryOutcome]) -> dict[Row, QueryScores]:
    """Return the figures of every row, views first."""
    rows: dict[Row, list[QueryOutcome]] = defaultdict(list)
    for one in sorted(outcomes, key=lambda one: (one.pair.id, one.system, one.view)):
        rows[one.view, one.system].append(one)
    order = list(VIEWS)
    return {
        row: score_queries(rows[row])
        for row in sorted(rows, key=lambda row: (order.index(row[0]), row[1]))
    }


def figures_of(scores: Mapping[Row, QueryScores]) -> dict[str, Figure]:
    """Return ``<view>/<system>/<metric>`` with the bounds of the 95 % interval."""
    figures: dict[str, Figure] = {}
    for (view, system), row in scores.items():
        figures[f"{view}/{system}/pairs"] = row.pairs
        for metric in (*METRICS, "state_accuracy"):
            score: Score = getattr(row, metric)
            figures[f"{view}/{system}/{metric}"] = round(score.value, 4)
            figures[f"{view}/{system}/{metric}_low"] = round(score.low, 4)
            figures[f"{view}/{system}/{metric}_high"] = round(score.high, 4)
        for fault, count in row.faults.items():
            figures[f"{view}/{system}/faults/{fault.replace(' ', '_')}"] = count
    return figures


def tables_of(scores: Mapping[Row, QueryScores]) -> list[Table]:
    """Return a table for each view: the systems, then the paper's rows."""
    tables = []
    for view, title in VIEWS.items():
        table = Table("system", "pairs", *METRICS.values(), "wrong by", title=title)
        for (where, system), row in scores.items():
            if where == view:
                cells = [_cell(getattr(row, metric)) for metric in METRICS]
                faults = ", ".join(f"{name} {count}" for name, count in row.faults.items())
                table.add_row(system, str(row.pairs), *cells, faults)
        table.add_section()
        for (where, system), printed in PAPER.items():
            if where == view:
                cells = [f"{printed[m]:.2f}" if m in printed else "" for m in METRICS]
                table.add_row(f"paper: {system}", "600", *cells, "")
        if table.row_count > sum(where == view for where, _ in PAPER):
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


def _cell(score: Score) -> str:
    return f"{score.value:.3f} [{score.low:.2f}, {score.high:.2f}]"
