"""``doro eval ablations``: what the mapper's parts are worth."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from doro_console.counting import (
    Options,
    ensure_set,
    make_context,
    progress_bar,
    shared_options,
    show,
)
from doro_console.options import says_refusals

if TYPE_CHECKING:
    from doro_evaluation.counting.ablations import AblationResult

WIDE = 230


def run_ablations(options: Options, most: int) -> list[AblationResult]:
    """Run counting and queries with each part left out, behind a progress bar."""
    from doro_evaluation.counting.ablations import ABLATIONS, ERRORS, QUERY_ERRORS, AblationResult
    from doro_evaluation.counting.report import grouped
    from doro_evaluation.queries.pairs import select_pairs
    from doro_evaluation.queries.runs import jobs_of, run_queries
    from doro_evaluation.runs import Job, recordings_of, run_jobs, spread

    folder = ensure_set(options, "set", "paper")
    chosen = spread(recordings_of(folder, "paper"), most)
    context = make_context(recordings_of(folder, "test"), "test", options)
    runs = tuple(("tracks", errors) for errors in ERRORS)
    jobs = [Job(item, runs) for item in chosen]
    pairs = select_pairs(folder, "test", 7)
    asked = jobs_of(chosen, pairs, errors=QUERY_ERRORS, systems=("ours",))
    results = []
    with progress_bar() as progress:
        task = progress.add_task("ablations", total=len(ABLATIONS) * (len(jobs) + len(asked)))
        for ablation in ABLATIONS:
            own = ablation.of(context)
            outcomes, queries = [], []
            for some in run_jobs(jobs, own, options.workers):
                outcomes += some
                progress.update(task, advance=1, description=ablation.name)
            for said in run_queries(asked, own, options.workers):
                queries += said
                progress.update(task, advance=1, description=ablation.name)
            by_errors = {errors: found for (_, errors), found in grouped(outcomes).items()}
            results.append(AblationResult(ablation, by_errors, queries))
    return results


@click.command("ablations")
@click.option("--rooms", "most", default=24, show_default=True, help="Test recordings, spread.")
@shared_options
@says_refusals
def ablations(options: Options, most: int) -> None:
    """Counting and queries with parts of the mapper left out: mask, cannot-link, ..."""
    from doro_evaluation.counting.ablations import figures_of, table_of
    from doro_evaluation.figures import write_figures

    results = run_ablations(options, most)
    show(table_of(results), WIDE)
    command = f"doro eval ablations --rooms {most}"
    write_figures(options.json_path, figures_of(results), command, options.seed)
