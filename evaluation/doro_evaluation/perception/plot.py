"""The reliability plot: how often detections of a score are right."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from doro_evaluation.perception.scores import calibration_error, reliability


def draw_reliability(path: Path, sets: Mapping[str, Sequence[tuple[float, bool]]]) -> None:
    """Write a PNG with a curve for each set of (score, right) pairs."""
    figure = Figure(figsize=(5, 5), dpi=120)
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    axes.plot([0, 1], [0, 1], color="0.7", linewidth=1)
    for name, certain in sets.items():
        rows = reliability(certain)
        label = f"{name}: {len(certain)} detections, error {calibration_error(certain):.3f}"
        axes.plot([row[0] for row in rows], [row[1] for row in rows], marker="o", label=label)
    axes.set_xlabel("score")
    axes.set_ylabel("share that is right (name and IoU 0.5)")
    axes.set_xlim(0, 1)
    axes.set_ylim(0, 1)
    axes.legend(loc="upper left", fontsize="small")
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, metadata={"Software": ""})
