"""``doro rooms``: rendered iTHOR rooms, the evaluation's set, checks and statistics."""

from __future__ import annotations

import sys

import click

from doro_console.options import says_refusals


@click.group()
def rooms() -> None:
    """Render iTHOR rooms without Unity (needs the extra doro-sim-feeder[render])."""


@rooms.command("render", context_settings={"ignore_unknown_options": True})
@click.argument("arguments", nargs=-1, type=click.UNPROCESSED)
@says_refusals
def render(arguments: tuple[str, ...]) -> None:
    """Render the exploration of a room: FloorPlan1 --copies Cup=4 --out FILE; see `-- --help`."""
    from doro_sim_feeder.rooms.__main__ import main

    sys.exit(main(["render", *arguments]))
