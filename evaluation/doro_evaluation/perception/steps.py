"""What each step of training gave: the table of the perception README and its picture.

``python -m doro_evaluation.perception.steps`` prints the table and draws the picture from
``evaluation/results/perception_steps.json``, where each row is one ``doro eval perception``.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import msgspec
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from doro_schemas.errors import Refused

RESULTS = Path(__file__).resolve().parents[2] / "results"
STEPS_FILE, PICTURE = RESULTS / "perception_steps.json", RESULTS / "perception_steps.png"
TARGETS = {
    "rendered_map": ("mAP@.5, rendered", 0.60),
    "rendered_top3": ("name among three, rendered", 0.92),
    "material": ("material, rendered", 0.85),
    "real_map": ("mAP@.5, real frames", 0.45),
    "real_top3": ("name among three, real frames", 0.85),
}


class Step(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What was changed, and the figures afterwards.

    Attributes:
        trained: samples of the proposer / of the crop nets.
        changed: in words.
        rendered_map, rendered_top3, colour, material: of rendered held-out rooms.
        real_map, real_top3: of the hand-checked boxes of real frames.
    """

    trained: str
    changed: str
    rendered_map: float
    rendered_top3: float
    colour: float
    material: float
    real_map: float
    real_top3: float


def read_steps(path: Path = STEPS_FILE) -> list[Step]:
    """Return the steps in their order.

    Raises:
        Refused: the file is missing or damaged.
    """
    try:
        return msgspec.json.decode(path.read_bytes(), type=list[Step])
    except (OSError, msgspec.MsgspecError) as error:
        raise Refused(f"{path} cannot be read ({error}): take it from the repository") from error


def table(steps: Sequence[Step]) -> str:
    """Return the steps as a Markdown table."""
    lines = [
        "| proposer / crop nets | what changed | rendered mAP | top-3 | colour | material"
        " | real mAP | top-3 |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for step in steps:
        figures = (
            step.rendered_map,
            step.rendered_top3,
            step.colour,
            step.material,
            step.real_map,
            step.real_top3,
        )
        numbers = " | ".join(f"{value:.2f}".removeprefix("0") for value in figures)
        lines.append(f"| {step.trained} | {step.changed} | {numbers} |")
    return "\n".join(lines)


def draw(steps: Sequence[Step], path: Path = PICTURE) -> None:
    """Write a PNG with one panel a figure: its course over the steps, and what is wanted."""
    figure = Figure(figsize=(12, 3.2), dpi=110)
    FigureCanvasAgg(figure)
    numbers = range(1, len(steps) + 1)
    for place, (name, (title, wanted)) in enumerate(TARGETS.items(), start=1):
        axes = figure.add_subplot(1, len(TARGETS), place)
        axes.axhline(wanted, color="0.6", linestyle="--", linewidth=1)
        axes.plot(numbers, [getattr(step, name) for step in steps], marker="o", markersize=3)
        axes.set_title(title, fontsize="small")
        axes.set_ylim(0, 1)
        axes.set_xticks(list(numbers)[::2])
        axes.set_xlabel("row of the table", fontsize="small")
    figure.tight_layout()
    figure.savefig(path, metadata={"Software": ""})


if __name__ == "__main__":
    found = read_steps()
    print(table(found))
    draw(found)
