"""``doro eval``: the paper's evaluation, a command per table."""

from __future__ import annotations

import sys
from pathlib import Path

import click
from rich.console import Console
from rich.progress import Progress

from doro_console.ablations import ablations
from doro_console.caption import perception
from doro_console.counting import chairs, counting, stacks
from doro_console.everything import everything, report
from doro_console.live import live
from doro_console.options import says_refusals, talk
from doro_console.planning import planning
from doro_console.queries import multi_view, queries, single_view
from doro_console.speed import speed

JSON = click.Path(path_type=Path, dir_okay=False)
FOLDER = click.Path(path_type=Path, file_okay=False, exists=True)
FILE = click.Path(path_type=Path, dir_okay=False, exists=True)


@click.group("eval")
def evaluate() -> None:
    """Measure how well it works; tables on stdout, with --json flat figures in a file."""


@evaluate.command("tagging")
@click.option("--gold", type=FILE, help="Labelled sentences: JSON lines with tokens and labels.")
@click.option("--bert-base", type=FOLDER, help="A trained bert-base (it is not shipped).")
@click.option("--seed", default=7, show_default=True, help="Of the generated test sentences.")
@click.option("--speed/--no-speed", default=True, help="Times beside bert-base, memory, readiness.")
@click.option("--json", "json_path", type=JSON, help="Where to write the figures.")
@says_refusals
def tagging(
    gold: Path | None, bert_base: Path | None, seed: int, speed: bool, json_path: Path | None
) -> None:
    """F1 per label, whole graphs and speed of each tagger (paper, Table I).

    The generated sentences are of templates that no training used.
    """
    from doro_evaluation.figures import write_figures
    from doro_evaluation.tagging import speed as tagging_speed
    from doro_evaluation.tagging.labels import (
        SHIPPED,
        figures_of,
        interval_figures,
        intervals,
        load_taggers,
        score,
        table_of,
    )
    from doro_evaluation.tagging.labels import test_sets as make_sets

    out = Console(width=None if sys.stdout.isatty() else 120)
    taggers, sets = load_taggers(bert_base), make_sets(seed, gold)
    shipped = {name: taggers[name] for name in SHIPPED}
    reports, speeds = {}, {}
    with Progress(console=talk, transient=True) as progress:
        task = progress.add_task("tagging", total=len(taggers) * len(sets))
        for key, report in score(taggers, sets):
            reports[key] = report
            progress.update(task, advance=1)
    out.print(table_of(reports))
    exact = tagging_speed.exact_graphs(shipped)
    click.echo("\n".join(tagging_speed.exact_lines(exact)))
    bounds = {(name, where): intervals(taggers[name], sets[where]) for name, where in reports}
    figures = figures_of(reports) | interval_figures(bounds)
    figures |= tagging_speed.exact_figures(exact)
    if speed:
        with Progress(console=talk, transient=True) as progress:
            task = progress.add_task("speed, beside bert-base", total=len(shipped))
            for name, one in tagging_speed.measure_speed(shipped, bert_base):
                speeds[name] = one
                progress.update(task, advance=1)
        out.print(tagging_speed.speed_table(speeds))
        figures |= tagging_speed.speed_figures(speeds)
    write_figures(json_path, figures, f"doro eval tagging --seed {seed}", seed)


for command in (
    counting,
    chairs,
    stacks,
    perception,
    planning,
    queries,
    single_view,
    multi_view,
    ablations,
    speed,
    live,
    everything,
    report,
):
    evaluate.add_command(command)
