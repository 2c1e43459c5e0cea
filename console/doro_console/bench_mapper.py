"""``doro bench mapper``: time and memory of the mapper beside a ConceptGraphs-like one."""

from __future__ import annotations

from pathlib import Path

import click
from rich.console import Console
from rich.table import Table

from doro_console.options import sample_recording, says_refusals, talk

FILE = click.Path(path_type=Path, dir_okay=False)


@click.command("mapper")
@click.option("--json", "json_path", type=FILE, help="Where to write the figures.")
@click.option("--recording", type=FILE, help="A rendered room; default: the packaged sample.")
@click.option("--frames", default=2000, show_default=True, type=click.IntRange(50))
@says_refusals
def bench_mapper(json_path: Path | None, recording: Path | None, frames: int) -> None:
    """Merge 2,000 frames of 8 detections on one thread; CPU time, wall clock beside it."""
    from doro_evaluation.figures import write_figures
    from doro_evaluation.mapper_bench import TARGETS, run_bench

    with talk.status(f"merging {frames} frames"), sample_recording() as sample:
        figures = run_bench(recording or sample, frames)
    table = Table("figure", "value", "wanted", title="Mapper, one thread, CPU time")
    for name, value in figures.items():
        table.add_row(name, str(value), TARGETS.get(name, ""))
    Console().print(table)
    write_figures(json_path, figures, f"doro bench mapper --frames {frames}")
