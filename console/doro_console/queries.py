"""``doro eval queries``, ``single-view`` and ``multi-view``: the whole system on pairs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import msgspec

from doro_console.counting import (
    FILE,
    Options,
    ensure_set,
    make_context,
    progress_bar,
    shared_options,
    show,
)
from doro_console.options import says_refusals

if TYPE_CHECKING:
    from doro_evaluation.queries.systems import QueryOutcome

ERRORS = "cs+sd+fn"
SYSTEMS = "ours,paper_literal,baseline"
WIDE = 210


class PairOptions(msgspec.Struct, frozen=True, kw_only=True):
    """Which pairs, and what is run on them."""

    part: str = "test"
    count: int = 600
    errors: str = ERRORS
    systems: str = SYSTEMS
    pair_seed: int = 7
    cases: Path | None = None
    most: int | None = None

    def command(self, name: str) -> str:
        """Return the command that gives the same figures."""
        return (
            f"doro eval {name} --part {self.part} --pairs {self.count} --errors {self.errors}"
            f" --systems {self.systems} --pair-seed {self.pair_seed}"
            + (f" --rooms {self.most}" if self.most is not None else "")
        )


def pair_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add the options of the end-to-end tables, handed in as ``chosen``."""

    @click.option("--part", type=click.Choice(["test", "validation"]), default="test")
    @click.option("--pairs", "count", default=600, show_default=True, help="A third of each kind.")
    @click.option("--errors", default=ERRORS, show_default=True, help="Of the detector.")
    @click.option("--systems", default=SYSTEMS, show_default=True)
    @click.option("--pair-seed", default=7, show_default=True, help="Draws the pairs.")
    @click.option("--rooms", "most", type=click.IntRange(1), help="Only so many recordings.")
    @click.option("--cases", type=FILE, help="Every pair, what was said and is true, JSON lines.")
    @wraps(command)
    def wrapped(**given: Any) -> None:
        own = {name: given.pop(name) for name in PairOptions.__struct_fields__}
        command(chosen=PairOptions(**own), **given)

    return wrapped


def run_pairs(options: Options, chosen: PairOptions) -> list[QueryOutcome]:
    """Run the pairs through the systems behind a progress bar."""
    from doro_evaluation.queries.pairs import select_pairs
    from doro_evaluation.queries.runs import jobs_of, run_queries
    from doro_evaluation.runs import error_names, recordings_of, spread

    part = "paper" if chosen.part == "test" else chosen.part
    folder = ensure_set(options, "set", part)
    # False positives come from the same rooms as in counting: runs are shared.
    context = make_context(recordings_of(folder, chosen.part), chosen.part, options)
    names = tuple(name.strip() for name in chosen.systems.split(",") if name.strip())
    jobs = jobs_of(
        spread(recordings_of(folder, part), chosen.most),
        select_pairs(folder, chosen.part, chosen.pair_seed, chosen.count),
        errors=error_names(chosen.errors)[0],
        systems=names,
    )
    outcomes: list[QueryOutcome] = []
    with progress_bar() as progress:
        task = progress.add_task("pairs", total=len(jobs))
        for some in run_queries(jobs, context, options.workers):
            outcomes += some
            progress.update(task, advance=1, description=some[0].pair.episode)
    return outcomes


def run_tables(
    name: str, tables: Sequence[str], options: Options, chosen: PairOptions
) -> dict[str, Any]:
    """Run, print tables, write figures and cases; return the figures."""
    from doro_evaluation.figures import write_figures
    from doro_evaluation.queries import tables as report
    from doro_evaluation.queries.runs import missing_baseline

    outcomes = run_pairs(options, chosen)
    outcomes = [one for one in outcomes if report.row_of(one.view, one.system)[0] in tables]
    scores = report.score_all(outcomes)
    for table in report.tables_of(scores, missing_baseline(), tables):
        show(table, WIDE)
    if chosen.cases is not None:
        report.write_cases(chosen.cases, outcomes)
    figures = report.figures_of(scores)
    write_figures(options.json_path, figures, chosen.command(name), options.seed)
    return figures


@click.command("queries")
@pair_options
@shared_options
@says_refusals
def queries(options: Options, chosen: PairOptions) -> None:
    """Both end-to-end tables: QA, AA, BLEU, BERTScore (paper, Tables III and IV)."""
    run_tables("queries", ("single-view", "multi-view"), options, chosen)


@click.command("single-view")
@pair_options
@shared_options
@says_refusals
def single_view(options: Options, chosen: PairOptions) -> None:
    """One view, judged by what the detector delivered of it (paper, Table III)."""
    run_tables("single-view", ("single-view",), options, chosen)


@click.command("multi-view")
@pair_options
@shared_options
@says_refusals
def multi_view(options: Options, chosen: PairOptions) -> None:
    """All views merged, and one view judged by the whole room (paper, Table IV)."""
    run_tables("multi-view", ("multi-view",), options, chosen)
