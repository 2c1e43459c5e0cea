"""The report's plots, made of flat figures, as PNG."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure as Plot

from doro_evaluation.counting.metrics import COUNTS
from doro_evaluation.counting.reasons import BINS
from doro_evaluation.counting.report import PAPER_F1
from doro_evaluation.figures import Figure
from doro_evaluation.report.grids import ERRORS, PAPER_AVERAGE, SYSTEMS

Figures = Mapping[str, Figure]
COLORS = {"ours": "#08519c", "paper_literal": "#d94801", "the paper": "#555555"}
PANELS = ("gt", "cs+sd+fn", "fp", "all")
DPI = 80


def plots(figures: Figures) -> dict[str, tuple[str, bytes]]:
    """Return by file name a caption and the PNG, of those plots that there are figures for."""
    made = {
        "f1_by_count.png": (
            "F1 with the count as class against the true count, 95 % intervals over rooms.",
            f1_by_count(figures),
        ),
        "f1_by_error.png": ("Average F1 against the detector's errors.", f1_by_error(figures)),
        "found_by_views.png": (
            "Share of the true instances found (within 0.5 m) against the number of views that"
            " show them; numbers of instances above the axis.",
            found_by_views(figures),
        ),
    }
    return {name: (caption, png) for name, (caption, png) in made.items() if png}


def f1_by_count(figures: Figures) -> bytes:
    """Draw F1 against the true count, a panel for each of four error models."""
    shown = [errors for errors in PANELS if f"counting/ours/{errors}/1/f1" in figures]
    if not shown:
        return b""
    plot = Plot(figsize=(3.2 * len(shown), 3.2), layout="constrained")
    axes: Sequence[Axes] = plot.subplots(1, len(shown), sharey=True, squeeze=False)[0]
    for axis, errors in zip(axes, shown, strict=True):
        for system in SYSTEMS:
            names = [f"counting/{system}/{errors}/{k}/f1" for k in COUNTS]
            _line(axis, figures, list(COUNTS), names, system)
        if errors in PAPER_F1:
            printed = [np.nan if one is None else one for one in PAPER_F1[errors]]
            axis.plot(COUNTS, printed, ".--", color=COLORS["the paper"], label="the paper")
        axis.set(title=ERRORS[errors], xlabel="true count", xticks=COUNTS, ylim=(-0.02, 1.03))
    axes[0].set_ylabel("F1")
    _legend(plot, axes[0])
    return _png(plot)


def f1_by_error(figures: Figures) -> bytes:
    """Draw the average F1 of each error model as bars."""
    shown = [errors for errors in ERRORS if f"counting/ours/{errors}/average/f1" in figures]
    if not shown:
        return b""
    plot = Plot(figsize=(7.5, 3.2), layout="constrained")
    axis: Axes = plot.subplots()
    place = np.arange(len(shown))
    for shift, system in enumerate((*SYSTEMS, "the paper")):
        values, below, above = [], [], []
        for errors in shown:
            name = f"counting/{system}/{errors}/average/f1"
            own = figures.get(name, PAPER_AVERAGE.get(errors) if system == "the paper" else None)
            value = np.nan if own is None else float(own)
            values.append(value)
            below.append(value - float(figures.get(f"{name}_low", value)))
            above.append(float(figures.get(f"{name}_high", value)) - value)
        at = place + (shift - 1) * 0.27
        axis.bar(at, values, 0.25, yerr=(below, above), color=COLORS[system], label=system)
    axis.set_xticks(place, [ERRORS[errors].replace(" (", "\n(") for errors in shown], fontsize=8)
    axis.set(ylabel="average F1", ylim=(0, 1.03))
    axis.legend(loc="upper center", bbox_to_anchor=(0.5, 1.14), ncols=3, fontsize=8)
    return _png(plot)


def found_by_views(figures: Figures) -> bytes:
    """Draw the share of instances found against the number of views that show them."""
    shown = [e for e in ("gt", "cs+sd+fn", "all") if f"seen/ours/{e}/{BINS[-2]}/found" in figures]
    if not shown:
        return b""
    plot = Plot(figsize=(3.6 * len(shown), 3.2), layout="constrained")
    axes: Sequence[Axes] = plot.subplots(1, len(shown), sharey=True, squeeze=False)[0]
    ends = [*(end - 1 for end in BINS[1:]), 0]
    labels = [
        f"{low}" if low == high else f"{low}-{high}" if high else f"{low}+"
        for low, high in zip(BINS, ends, strict=True)
    ]
    for axis, errors in zip(axes, shown, strict=True):
        for system in SYSTEMS:
            names = [f"seen/{system}/{errors}/{least}/found" for least in BINS]
            _line(axis, figures, list(range(len(BINS))), names, system)
        for k, least in enumerate(BINS):
            count = figures.get(f"seen/ours/{errors}/{least}/things", 0)
            axis.annotate(str(count), (k, 0.01), ha="center", fontsize=7, color="#555555")
        axis.set_xticks(range(len(BINS)), labels, fontsize=8)
        axis.set(title=ERRORS[errors], xlabel="views that show it", ylim=(-0.02, 1.03))
    axes[0].set_ylabel("found")
    _legend(plot, axes[0])
    return _png(plot)


def _line(
    axis: Axes, figures: Figures, at: Sequence[float], names: Sequence[str], system: str
) -> None:
    there = [(x, name) for x, name in zip(at, names, strict=True) if name in figures]
    if not there:
        return
    values = np.array([float(figures[name]) for _, name in there])
    low = np.array([float(figures.get(f"{name}_low", figures[name])) for _, name in there])
    high = np.array([float(figures.get(f"{name}_high", figures[name])) for _, name in there])
    spans = np.maximum(0, [values - low, high - values])
    where = [x for x, _ in there]
    axis.errorbar(where, values, spans, fmt="o-", color=COLORS[system], capsize=2, label=system)


def _legend(plot: Plot, axis: Axes) -> None:
    """Write who is who above all panels, where it covers nothing."""
    lines, names = axis.get_legend_handles_labels()
    plot.legend(lines, names, loc="outside upper center", ncols=len(names), fontsize=8)


def _png(plot: Plot) -> bytes:
    FigureCanvasAgg(plot)
    file = io.BytesIO()
    # Without the version of the library the same figures give the same bytes.
    plot.savefig(file, dpi=DPI, format="png", metadata={"Software": None})
    return file.getvalue()
