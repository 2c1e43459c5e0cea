"""``doro bench``: runs the benchmarks of bus and player and shows their figures."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from doro_console.options import sample_recording, talk
from doro_console.processes import free_port
from doro_evaluation.figures import write_figures
from doro_schemas.bus.bench import SERIES, WARM_UP, run_bench
from doro_sim_feeder.bench import FRAMES
from doro_sim_feeder.bench import run_bench as run_play

PLAY_TARGETS = {
    "speed/play/frames": str(FRAMES),
    "speed/play/times_real_time": "> 20",
    "speed/play/pacing_p95_ms": "< 5",
    "speed/play/lost": "0",
}
TARGETS = {"1kB": "added < 100 us", "rgbd": "ratio < 1.15"}


def run_bench_bus(json_path: Path | None, count: int) -> None:
    """Measure, print a table, and write the figures as flat JSON where asked."""
    with Progress(console=talk, transient=True) as progress:
        tasks = {name: progress.add_task(name, total=count + WARM_UP) for name in SERIES}
        figures = run_bench(
            count, lambda series, sent: progress.update(tasks[series], completed=sent)
        )
    Console().print(_table(figures))
    write_figures(json_path, figures, f"doro bench bus --count {count}")


def run_bench_play(json_path: Path | None, paced_frames: int) -> None:
    """Play 167 frames as fast as the bus takes them, then some in real time; print figures."""
    with Progress(console=talk, transient=True) as progress, sample_recording() as sample:
        task = progress.add_task("frames", total=FRAMES)
        endpoint = f"tcp/127.0.0.1:{free_port()}"
        figures = run_play(
            sample, endpoint, paced_frames, lambda sent, _: progress.update(task, completed=sent)
        )
    table = Table("figure", "value", "wanted")
    for name, wanted in PLAY_TARGETS.items():
        table.add_row(name, str(figures[name]), wanted)
    Console().print(table)
    write_figures(json_path, figures, f"doro bench play --paced {paced_frames}")


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
