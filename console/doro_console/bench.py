"""``doro bench bus``: runs the bus's benchmark and shows its figures."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from doro_console.options import talk
from doro_schemas.bus.bench import SERIES, WARM_UP, run_bench

TARGETS = {"1kB": "added < 100 us", "rgbd": "ratio < 1.15"}


def run_bench_bus(json_path: Path | None, count: int) -> None:
    """Measure, print a table, and write the figures as flat JSON where asked."""
    with Progress(console=talk, transient=True) as progress:
        tasks = {name: progress.add_task(name, total=count + WARM_UP) for name in SERIES}
        figures = run_bench(
            count, lambda series, sent: progress.update(tasks[series], completed=sent)
        )
    Console().print(_table(figures))
    if json_path is not None:
        from importlib.metadata import version

        report: dict[str, Any] = {
            "figures": figures,
            "command": f"doro bench bus --count {count}",
            "seed": 0,
            "version": version("doro-console"),
        }
        json_path.write_text(json.dumps(report, indent=2) + "\n", encoding="utf-8")


def _table(figures: dict[str, Any]) -> Table:
    table = Table("publish to receive, p50", "raw zenoh", "ours", "added", "ratio", "wanted")
    for series in SERIES:
        row = {key: figures[f"speed/bus/{series}_{key}"] for key in ("raw_p50_us", "ours_p50_us")}
        table.add_row(
            {"1kB": "1 kB caption", "rgbd": "640x480 RGB-D, 1.54 MB"}[series],
            *(f"{value:.0f} us" for value in row.values()),
            f"{figures[f'speed/bus/{series}_added_us']:.0f} us",
            f"{figures[f'speed/bus/{series}_ratio']:.2f}",
            TARGETS[series],
        )
    return table
