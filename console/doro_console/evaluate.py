"""``doro eval``: the paper's evaluation, a command per table."""

from __future__ import annotations

from pathlib import Path

import click
from rich.console import Console
from rich.progress import Progress

from doro_console.counting import chairs, counting, stacks
from doro_console.options import says_refusals, talk
from doro_console.planning import planning
from doro_console.queries import queries

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
@click.option("--json", "json_path", type=JSON, help="Where to write the figures.")
@says_refusals
def tagging(gold: Path | None, bert_base: Path | None, seed: int, json_path: Path | None) -> None:
    """F1 per label of each tagger on templates never trained on (paper, Table I)."""
    from doro_evaluation.figures import write_figures
    from doro_evaluation.tagging import figures_of, load_taggers, score, table_of, test_sets

    taggers, sets = load_taggers(bert_base), test_sets(seed, gold)
    reports = {}
    with Progress(console=talk, transient=True) as progress:
        task = progress.add_task("tagging", total=len(taggers) * len(sets))
        for key, report in score(taggers, sets):
            reports[key] = report
            progress.update(task, advance=1)
    Console().print(table_of(reports))
    write_figures(json_path, figures_of(reports), f"doro eval tagging --seed {seed}", seed)


for command in (counting, chairs, stacks, planning, queries):
    evaluate.add_command(command)
