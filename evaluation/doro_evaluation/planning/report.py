"""Views needed: the table, the flat figures and the plot of planned against other orders."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure as Plot
from rich.box import SIMPLE_HEAD
from rich.table import Table

from doro_evaluation.counting.metrics import measure
from doro_evaluation.figures import Figure
from doro_evaluation.planning.curve import DONE, ORDERS, PLANNED, RANDOM, RECORDED, THIRD, Point

Statistic = Callable[[Sequence[Point]], float]
SHORT = {PLANNED: "plan", RECORDED: "rec", RANDOM: "rand"}
LOOK = {PLANNED: ("C0", "o-"), RECORDED: ("C2", "s--"), RANDOM: ("C1", "^-")}
METRICS: dict[str, Statistic] = {
    "f1": lambda points: measure([point.outcome for point in points])["average/f1"],
    "accuracy": lambda points: measure([point.outcome for point in points])["accuracy"],
    "coverage": lambda points: _mean(point.coverage for point in points),
    "views": lambda points: _mean(point.views for point in points),
    "travel_m": lambda points: _mean(point.travel_m for point in points),
}


def _mean(values: object) -> float:
    found = np.fromiter(values, np.float64)  # type: ignore[call-overload]
    return float(found.mean()) if len(found) else math.nan


def chosen(points: Sequence[Point], order: str, share: float) -> list[list[Point]]:
    """Return the points of an order at a share, a list per seed."""
    seeds = sorted({point.seed for point in points if point.order == order})
    return [
        [
            point
            for point in points
            if (point.order, point.seed, point.share) == (order, seed, share)
        ]
        for seed in seeds
    ]


def value(points: Sequence[Point], order: str, share: float, metric: str) -> float:
    """Return a metric of an order at a share, the mean over its seeds; nan where it is not."""
    groups = [group for group in chosen(points, order, share) if group]
    return _mean(METRICS[metric](group) for group in groups)


def shares_of(points: Sequence[Point]) -> list[float]:
    """Return the marks, ascending."""
    return sorted({point.share for point in points if point.share != DONE})


def figures_of(points: Sequence[Point]) -> dict[str, Figure]:
    """Return ``planning/<order>/<percent>/<metric>``, and what the promise is about."""
    figures: dict[str, Figure] = {}
    for order in ORDERS:
        for share in shares_of(points):
            for metric in METRICS:
                figure = value(points, order, share, metric)
                if not math.isnan(figure):
                    figures[f"planning/{order}/{_percent(share)}/{metric}"] = round(figure, 4)
    whole = value(points, RECORDED, 1.0, "f1")
    figures["planning/planned/third/f1_minus_all_views"] = round(
        value(points, PLANNED, THIRD, "f1") - whole, 4
    )
    figures["planning/random/third/f1_minus_all_views"] = round(
        value(points, RANDOM, THIRD, "f1") - whole, 4
    )
    done = [point for point in points if point.share == DONE]
    rooms = sum(point.order == PLANNED and point.share == 1.0 for point in points)
    if done and rooms:
        figures["planning/planned/done/recordings_share"] = round(len(done) / rooms, 4)
        figures["planning/planned/done/views_share"] = round(
            _mean(point.views / point.of_views for point in done), 4
        )
    goal_ms = [point.goal_ms for point in points if point.order == PLANNED]
    if goal_ms:
        figures["planning/planned/goal_p50_ms"] = round(float(np.nanmedian(goal_ms)), 3)
    figures["planning/recordings"] = len({point.outcome.recording for point in points})
    return figures


def _percent(share: float) -> str:
    return f"{100 * share:.0f}"


def table_of(points: Sequence[Point]) -> Table:
    """Return the table: a row per share of the views, each order's metrics."""
    recordings = len({point.outcome.recording for point in points})
    table = Table(
        title=f"Counting after a part of the views, {recordings} recordings", box=SIMPLE_HEAD
    )
    table.add_column("views", justify="right", no_wrap=True)
    columns = {"f1": "F1", "accuracy": "exact", "coverage": "seen", "travel_m": "way, m"}
    table.padding = (0, 0)
    for title in columns.values():
        for order in ORDERS:
            head = title if order == ORDERS[0] else ""
            table.add_column(f"{head}\n{SHORT[order]}", justify="right", no_wrap=True)
    for share in shares_of(points):
        cells = [f"{_percent(share)} %"]
        for metric in columns:
            form = ".0f" if metric == "travel_m" else ".3f"
            cells += [f"{value(points, order, share, metric):{form}}" for order in ORDERS]
        table.add_row(*cells)
    return table


def plot(path: Path, points: Sequence[Point]) -> None:
    """Draw F1, exact counts and coverage against the share of the views, into a PNG.

    The band of the random order spans its seeds.
    """
    titles = {"f1": "F1, count as class", "accuracy": "exact counts", "coverage": "area seen"}
    figure = Plot(figsize=(11, 3.4), layout="constrained")
    axes = figure.subplots(1, len(titles))
    shares = shares_of(points)
    across = [100 * share for share in shares]
    for axis, (metric, title) in zip(axes, titles.items(), strict=True):
        for order in ORDERS:
            color, style = LOOK[order]
            line = [value(points, order, share, metric) for share in shares]
            known = [(x, y) for x, y in zip(across, line, strict=True) if not math.isnan(y)]
            axis.plot(*zip(*known, strict=True), style, color=color, label=order, markersize=4)
        low, high = _band(points, shares, metric)
        axis.fill_between(across, low, high, color=LOOK[RANDOM][0], alpha=0.2, linewidth=0)
        axis.axvline(100 * THIRD, color="gray", linewidth=0.8, linestyle=":")
        axis.set(xlabel="views taken, % of the recording", title=title)
        axis.grid(alpha=0.3)
    whole = value(points, RECORDED, 1.0, "f1")
    axes[0].axhline(whole, color="black", linewidth=0.8, linestyle=":", label="all views")
    axes[0].legend(loc="lower right", fontsize=8)
    path.parent.mkdir(parents=True, exist_ok=True)
    FigureCanvasAgg(figure)
    figure.savefig(path, dpi=100)


def _band(
    points: Sequence[Point], shares: Sequence[float], metric: str
) -> tuple[list[float], list[float]]:
    low, high = [], []
    for share in shares:
        values = [METRICS[metric](group) for group in chosen(points, RANDOM, share) if group]
        low.append(min(values, default=math.nan))
        high.append(max(values, default=math.nan))
    return low, high
