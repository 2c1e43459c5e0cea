"""Commands around recordings: play, record, import."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import msgspec
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from doro_console.options import Common, common_options, says_refusals, talk
from doro_console.processes import NEEDED
from doro_schemas.errors import Refused

if TYPE_CHECKING:
    from doro_schemas.bus import Bus
    from doro_sim_feeder.play import PlayReport, PlaySettings
    from doro_sim_feeder.recording import Recording


@click.command()
@click.argument("recording", type=click.Path(path_type=Path))
@click.option("--speed", default=0.0, help="0: as fast as the chain takes it; 1: real time.")
@click.option("--from", "from_s", default=0.0, help="Start so many seconds in.")
@click.option("--to", "to_s", default=float("inf"), help="End so many seconds in.")
@click.option("--topic", "topics", multiple=True, help="Only these topics, by name.")
@click.option("--loop", default=1, show_default=True, help="Play so many times; 0: for ever.")
@click.option("--info", is_flag=True, help="Only say what the recording holds (JSON).")
@click.option("--salvage", is_flag=True, help="Play what is whole in a file that was cut off.")
@click.option("--repair", is_flag=True, help="Put frames in order, leave out incomplete ones.")
@click.option("--errors", default="", help="Detector errors to make: any of cs,sd,fn,fp.")
@click.option("--error-seed", default=0, show_default=True)
@click.option(
    "--fp-room",
    "fp_rooms",
    type=click.Path(path_type=Path),
    multiple=True,
    help="Recording of another room, from which false positives are pasted.",
)
@click.option(
    "--order",
    type=click.Choice(["recorded", "planned"]),
    default="recorded",
    show_default=True,
    help="planned: the views that the mapper's goals ask for, until it is done.",
)
@click.option("--views", default="", help="planned: so many views at most, 60 or 33%.")
@click.option("--wait", "wait_s", default=10.0, show_default=True, help="Seconds for services.")
@common_options
@says_refusals
def play(common: Common, recording: Path, **options: Any) -> None:
    """Play a recording to the running services as if it were the robot."""
    from doro_sim_feeder.recording import Recording, describe

    if options["info"]:
        click.echo(json.dumps(describe(Recording(recording, salvage=True))))
        return
    with common.bus("feeder") as bus:
        bus.stop_on_signals()
        try:
            opened = Recording(recording, salvage=options["salvage"])
            reports = _play_all(bus, opened, _play_settings(options), options)
        except Refused as refused:
            bus.reject(str(recording.name), refused)
            raise
    if any(report.lost or report.merged < report.frames for report in reports):
        sys.exit(2)


def _play_settings(options: dict[str, Any]) -> PlaySettings:
    from doro_schemas.detector_errors import ErrorModels, parse_errors
    from doro_schemas.topics import TOPICS
    from doro_sim_feeder.disturb import pool_from_recordings
    from doro_sim_feeder.play import PlaySettings
    from doro_sim_feeder.steps import INPUT_TOPICS, Cut

    unknown = sorted(set(options["topics"]) - set(TOPICS))
    if unknown:
        raise Refused(f"no topic '{unknown[0]}' to play; known are {', '.join(TOPICS)}")
    cut = Cut(
        topics=options["topics"] or INPUT_TOPICS, from_s=options["from_s"], to_s=options["to_s"]
    )
    return PlaySettings(
        speed=options["speed"],
        cut=cut,
        repair=options["repair"],
        errors=ErrorModels(errors=parse_errors(options["errors"]), seed=options["error_seed"]),
        pool=pool_from_recordings(options["fp_rooms"]) if options["fp_rooms"] else None,
        order=options["order"],
        views=options["views"],
    )


def _play_all(
    bus: Bus, opened: Recording, settings: PlaySettings, options: dict[str, Any]
) -> list[PlayReport]:
    """Play as often as asked; print a JSON line each time."""
    from doro_sim_feeder.play import Player
    from doro_sim_feeder.presence import Presence

    Presence(bus).wait_for(NEEDED, options["wait_s"])
    total = sum(n for key, n in opened.counts.items() if key.endswith("/depth")) or None
    columns = (TextColumn("playing"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    reports: list[PlayReport] = []
    with Progress(*columns, console=talk, transient=True) as progress:
        task = progress.add_task("frames", total=total)
        player = Player(bus, settings, lambda sent, _: progress.update(task, completed=sent))
        while not bus.stopping and (options["loop"] == 0 or len(reports) < options["loop"]):
            reports = [*reports[-1000:], player.play(opened)]
            _print_report(bus, reports[-1])
    return reports


def _print_report(bus: Bus, report: PlayReport) -> None:
    from doro_schemas.messages import GridRequest, GridSnapshot

    snapshot = bus.ask(GridRequest())
    digest = snapshot.digest if isinstance(snapshot, GridSnapshot) else ""
    fields = {**msgspec.structs.asdict(report), "map_digest": digest}
    rounded = {k: round(v, 3) if isinstance(v, float) else v for k, v in fields.items()}
    click.echo(json.dumps(rounded))


@click.command()
@click.option("--bus", "from_bus", is_flag=True, help="Record from the bus.")
@click.option("--ai2thor", "room", metavar="ROOM", help="Explore a room of the real AI2-THOR.")
@click.option("--out", type=click.Path(path_type=Path, dir_okay=False), required=True)
@click.option("--seconds", type=float, help="Stop after so long; default: at Ctrl-C.")
@click.option("--topic", "topics", multiple=True, help="Only these topics, by name.")
@click.option("--seed", default=0, show_default=True, help="Of the exploration of --ai2thor.")
@click.option("--views", type=int, help="So many observations; default: one per cell.")
@click.option("--order", default="random", show_default=True, help="random or sweep.")
@common_options
@says_refusals
def record(
    common: Common,
    from_bus: bool,
    room: str | None,
    out: Path,
    seconds: float | None,
    topics: tuple[str, ...],
    **exploration: Any,
) -> None:
    """Record what passes on the bus, or an exploration of AI2-THOR, into an MCAP file."""
    if from_bus == bool(room):
        raise Refused("say where to record from: --bus, or --ai2thor FloorPlan1")
    if room:
        count = _record_simulator(room, out, exploration)
    else:
        from doro_sim_feeder.record import record_bus

        with common.bus("recorder") as bus:
            bus.stop_on_signals()
            count = record_bus(bus, out, topics, seconds=seconds)
    talk.print(f"recorded {count} messages into {out}")


def _record_simulator(room: str, out: Path, exploration: dict[str, Any]) -> int:
    from doro_sim_feeder.recording import write_recording
    from doro_sim_feeder.simulator import SimulatorSettings, explore, open_controller

    settings = SimulatorSettings(room=room, **exploration)
    controller = open_controller(settings)
    try:
        return write_recording(out, explore(controller, settings), settings.recording_metadata())
    finally:
        controller.stop()


@click.command("import")
@click.argument("folder", type=click.Path(path_type=Path, file_okay=False))
@click.option("--out", type=click.Path(path_type=Path, dir_okay=False), required=True)
@click.option("--walk", "walks", multiple=True, help="Only these walks or episodes of the folder.")
@click.option("--episode", default="", help="Name of the episode; default: the folder's name.")
@says_refusals
def import_folder(folder: Path, out: Path, walks: tuple[str, ...], episode: str) -> None:
    """Make a recording of a folder: frames with poses (frames.json), or AI2-THOR events."""
    from doro_sim_feeder.recording import write_recording
    from doro_sim_feeder.sources import open_folder

    source = open_folder(folder)
    metadata = source.metadata(list(walks))
    count = write_recording(out, source.messages(list(walks), episode), metadata)
    talk.print(f"{count} messages of {folder.name} in {out}")
    if metadata.get("depth") == "none":
        talk.print("The events have no depth: the recording serves perception, not the map.")
