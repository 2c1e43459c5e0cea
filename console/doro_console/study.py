"""``doro study``: questionnaires about what the robot says, and what came of them."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Literal

import click
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

from doro_console.options import says_refusals, talk
from doro_schemas.errors import Refused

FILE = click.Path(path_type=Path, dir_okay=False)
FOLDER = click.Path(path_type=Path, file_okay=False, exists=True)


@click.group()
def study() -> None:
    """Ask people how informative and natural the queries are; score what they say."""


@study.command("make")
@click.option("--set", "folder", type=FOLDER, help="A set of recordings ('doro rooms set').")
@click.option("--recording", "recordings", type=FILE, multiple=True, help="May be repeated.")
@click.option("--instruction", "-i", "instructions", multiple=True, help="Instead of seeded ones.")
@click.option("--out", type=FILE, default=Path("study.html"), show_default=True)
@click.option("--items", default=12, show_default=True, type=click.IntRange(1, 200))
@click.option("--seed", default=0, show_default=True, help="Scenes, wording, checks.")
@click.option(
    "--systems",
    default="ours,paper_literal",
    show_default=True,
    help="Of ours, paper_literal, reference, and those of --queries.",
)
@click.option("--queries", type=FILE, multiple=True, help="Other systems' queries, JSON lines.")
@click.option("--checks", default=2, show_default=True, type=click.IntRange(0, 9))
@click.option("--design", type=click.Choice(["one", "all"]), default="one", show_default=True)
@says_refusals
def make(
    folder: Path | None,
    recordings: tuple[Path, ...],
    instructions: tuple[str, ...],
    out: Path,
    items: int,
    seed: int,
    systems: str,
    queries: tuple[Path, ...],
    checks: int,
    design: Literal["one", "all"],
) -> None:
    """Turn scenes and queries into one HTML questionnaire, and its key beside it.

    With --design one, a participant sees each scene with one of its queries, in turns; with
    all, with every one.
    """
    from doro_evaluation.study.files import key_path, write_key
    from doro_evaluation.study.make import make_study
    from doro_evaluation.study.scenes import scenes_of
    from doro_evaluation.study.systems import Asker, check_systems, read_queries
    from doro_nlu.core import Nlu
    from doro_nlu.settings import NluSettings

    if out.suffix.lower() not in (".html", ".htm"):
        raise Refused(f"{out} must end in .html: its key goes beside it as {out.stem}.json")
    given = read_queries(queries)
    names = check_systems(systems.split(","), given)
    nlu = Nlu(NluSettings())
    scenes = scenes_of(folder, recordings, instructions, nlu, count=items, seed=seed)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    with Progress(*columns, console=talk, transient=True) as progress:
        task = progress.add_task("scenes", total=len(scenes))
        made, page = make_study(
            scenes,
            Asker(names, seed, nlu, given),
            name=out.stem,
            design=design,
            checks=checks,
            done=lambda name: progress.update(task, advance=1, description=name),
        )
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        write_key(key_path(out), made)
        out.write_text(page, encoding="utf-8")
    except OSError as error:
        raise Refused(f"{out} cannot be written: {error.strerror}") from error
    texts = sum(len(item.units) for item in made.items)
    talk.print(
        f"{out}: {len(made.items)} scenes, {texts} different queries of {len(names)} systems,"
        f" {checks} attention checks, {len(page) / 1e6:.1f} MB; it names no system.\n"
        f"{key_path(out)}: the key for 'doro study score'; keep it from participants.",
        markup=False,
    )


@study.command("score")
@click.argument("page", type=FILE)
@click.argument("answers", nargs=-1, required=True, type=FILE)
@click.option("--json", "json_path", type=FILE, help="Where to write the figures.")
@click.option("--report", "report_path", type=FILE, help="Where to write an HTML report.")
@click.option("--seed", default=0, show_default=True, help="Of the bootstrap.")
@says_refusals
def score(
    page: Path,
    answers: tuple[Path, ...],
    json_path: Path | None,
    report_path: Path | None,
    seed: int,
) -> None:
    """Score the ANSWERS that participants downloaded; PAGE is the study's HTML or its key."""
    from doro_evaluation.figures import write_figures
    from doro_evaluation.study.files import read_key
    from doro_evaluation.study.report import figures_of, item_table, report, table_of
    from doro_evaluation.study.score import read_all, score_study
    from doro_nlu.core import Nlu
    from doro_nlu.settings import NluSettings

    key = read_key(page)
    files, problems = read_all(answers, key)
    for problem in problems:
        talk.print(f"doro: {problem}", style="red", markup=False)
    nlu = Nlu(NluSettings())
    scores = score_study(key, files, problems, lambda text: nlu.parse_text(text).graph, seed)
    console = Console()
    console.print(table_of(key, scores))
    console.print(item_table(key, scores))
    command = f"doro study score {page.name} --seed {seed}"
    write_figures(json_path, figures_of(scores), command, seed)
    if report_path is not None:
        report_path.parent.mkdir(parents=True, exist_ok=True)
        report_path.write_text(report(key, scores), encoding="utf-8")
    sys.exit(0 if scores.participants else 1)
