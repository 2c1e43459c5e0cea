"""Draw the loss curve of a baseline: ``python -m doro_evaluation.baseline.curve``."""

from __future__ import annotations

import argparse
from pathlib import Path

import matplotlib as mpl
import msgspec
from matplotlib.figure import Figure

from doro_evaluation.baseline.model import MODEL_DIR

LOG, PLOT = "training.json", "loss.png"


class Point(msgspec.Struct, frozen=True):
    """A point of ``training.json``: cross entropy per piece; ``held_out`` now and then."""

    step: int
    loss: float
    held_out: float | None
    cpu_s: float


def draw(directory: Path) -> Path:
    """Write ``loss.png`` beside ``training.json`` and return its path."""
    points = msgspec.json.decode((directory / LOG).read_bytes(), type=list[Point])
    measured = [point for point in points if point.held_out is not None]
    with mpl.rc_context({"font.size": 9}):
        figure = Figure(figsize=(6, 3.2), layout="constrained")
        axes = figure.subplots()
        axes.plot([p.step for p in points], [p.loss for p in points], label="training")
        axes.plot([p.step for p in measured], [p.held_out or 0.0 for p in measured], "o-",
                  markersize=3, label="held out")  # fmt: skip
        axes.set_yscale("log")
        axes.set_xlabel(f"step ({points[-1].cpu_s / 60:.0f} minutes of CPU time in all)")
        axes.set_ylabel("cross entropy per piece")
        axes.grid(alpha=0.3, which="both")
        axes.legend()
        figure.savefig(directory / PLOT, dpi=110, metadata={"Software": None})
    return directory / PLOT


def main() -> None:
    """Draw."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--model", type=Path, default=MODEL_DIR)
    print(draw(parser.parse_args().model))


if __name__ == "__main__":
    main()
