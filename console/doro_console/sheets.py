"""``doro rooms sheet``: rooms to look at."""

from __future__ import annotations

from pathlib import Path

import click

from doro_console.options import says_refusals, talk


@click.command("sheet")
@click.argument("room_names", metavar="[ROOM]...", nargs=-1)
@click.option("--seed", default=0, show_default=True, help="Of the rooms, where none is named.")
@click.option(
    "--renderer",
    type=click.Choice(["embree", "gl"]),
    default="embree",
    show_default=True,
    help="gl needs the extra doro-sim-feeder[render-gl] and EGL.",
)
@click.option(
    "--out",
    type=click.Path(path_type=Path, dir_okay=False),
    default=Path("rooms.png"),
    show_default=True,
)
@says_refusals
def sheet(room_names: tuple[str, ...], seed: int, renderer: str, out: Path) -> None:
    """Draw a view of each ROOM (default: nine of them): colour, depth and instance ids."""
    from doro_sim_feeder.rooms.sheet import some_rooms, write_room_sheet

    chosen = list(room_names) or some_rooms(seed)
    write_room_sheet(out, chosen, seed, renderer="gl" if renderer == "gl" else "embree")
    talk.print(f"{', '.join(chosen)} in {out}")
