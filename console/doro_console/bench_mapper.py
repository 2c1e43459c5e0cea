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
@click.option(
    "--scene", "scenes", multiple=True, type=click.Choice(["room", "home", "fronts"]),
    help="room: a living room (default figures); home: three rooms; fronts: the worst case."
    " Default: all.",
)  # fmt: skip
@click.option("--recording", type=FILE, help="Another recording for fronts.")
@click.option("--frames", default=2000, show_default=True, type=click.IntRange(50))
@click.option(
    "--long", "long_frames", default=0, type=click.IntRange(0),
    help="Instead: memory and time over so many cheap frames, for example 100000.",
)  # fmt: skip
@says_refusals
def bench_mapper(
    json_path: Path | None,
    scenes: tuple[str, ...],
    recording: Path | None,
    frames: int,
    long_frames: int,
) -> None:
    """Merge 2,000 frames of 8 detections a scene on one thread; CPU time, wall clock beside it."""
    from doro_evaluation.bench.mapper import run_bench, run_long, wanted
    from doro_evaluation.bench.mapper_scenes import SCENES
    from doro_evaluation.figures import write_figures

    with talk.status("merging frames"), sample_recording() as sample:
        if long_frames:
            figures = run_long(recording or sample, long_frames)
        else:
            figures = run_bench(scenes or SCENES, recording or sample, frames)
    table = Table("figure", "value", "wanted", title="Mapper, one thread, CPU time")
    for name, value in figures.items():
        table.add_row(name, str(value), wanted(name))
    Console().print(table)
    command = f"--long {long_frames}" if long_frames else f"--frames {frames}"
    write_figures(json_path, figures, f"doro bench mapper {command}")
