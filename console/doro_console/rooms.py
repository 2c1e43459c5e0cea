"""``doro rooms``: rendered iTHOR rooms, the evaluation's set, checks and statistics."""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

import click
import msgspec
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from doro_console.options import says_refusals, talk

if TYPE_CHECKING:
    from doro_sim_feeder.rooms.check import RoomCheck
    from doro_sim_feeder.rooms.make_set import Made
    from doro_sim_feeder.rooms.statistics import SetStatistics

FOLDER = click.Path(path_type=Path, file_okay=False)


@click.group()
def rooms() -> None:
    """Render iTHOR rooms without Unity (needs the extra doro-sim-feeder[render])."""


@rooms.command("render", context_settings={"ignore_unknown_options": True, "help_option_names": []})
@click.argument("arguments", nargs=-1, type=click.UNPROCESSED)
@says_refusals
def render(arguments: tuple[str, ...]) -> None:
    """Render the exploration of a room; --help says with which options."""
    from doro_sim_feeder.rooms.__main__ import main

    sys.exit(main(["render", *arguments]))


@rooms.command("set")
@click.option("--out", type=FOLDER, required=True, help="Folder of the recordings.")
@click.option("--workers", type=click.IntRange(1, 16), default=2, show_default=True)
@click.option(
    "--part",
    "parts",
    multiple=True,
    default=("paper",),
    show_default=True,
    help="paper (the 107), extra, chairs, stacks, or chairs-, stacks-, copies-tune; repeatable.",
)
@click.option("--only", multiple=True, help="Only this recording, room or part; repeatable.")
@click.option("--seed", default=7, show_default=True, help="Chooses rooms, copies and views.")
@click.option("--views", type=click.IntRange(1), help="Views per room; default: one per cell.")
@click.option("--size", "size_px", type=click.IntRange(16, 4096), default=300, show_default=True)
@says_refusals
def make_set(
    out: Path,
    workers: int,
    parts: tuple[str, ...],
    only: tuple[str, ...],
    seed: int,
    views: int | None,
    size_px: int,
) -> None:
    """Make the paper's evaluation set: recordings, truth, instructions, manifest.

    A recording that is there and whole is not made again.
    """
    from doro_console.references import write_references
    from doro_sim_feeder.rooms.evaluation_set import select
    from doro_sim_feeder.rooms.make_set import Render, make_set, write_manifest
    from doro_sim_feeder.rooms.more_sets import plan_all, plan_part

    started = time.monotonic()
    rows = select([row for part in parts for row in plan_part(part, seed)], only)
    folder = Render(out, size_px, views)
    made: list[Made] = []
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    with Progress(*columns, TimeElapsedColumn(), console=talk, transient=True) as progress:
        task = progress.add_task("rendering", total=len(rows))
        for one in make_set(rows, folder, workers):
            made.append(one)
            progress.update(task, advance=1, description=one.row.name)
            for lost in one.truth.missing:
                talk.print(
                    f"{one.row.name}: {lost.object_type} {lost.name} left out: {lost.reason}",
                    markup=False,
                )
    sentences = sum(write_references(out, one.truth) for one in made)
    manifest = write_manifest(plan_all(seed), made, folder, seed)
    again = sum(one.again for one in made)
    views_made = sum(one.truth.views for one in made)
    talk.print(
        f"{len(made)} recordings, {again} made now, {views_made} views,"
        f" {sum(one.truth.size_bytes for one in made) / 1e9:.3f} GB, {sentences} instructions,"
        f" {time.monotonic() - started:.1f} s",
        markup=False,
    )
    click.echo(manifest)


@rooms.command("check")
@click.argument("names", nargs=-1)
@click.option("--views", default=8, show_default=True, help="Views rendered of each room.")
@click.option("--copies", help="Spawn copies first and measure them, e.g. Cup=4.")
@click.option("--seed", default=0, show_default=True)
@click.option("--json", "as_json", is_flag=True, help="JSON lines on stdout.")
@says_refusals
def check(names: tuple[str, ...], views: int, copies: str | None, seed: int, as_json: bool) -> None:
    """Render rooms (default: all 120) and measure depth, boxes, floating and penetration."""
    from doro_sim_feeder.rooms.__main__ import copy_spec
    from doro_sim_feeder.rooms.check import all_rooms, check_rooms

    wanted = list(names) or all_rooms()
    found: list[RoomCheck] = []
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    with Progress(*columns, TimeElapsedColumn(), console=talk, transient=True) as progress:
        task = progress.add_task("checking", total=len(wanted))
        spec = copy_spec(copies, "", "mixed")
        for one in check_rooms(wanted, views=views, copies=spec, seed=seed):
            found.append(one)
            progress.update(task, advance=1, description=one.room)
            if as_json:
                click.echo(json.dumps(msgspec.to_builtins(one)))
            if one.problem:
                talk.print(f"{one.room} is refused: {one.problem}", markup=False)
            for reason in one.missing:
                talk.print(f"{one.room}: no place for {reason}", markup=False)
    _say_checks(found)
    sys.exit(1 if any(one.problem for one in found) else 0)


def _say_checks(found: list[RoomCheck]) -> None:
    worst = max(found, key=lambda one: one.worst_box_m)
    own, loose = sum(one.own_things for one in found), sum(len(one.own_loose) for one in found)
    talk.print(
        f"{len(found)} rooms, {sum(bool(one.problem) for one in found)} refused;"
        f" {sum(one.measured for one in found)} views of instances, at most"
        f" {worst.worst_box_m * 1000:.2f} mm outside of their boxes (99th percentile,"
        f" {worst.room});"
        f" {sum(one.copies for one in found)} copies placed,"
        f" {sum(len(one.missing) for one in found)} without a place,"
        f" {sum(len(one.loose) for one in found)} floating or cutting in;"
        f" {loose} of {own} own small things do;"
        f" {sum(len(one.inner_wall) for one in found)} things on inner walls left out",
        markup=False,
    )


@rooms.command("stats")
@click.argument("folder", type=FOLDER)
@click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")
@says_refusals
def stats(folder: Path, as_json: bool) -> None:
    """Show what a set holds: observations, instances per class and count, what is seen."""
    from doro_sim_feeder.rooms.statistics import statistics

    found = statistics(folder)
    if as_json:
        click.echo(json.dumps(msgspec.to_builtins(found)))
        return
    console = Console()
    for table in _tables(found):
        console.print(table)
    console.print(f"{found.size_bytes / 1e9:.3f} GB")
    for line in found.missing:
        console.print(f"no place: {line}", markup=False)


def _tables(found: SetStatistics) -> tuple[Table, Table]:
    views = Table("part", "recordings", "mean", "sigma", "least", "most", title="Observations")
    for one in found.observations:
        views.add_row(*(str(value) for value in msgspec.structs.astuple(one)))
    mean, sigma = found.paper_observations
    views.add_row("paper", "", str(mean), str(sigma), "", "")
    counts = ("1", "2", "3", "4", "5")
    classes = Table(
        "class", "recordings", "visible", "never seen", *counts, "more", title="Classes"
    )
    for item in found.classes:
        more = sum(number for count, number in item.by_count.items() if count not in counts)
        row = [item.recordings, item.visible, item.hidden]
        row += [item.by_count.get(count, 0) for count in counts]
        classes.add_row(item.object_type, *(str(value) for value in [*row, more]))
    return views, classes
