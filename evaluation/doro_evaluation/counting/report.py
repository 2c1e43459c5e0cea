"""Counting as tables, flat figures, list of failures and pictures."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure as Plot
from matplotlib.patches import Rectangle
from rich.table import Table

from doro_evaluation.counting.metrics import COUNTS, intervals, items, measure
from doro_evaluation.figures import Figure
from doro_evaluation.outcomes import Outcome, Thing

PAPER_F1: dict[str, tuple[float | None, ...]] = {
    "gt": (0.97, 0.88, 0.84, 0.55, 0.67),
    "cs": (0.95, 0.84, 0.83, None, None),
    "cs+sd": (0.95, 0.87, 0.80, None, None),
    "cs+sd+fn": (0.95, 0.81, 0.76, None, None),
    "fp": (0.88, 0.58, 0.53, 0.01, 0.01),
}
"""Table II of the paper; 4 and 5 are rows that its source has commented out."""
GALLERY = 12

Runs = Mapping[tuple[str, str], Sequence[Outcome]]
"""Outcomes by (system, error model)."""
Figures = dict[str, Figure]


class Failure(msgspec.Struct, frozen=True):
    """An item that was counted wrongly."""

    recording: str
    object_type: str
    errors: str
    system: str
    true: int
    found: int


def grouped(outcomes: Sequence[Outcome]) -> dict[tuple[str, str], list[Outcome]]:
    """Return the outcomes by (system, error model), each in order of recordings."""
    runs: dict[tuple[str, str], list[Outcome]] = {}
    for outcome in sorted(outcomes, key=lambda one: one.recording):
        runs.setdefault((outcome.system, outcome.errors), []).append(outcome)
    return runs


def figures_of(runs: Runs, min_views: int = 1, prefix: str = "counting") -> Figures:
    """Return the flat figures ``counting/system/errors/metric``, intervals beside them."""
    figures: Figures = {}
    for (system, errors), outcomes in runs.items():
        name = f"{prefix}/{system}/{errors}"
        for metric, value in measure(outcomes, min_views).items():
            if np.isfinite(value):
                whole = metric.endswith("items")
                figures[f"{name}/{metric}"] = int(value) if whole else round(value, 4)
        for metric, (low, high) in intervals(outcomes, min_views).items():
            figures[f"{name}/{metric}_low"] = round(low, 4)
            figures[f"{name}/{metric}_high"] = round(high, 4)
        figures[f"{name}/recordings"] = len(outcomes)
    return figures


def tables_of(runs: Runs, min_views: int = 1) -> Iterator[Table]:
    """Yield the table of F1 per count, with the paper's, and the table of the other metrics."""
    first = Table(title="Counting, F1 with the count as class (items); the paper's below")
    for head in ("errors", "system", *(str(k) for k in COUNTS), "average", "95 %"):
        first.add_column(head)
    second = Table(title="Counting, other metrics")
    for head in ("errors", "system", "exact", "MAE", "matched F1 0.5 m", "0.25 m"):
        second.add_column(head)
    second.add_column("centre error, furniture: median, 90 %")
    second.add_column("other things")
    for errors in dict.fromkeys(errors for _, errors in runs):
        for (system, own), outcomes in runs.items():
            if own == errors:
                values, spans = measure(outcomes, min_views), intervals(outcomes, min_views)
                first.add_row(errors, system, *_scores(values), _span(spans["average/f1"]))
                second.add_row(errors, system, *_others(values))
        if errors in PAPER_F1:
            printed = ["-" if value is None else f"{value:.2f}" for value in PAPER_F1[errors]]
            first.add_row(errors, "the paper", *printed, "", "")
    yield first
    yield second


def failures_of(runs: Runs, min_views: int = 1) -> list[Failure]:
    """Return all items counted wrongly, in order."""
    return [
        Failure(item.recording, item.object_type, errors, system, item.true, item.found)
        for (system, errors), outcomes in runs.items()
        for outcome in outcomes
        for item in items(outcome, min_views)
        if item.true != item.found
    ]


def write_failures(path: Path, runs: Runs, min_views: int = 1) -> None:
    """Write the failures as JSON lines, and some of them as a picture beside it."""
    lines = [msgspec.json.encode(failure) + b"\n" for failure in failures_of(runs, min_views)]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(b"".join(lines))
    plot_failures(path.with_suffix(".png"), runs, min_views)


def plot_counts(path: Path, runs: Runs, min_views: int = 1) -> None:
    """Draw F1 against the true count, a panel per error model, a line per system."""
    errors = list(dict.fromkeys(name for _, name in runs))
    plot = Plot(figsize=(3.1 * len(errors), 3.2), layout="constrained")
    axes: Sequence[Axes] = plot.subplots(1, len(errors), sharey=True, squeeze=False)[0]
    for axis, name in zip(axes, errors, strict=True):
        for (system, own), outcomes in runs.items():
            if own == name:
                values = measure(outcomes, min_views)
                axis.plot(COUNTS, [values[f"{k}/f1"] for k in COUNTS], "o-", label=system)
        if name in PAPER_F1:
            printed = [np.nan if value is None else value for value in PAPER_F1[name]]
            axis.plot(COUNTS, printed, "k.--", label="the paper")
        axis.set(title=name, xlabel="true count", xticks=COUNTS, ylim=(-0.02, 1.03))
    axes[0].set_ylabel("F1, count as class")
    axes[-1].legend(loc="lower left", fontsize=8)
    _save(path, plot)


def plot_failures(path: Path, runs: Runs, min_views: int = 1) -> int:
    """Draw failures from above, true boxes filled and found ones outlined; return how many."""
    wrong = failures_of(runs, min_views)[:GALLERY]
    if not wrong:
        return 0
    columns = min(4, len(wrong))
    rows = -(-len(wrong) // columns)
    plot = Plot(figsize=(3.4 * columns, 3.5 * rows), layout="constrained")
    axes = plot.subplots(rows, columns, squeeze=False).ravel()
    by_name = {
        (system, errors, one.recording): one
        for (system, errors), outcomes in runs.items()
        for one in outcomes
    }
    for axis, failure in zip(axes, wrong, strict=False):
        outcome = by_name[failure.system, failure.errors, failure.recording]
        _draw(axis, outcome, failure)
    for axis in axes[len(wrong) :]:
        axis.set_axis_off()
    _save(path, plot)
    return len(wrong)


def _draw(axis: Axes, outcome: Outcome, failure: Failure) -> None:
    true_style: dict[str, Any] = {"facecolor": "#9ecae1", "edgecolor": "none"}
    found_style: dict[str, Any] = {"fill": False, "edgecolor": "#cb181d", "linewidth": 1.4}
    for things, style in ((outcome.truth, true_style), (outcome.found, found_style)):
        for thing in things:
            if thing.object_type == failure.object_type:
                axis.add_patch(_footprint(thing, style))
                axis.annotate(str(thing.views), (thing.center_m[0], thing.center_m[2]), fontsize=6)
    axis.set_title(
        f"{failure.recording}\n{failure.object_type}, {failure.errors}, {failure.system}:"
        f" {failure.true} true, {failure.found} found",
        fontsize=7,
    )
    axis.autoscale_view()
    axis.set_aspect("equal", adjustable="datalim")
    axis.tick_params(labelsize=6)


def _footprint(thing: Thing, style: dict[str, Any]) -> Rectangle:
    (x, _, z), (width, _, depth) = thing.center_m, thing.size_m
    return Rectangle((x - width / 2, z - depth / 2), width, depth, **style)


def _save(path: Path, plot: Plot) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    FigureCanvasAgg(plot)
    plot.savefig(path, dpi=100)


def _scores(values: Mapping[str, float]) -> list[str]:
    cells = [
        f"{values[f'{k}/f1']:.3f} ({values[f'{k}/items']:.0f})" if values[f"{k}/items"] else "-"
        for k in COUNTS
    ]
    return [*cells, f"{values['average/f1']:.3f} ({values['average/items']:.0f})"]


def _others(values: Mapping[str, float]) -> list[str]:
    return [
        f"{values['accuracy']:.3f}",
        f"{values['mae']:.3f}",
        f"{values['matched_f1_0.5m']:.3f}",
        f"{values['matched_f1_0.25m']:.3f}",
        *(
            f"{values[f'center_error_{kind}_median_m']:.3f},"
            f" {values[f'center_error_{kind}_p90_m']:.3f} m"
            for kind in ("furniture", "others")
        ),
    ]


def _span(span: tuple[float, float]) -> str:
    return f"{span[0]:.3f}-{span[1]:.3f}"
