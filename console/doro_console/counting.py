"""``doro eval counting`` and ``doro eval chairs``: how many of each thing there are."""

from __future__ import annotations

from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import msgspec
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from doro_console.options import deploy_folder, says_refusals, talk

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from doro_evaluation.outcomes import Outcome
    from doro_evaluation.runs import Context, Job, Recorded

OUT = Path("out/eval")
FOLDER = click.Path(path_type=Path, file_okay=False)
FILE = click.Path(path_type=Path, dir_okay=False)
ALL_ERRORS = "gt,cs,cs+sd,cs+sd+fn,fp,all"
FINDER_HELP = "Any of tracks, grid, paper_literal, conceptgraphs_like; separated by commas."
WIDE = 150


class Options(msgspec.Struct, frozen=True, kw_only=True):
    """What the evaluations of the map have in common; ``folder`` empty: below ``out``."""

    folder: Path | None
    seed: int
    workers: int
    fresh: bool
    out: Path
    json_path: Path | None
    config: Path | None
    overrides: tuple[str, ...]


def shared_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add the options that the evaluations of the map share, handed in as ``options``."""

    @click.option("--set", "folder", type=FOLDER, help="Recordings; rendered where missing.")
    @click.option("--seed", default=0, show_default=True, help="Of the error models.")
    @click.option("--workers", type=click.IntRange(1, 16), default=2, show_default=True)
    @click.option("--fresh", is_flag=True, help="Do not use what an earlier run has kept.")
    @click.option("--out", type=FOLDER, default=OUT, show_default=True, help="What is kept.")
    @click.option("--json", "json_path", type=FILE, help="Where to write the figures.")
    @click.option("--config", type=FILE, help="Settings (TOML); default: deploy/doro.toml.")
    @click.option("--setting", "overrides", multiple=True, metavar="TABLE.KEY=VALUE")
    @wraps(command)
    def wrapped(**given: Any) -> None:
        own = {name: given.pop(name) for name in Options.__struct_fields__}
        command(options=Options(**own), **given)

    return wrapped


def progress_bar() -> Progress:
    """Return the bar of all long commands, on stderr."""
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    return Progress(*columns, TimeElapsedColumn(), console=talk, transient=True)


def show(table: Table, width: int = WIDE) -> None:
    """Print a table on stdout; into a file or a pipe it is as wide as it needs to be."""
    console = Console()
    (console if console.is_terminal else Console(width=width)).print(table)


def ensure_set(options: Options, name: str, part: str, seed: int = 7) -> Path:
    """Return the folder of a set, with what is missing of a part rendered.

    A folder that was named and has recordings of the part is taken as it is.
    """
    from doro_console.references import write_references
    from doro_evaluation.runs import PARTS
    from doro_sim_feeder.rooms.make_set import Render, make_set, write_manifest
    from doro_sim_feeder.rooms.more_sets import plan_all

    folder = options.folder or options.out / name
    wanted = PARTS.get(part, (part,))
    own = [path for path in folder.glob("*.mcap") if path.stem.split("-FloorPlan")[0] in wanted]
    if options.folder is not None and own:
        return folder
    rows = [row for row in plan_all(seed) if row.part in wanted]
    if not rows:
        return folder
    there = sum((folder / f"{row.name}.mcap").is_file() for row in rows)
    if there < len(rows):
        talk.print(f"{there} of {len(rows)} recordings in {folder}: rendering", markup=False)
    made = []
    with progress_bar() as progress:
        task = progress.add_task("rendering", total=len(rows))
        for one in make_set(rows, Render(folder), options.workers):
            made.append(one)
            progress.update(task, advance=1, description=one.row.name)
    for one in made:
        write_references(folder, one.truth)
    write_manifest(plan_all(seed), made, Render(folder), seed)
    return folder


def make_context(
    found: Sequence[Recorded], part: str, options: Options, finder: str | None = None
) -> Context:
    """Return what all runs share, with the settings of the command line."""
    from doro_evaluation.runs import Context, code_digest, make_pool, with_finder
    from doro_mapper.settings import MapperSettings
    from doro_nlu.settings import NluSettings
    from doro_perception.settings import PerceptionSettings
    from doro_schemas.settings import load_settings

    config = options.config or deploy_folder() / "doro.toml"
    mapper = load_settings("mapper", MapperSettings, config, options.overrides)
    return Context(
        perception=load_settings("perception", PerceptionSettings, config, options.overrides),
        nlu=load_settings("nlu", NluSettings, config, options.overrides),
        mapper=with_finder(mapper, finder) if finder else mapper,
        pool=str(make_pool(found, part, options.out / "cache")),
        cache=str(options.out / "cache"),
        code=code_digest(),
        seed=options.seed,
        fresh=options.fresh,
    )


def run_with_bar(jobs: Sequence[Job], context: Context, workers: int) -> list[Outcome]:
    """Run the jobs behind a progress bar."""
    from doro_evaluation.runs import run_jobs

    outcomes: list[Outcome] = []
    with progress_bar() as progress:
        task = progress.add_task("counting", total=len(jobs))
        for some in run_jobs(jobs, context, workers):
            outcomes += some
            progress.update(task, advance=1, description=some[0].recording)
    return outcomes


@click.command("counting")
@click.option("--part", default="test", show_default=True, help="test, paper, validation, ...")
@click.option("--errors", default=ALL_ERRORS, show_default=True)
@click.option("--finder", "finders", default="tracks", show_default=True, help=FINDER_HELP)
@click.option("--rooms", "most", type=click.IntRange(1), help="Only so many recordings.")
@click.option("--min-views", default=1, show_default=True, help="Views that make a thing true.")
@click.option("--shuffle", type=click.IntRange(1), help="Measure so many shuffled orders instead.")
@click.option("--plot", "plot_path", type=FILE, help="F1 against the true count, PNG.")
@click.option("--failures", "failures_path", type=FILE, help="Wrong items: JSON lines, and PNG.")
@shared_options
@says_refusals
def counting(
    options: Options,
    part: str,
    errors: str,
    finders: str,
    most: int | None,
    min_views: int,
    shuffle: int | None,
    plot_path: Path | None,
    failures_path: Path | None,
) -> None:
    """Count instances in rendered rooms under detector errors (paper, Table II)."""
    from doro_evaluation.counting import report
    from doro_evaluation.counting.reasons import figures_of as cause_figures
    from doro_evaluation.figures import write_figures
    from doro_evaluation.runs import Job, error_names, recordings_of, spread

    folder = ensure_set(options, "set", part)
    every = recordings_of(folder, part)
    found = spread(every, most)
    context = make_context(every, part, options)
    if shuffle is not None:
        run_shuffle(found, context, shuffle, options)
        return
    runs = tuple(
        (finder.strip(), name) for name in error_names(errors) for finder in finders.split(",")
    )
    outcomes = run_with_bar([Job(item, runs) for item in found], context, options.workers)
    by_run = report.grouped(outcomes)
    for table in report.tables_of(by_run, min_views):
        show(table)
    if plot_path is not None:
        report.plot_counts(plot_path, by_run, min_views)
    if failures_path is not None:
        report.write_failures(failures_path, by_run, min_views)
    figures = report.figures_of(by_run, min_views) | cause_figures(by_run)
    command = f"doro eval counting --part {part} --errors {errors} --finder {finders}"
    if most is not None:
        command += f" --rooms {most}"
    if min_views != 1:
        command += f" --min-views {min_views}"
    write_figures(options.json_path, figures, command, options.seed)


@click.command("chairs")
@click.option("--part", type=click.Choice(["chairs", "chairs-tune"]), default="chairs")
@click.option("--errors", default="gt,all", show_default=True)
@click.option("--finder", "finders", default="tracks", show_default=True, help=FINDER_HELP)
@shared_options
@says_refusals
def chairs(options: Options, part: str, errors: str, finders: str) -> None:
    """Four identical chairs round a table: in how many of ten rooms are four counted?"""
    from doro_evaluation.counting.chairs import figures_of, table_of
    from doro_evaluation.counting.report import grouped
    from doro_evaluation.figures import write_figures
    from doro_evaluation.runs import Job, error_names, recordings_of

    found = recordings_of(ensure_set(options, part, part), part)
    runs = tuple(
        (finder.strip(), name) for name in error_names(errors) for finder in finders.split(",")
    )
    context = make_context(found, part, options)
    outcomes = run_with_bar([Job(item, runs) for item in found], context, options.workers)
    by_run = grouped(outcomes)
    show(table_of(by_run))
    command = f"doro eval chairs --part {part} --errors {errors} --finder {finders}"
    write_figures(options.json_path, figures_of(by_run), command, options.seed)


@click.command("stacks")
@click.option("--part", type=click.Choice(["stacks", "stacks-tune"]), default="stacks")
@click.option("--errors", default="gt", show_default=True)
@click.option("--rooms", "most", type=click.IntRange(1), help="Only so many recordings.")
@click.option("--failures", "failures_path", type=FILE, help="Wrong stacks as JSON lines.")
@shared_options
@says_refusals
def stacks(
    options: Options, part: str, errors: str, most: int | None, failures_path: Path | None
) -> None:
    """Piles of 2 to 4 things: counted once, with the right chain of is-on and is-at?"""
    from doro_evaluation.counting.stacks import figures_of, run_stacks, table_of, write_failures
    from doro_evaluation.figures import write_figures
    from doro_evaluation.runs import error_names, recordings_of, spread

    every = recordings_of(ensure_set(options, part, part), part)
    found, names = spread(every, most), error_names(errors)
    context = make_context(every, part, options)
    results = []
    with progress_bar() as progress:
        task = progress.add_task("stacks", total=len(found))
        for some in run_stacks(found, names, context, options.workers):
            results += some
            progress.update(task, advance=1)
    show(table_of(results))
    if failures_path is not None:
        write_failures(failures_path, results)
    command = f"doro eval stacks --part {part} --errors {errors}"
    write_figures(options.json_path, figures_of(results), command, options.seed)


def run_shuffle(found: Sequence[Recorded], context: Context, orders: int, options: Options) -> None:
    """Compare shuffled orders of the views with the recorded one, print and write figures."""
    from doro_evaluation.counting.order import compare_orders, figures_of, table_of
    from doro_evaluation.figures import write_figures

    results = []
    with progress_bar() as progress:
        task = progress.add_task("shuffling", total=len(found))
        for one in compare_orders(found, context, orders, options.workers):
            results.append(one)
            progress.update(task, advance=1, description=one.recording)
    show(table_of(results))
    command = f"doro eval counting --shuffle {orders} --rooms {len(found)}"
    write_figures(options.json_path, figures_of(results), command, options.seed)
