"""Four identical chairs round a table: in how many rooms are they counted right?"""

from __future__ import annotations

import numpy as np
from rich.table import Table

from doro_evaluation.bootstrap import bounds
from doro_evaluation.counting.metrics import items, pairs
from doro_evaluation.counting.report import Figures, Runs

CHAIR = "Chair"


def counts_of(runs: Runs) -> dict[tuple[str, str], list[tuple[str, int, int]]]:
    """Return (room, true, found) chairs of each recording, by (system, error model)."""
    return {
        key: [
            (item.room, item.true, item.found)
            for outcome in outcomes
            for item in items(outcome)
            if item.object_type == CHAIR
        ]
        for key, outcomes in runs.items()
    }


def figures_of(runs: Runs) -> Figures:
    """Return ``chairs/system/errors/right``, ``rooms`` and the median centre error."""
    figures: Figures = {}
    for (system, errors), rooms in counts_of(runs).items():
        name = f"chairs/{system}/{errors}"
        figures[f"{name}/rooms"] = len(rooms)
        figures[f"{name}/right"] = sum(true == found for _, true, found in rooms)
        figures |= bounds(f"{name}/right", [(room, true == found) for room, true, found in rooms])
        distances = [
            pair.distance_m
            for outcome in runs[system, errors]
            for pair in pairs(outcome)
            if pair.object_type == CHAIR
        ]
        if distances:
            figures[f"{name}/center_error_median_m"] = round(float(np.median(distances)), 4)
    return figures


def table_of(runs: Runs) -> Table:
    """Return the table: right of all, and the rooms that are wrong with what was found."""
    table = Table("errors", "system", "right", "wrong: found", title="Four chairs round a table")
    for (system, errors), rooms in counts_of(runs).items():
        wrong = ", ".join(f"{room}: {found}" for room, true, found in rooms if true != found)
        right = sum(true == found for _, true, found in rooms)
        table.add_row(errors, system, f"{right} of {len(rooms)}", wrong)
    return table
