"""``doro eval all`` and ``doro eval report``: the whole evaluation, resumable, and its page."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING

import click
import msgspec

from doro_console.ablations import run_ablations
from doro_console.counting import (
    ALL_ERRORS,
    FOLDER,
    Options,
    ensure_set,
    make_context,
    progress_bar,
    run_with_bar,
    shared_options,
    show,
)
from doro_console.options import says_refusals, talk
from doro_console.queries import PairOptions, run_pairs
from doro_console.speed import run_speed
from doro_evaluation.figures import Figure, write_figures

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from doro_evaluation.context import Recorded
    from doro_evaluation.outcomes import Outcome
    from doro_evaluation.queries.systems import QueryOutcome

FINDERS = ("tracks", "paper_literal")
TABLES = ("counting", "queries", "ablations", "tagging", "speed")
LIVE = "live"
"""Of ``doro eval live --json OUT/figures/live.json``, where that was run."""
FIGURES = "figures.json"
Found = dict[str, Figure]


class Everything(msgspec.Struct, frozen=True, kw_only=True):
    """What a whole evaluation is asked for: a part of the recordings and tables, or all."""

    options: Options
    most: int | None
    pairs: int

    def chosen(self, part: str) -> list[Recorded]:
        """Return the recordings of a part."""
        from doro_evaluation.runs import recordings_of, spread

        folder = ensure_set(self.options, "set", part)
        return spread(recordings_of(folder, part), self.most)


def count(asked: Everything) -> dict[tuple[str, str], list[Outcome]]:
    """Run counting under all error models, ours and the paper's literal method."""
    from doro_evaluation.counting.report import grouped
    from doro_evaluation.runs import Job, error_names, recordings_of

    options = asked.options
    chosen = asked.chosen("test")
    every = recordings_of(ensure_set(options, "set", "test"), "test")
    context = make_context(every, "test", options)
    runs = tuple((finder, errors) for errors in error_names(ALL_ERRORS) for finder in FINDERS)
    return grouped(run_with_bar([Job(one, runs) for one in chosen], context, options.workers))


def _counting(asked: Everything) -> Found:
    from doro_evaluation.counting import report as counting_report
    from doro_evaluation.counting.reasons import figures_of as cause_figures

    by_run = count(asked)
    for table in counting_report.tables_of(by_run):
        show(table)
    return counting_report.figures_of(by_run) | cause_figures(by_run)


def _queries(asked: Everything) -> Found:
    from doro_evaluation.queries import tables as query_report
    from doro_evaluation.queries.runs import missing_baseline

    scores = query_report.score_all(ask(asked))
    for table in query_report.tables_of(scores, missing_baseline()):
        show(table, 210)
    return query_report.figures_of(scores)


def ask(asked: Everything) -> list[QueryOutcome]:
    """Run the pairs through the systems."""
    return run_pairs(asked.options, PairOptions(count=asked.pairs, most=asked.most))


def _ablations(asked: Everything) -> Found:
    from doro_evaluation.counting.ablations import RECORDINGS, figures_of, table_of

    results = run_ablations(asked.options, min(asked.most or RECORDINGS, RECORDINGS))
    show(table_of(results), 230)
    return figures_of(results)


def _tagging(_: Everything) -> Found:
    from doro_evaluation.tagging.labels import (
        figures_of,
        interval_figures,
        intervals,
        load_taggers,
        score,
        table_of,
        test_sets,
    )

    taggers, sets = load_taggers(None), test_sets(7, None)
    reports = dict(score(taggers, sets))
    show(table_of(reports))
    bounds = {(name, where): intervals(taggers[name], sets[where]) for name, where in reports}
    return figures_of(reports) | interval_figures(bounds)


def _speed(asked: Everything) -> Found:
    return run_speed(asked.options, min(asked.most or 8, 8))


STEPS: Mapping[str, Callable[[Everything], Found]] = {
    "counting": _counting,
    "queries": _queries,
    "ablations": _ablations,
    "tagging": _tagging,
    "speed": _speed,
}


def whole_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add the options of all and report."""
    for option in (
        click.option("--rooms", "most", type=click.IntRange(2), help="Only so many recordings."),
        click.option("--pairs", default=600, show_default=True, help="A third of each kind."),
        click.option("--publish", type=FOLDER, help="Also write Markdown, plots, figures here."),
    ):
        command = option(command)
    return command


@click.command("all")
@click.option("--tables", default=",".join(TABLES), show_default=True, help="Only some of them.")
@whole_options
@shared_options
@says_refusals
def everything(
    options: Options, tables: str, most: int | None, pairs: int, publish: Path | None
) -> None:
    """Every table, then the report; what an earlier run has done is not done again."""
    asked = Everything(options=options, most=most, pairs=pairs)
    names = [name.strip() for name in tables.split(",") if name.strip()]
    for name in names:
        if name not in STEPS:
            raise click.BadParameter(f"'{name}' is none of {', '.join(STEPS)}", param_hint="tables")
    began = time.monotonic()
    for name in names:
        talk.print(f"{name}, after {time.monotonic() - began:.0f} s", markup=False)
        figures = STEPS[name](asked)
        write_figures(_place(options, name), figures, _command(asked, name), options.seed)
    _report(asked, publish)
    talk.print(f"done after {time.monotonic() - began:.0f} s", markup=False)


@click.command("report")
@whole_options
@shared_options
@says_refusals
def report(options: Options, most: int | None, pairs: int, publish: Path | None) -> None:
    """One HTML page and a Markdown table of what doro eval all measured, with failures."""
    _report(Everything(options=options, most=most, pairs=pairs), publish)


def _place(options: Options, name: str) -> Path:
    return options.out / "figures" / f"{name}.json"


def _command(asked: Everything, tables: str) -> str:
    rooms = f" --rooms {asked.most}" if asked.most is not None else ""
    return f"doro eval all --tables {tables} --pairs {asked.pairs}{rooms}"


def _report(asked: Everything, publish: Path | None) -> None:
    """Write page, Markdown, plots and all figures."""
    from doro_evaluation.queries.runs import missing_baseline
    from doro_evaluation.report.headline import read_figures
    from doro_evaluation.report.write import Report, write_report

    options = asked.options
    figures: Found = {}
    for name in (*TABLES, LIVE):
        if _place(options, name).is_file():
            figures |= read_figures(_place(options, name))
    command = _command(asked, ",".join(TABLES))
    write_figures(options.out / FIGURES, figures, command, options.seed)
    write_figures(options.json_path, figures, command, options.seed)
    recordings = {one.name: one for one in asked.chosen("test")}
    made = Report(
        figures=figures, command=command, counted=count(asked), asked=ask(asked),
        recordings=recordings, missing=missing_baseline(),
    )  # fmt: skip
    with progress_bar() as progress:
        task = progress.add_task("pictures", total=None)
        for path in write_report(made, options.out, publish):
            progress.update(task, advance=1)
            if path is not None:
                click.echo(path)
