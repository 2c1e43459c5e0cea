"""``doro eval planning``: how many views counting needs, chosen by the planner or not."""

from __future__ import annotations

from pathlib import Path

import click
from rich.console import Console

from doro_console.counting import (
    FILE,
    Options,
    ensure_set,
    make_context,
    progress_bar,
    shared_options,
)
from doro_console.options import says_refusals
from doro_schemas.errors import Refused


@click.command("planning")
@click.option("--part", default="test", show_default=True, help="test, paper, validation, ...")
@click.option("--errors", default="gt", show_default=True, help="One error model.")
@click.option("--rooms", "most", type=click.IntRange(1), help="Only so many recordings.")
@click.option("--random", "orders", default=3, show_default=True, help="Random orders a room.")
@click.option("--plot", "plot_path", type=FILE, help="Curves, PNG.  [default: OUT/planning.png]")
@shared_options
@says_refusals
def planning(
    options: Options,
    part: str,
    errors: str,
    most: int | None,
    orders: int,
    plot_path: Path | None,
) -> None:
    """Count after a part of the views: the planner's choice, recorded and random order."""
    from doro_evaluation.chain import ERROR_MODELS
    from doro_evaluation.figures import write_figures
    from doro_evaluation.planning.curve import PlanningContext, Point, run_planning
    from doro_evaluation.planning.report import figures_of, plot, table_of
    from doro_evaluation.runs import recordings_of, spread

    if errors not in ERROR_MODELS:
        raise Refused(f"error model '{errors}' is unknown: use {', '.join(ERROR_MODELS)}")
    every = recordings_of(ensure_set(options, "set", part), part)
    chosen = spread(every, most)
    shared = make_context(every, part, options)
    context = PlanningContext(
        mapper=shared.mapper,
        perception=shared.perception,
        nlu=shared.nlu,
        errors=errors,
        pool=shared.pool,
        seeds=tuple(options.seed + k for k in range(orders)),
        error_seed=options.seed,
    )
    points: list[Point] = []
    with progress_bar() as progress:
        task = progress.add_task("planning", total=len(chosen))
        for some in run_planning([Path(item.path) for item in chosen], context, options.workers):
            points += some
            progress.update(task, advance=1, description=some[0].outcome.recording)
    Console().print(table_of(points))
    plot(plot_path or options.out / "planning.png", points)
    command = f"doro eval planning --part {part} --errors {errors} --random {orders}"
    if most is not None:
        command += f" --rooms {most}"
    write_figures(options.json_path, figures_of(points), command, options.seed)
