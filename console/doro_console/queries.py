"""``doro eval queries``: the whole system on (recording, instruction) pairs."""

from __future__ import annotations

import sys
from pathlib import Path

import click
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from doro_console.options import says_refusals, talk

FOLDER = click.Path(path_type=Path, file_okay=False)
FILE = click.Path(path_type=Path, dir_okay=False)
COLUMNS = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())


@click.command("queries")
@click.option("--set", "folder", type=FOLDER, required=True, help="Made by doro rooms set.")
@click.option("--part", type=click.Choice(["test", "validation"]), default="test")
@click.option("--pairs", "count", default=600, show_default=True, help="A third of each kind.")
@click.option("--errors", default="cs+sd+fn", show_default=True, help="Of the detector.")
@click.option("--systems", default="ours,paper_literal", show_default=True)
@click.option("--seed", default=7, show_default=True, help="Draws the pairs.")
@click.option("--workers", type=click.IntRange(1, 16), default=2, show_default=True)
@click.option("--fresh", is_flag=True, help="Do not use what was kept of earlier runs.")
@click.option("--cases", type=FILE, help="Every pair with what was said and is true, JSON lines.")
@click.option("--json", "json_path", type=FILE, help="Where to write the figures.")
@says_refusals
def queries(
    folder: Path,
    part: str,
    count: int,
    errors: str,
    systems: str,
    seed: int,
    workers: int,
    fresh: bool,
    cases: Path | None,
    json_path: Path | None,
) -> None:
    """QA, AA and BLEU on all views, on one view, and on one image (paper, Tables III, IV)."""
    from doro_evaluation.figures import write_figures
    from doro_evaluation.pairs import select_pairs
    from doro_evaluation.queries import QueryOutcome
    from doro_evaluation.query_report import figures_of, score_all, tables_of, write_cases
    from doro_evaluation.query_runs import jobs_of, run_queries
    from doro_evaluation.runs import error_names, make_pool, recordings_of

    chosen = error_names(errors)[0]
    recordings = recordings_of(folder, "paper" if part == "test" else part)
    cache = folder / "outcomes"
    pool = make_pool(recordings, part, cache)
    pairs = select_pairs(folder, part, seed, count)
    names = [name.strip() for name in systems.split(",") if name.strip()]
    jobs = jobs_of(
        recordings, pairs, errors=chosen, systems=names, pool=pool, cache=cache, fresh=fresh
    )
    outcomes: list[QueryOutcome] = []
    with Progress(*COLUMNS, console=talk, transient=True) as progress:
        task = progress.add_task("recordings", total=len(jobs))
        for found in run_queries(jobs, workers):
            outcomes += found
            progress.update(task, advance=1)
    scores = score_all(outcomes)
    for table in tables_of(scores):
        Console(width=None if sys.stdout.isatty() else 120).print(table)
    if cases is not None:
        write_cases(cases, outcomes)
    command = f"doro eval queries --part {part} --pairs {count} --errors {chosen} --seed {seed}"
    write_figures(json_path, figures_of(scores), command, seed)
