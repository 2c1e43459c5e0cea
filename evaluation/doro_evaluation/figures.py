"""Flat figures, ``table/system/columns/metric`` -> number, and the file that keeps them."""

from __future__ import annotations

import json
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path

Figure = float | int | str


def write_figures(
    path: Path | None, figures: Mapping[str, Figure], command: str, seed: int = 0
) -> None:
    """Write figures with the command, seed and version that made them; nothing without a path."""
    if path is None:
        return
    report = {
        "figures": dict(figures),
        "command": command,
        "seed": seed,
        "version": version("doro-evaluation"),
    }
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(report, indent=2) + "\n", encoding="utf-8")
