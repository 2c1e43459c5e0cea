"""Render a room: ``python -m doro_sim_feeder.rooms render FloorPlan4 --seed 3``."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path

from doro_schemas.errors import Refused
from doro_schemas.messages import Exploration, SimDetections
from doro_schemas.messages.base import Message
from doro_sim_feeder.rooms.copies import Arrangement, CopySpec
from doro_sim_feeder.rooms.episode import RoomEpisode, truth_json
from doro_sim_feeder.rooms.exploration import ORDERS
from doro_sim_feeder.rooms.sheet import write_sheet
from doro_sim_feeder.rooms.version import generator_version


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="doro_sim_feeder.rooms", description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    render = commands.add_parser("render", help="render the exploration of a room")
    render.add_argument("room", help="FloorPlan1-30, 201-230, 301-330, 401-430 or RoboTHOR1-75")
    render.add_argument("--seed", type=int, default=0)
    render.add_argument("--copies", metavar="CLASS=N", help="spawn N copies, e.g. Cup=4")
    render.add_argument("--colors", default="", help="colours of the copies, e.g. red,red,blue")
    render.add_argument("--arrange", choices=("apart", "mixed"), default="apart")
    render.add_argument("--allow-missing", action="store_true", help="report, do not refuse")
    render.add_argument("--order", choices=tuple(ORDERS), default="random")
    render.add_argument("--no-color", action="store_true", help="depth and ids only: fast")
    render.add_argument("--views", type=int, help="number of views (default: every cell)")
    render.add_argument("--size", type=int, default=300, help="side of the images, pixels")
    render.add_argument("--out", type=Path, help="recording to write, .mcap")
    render.add_argument("--truth", type=Path, help="ground truth to write, .json")
    render.add_argument("--sheet", type=Path, help="contact sheet to draw, .png")
    return parser


def copy_spec(copies: str | None, colors: str, arrange: Arrangement = "apart") -> CopySpec | None:
    """Return what ``Cup=4`` and ``red,red,blue`` ask for."""
    if not copies:
        return None
    name, _, count = copies.partition("=")
    if not name or not count.isdigit():
        raise Refused(f"--copies {copies} is not understood: write CLASS=N, for example Cup=4")
    names = tuple(word.strip() for word in colors.split(",") if word.strip())
    return CopySpec(name, int(count), names, arrange)


def _with_progress(messages: Iterator[Message], total: int) -> Iterator[Message]:
    for message in messages:
        if isinstance(message, SimDetections):
            print(f"\rview {message.frame + 1}/{total}", end="", file=sys.stderr, flush=True)
        elif isinstance(message, Exploration) and message.state == "finished":
            print(file=sys.stderr)
        yield message


def run(args: argparse.Namespace) -> None:
    """Render what the command line asks for."""
    spec = copy_spec(args.copies, args.colors, args.arrange)
    episode = RoomEpisode(
        args.room,
        seed=args.seed,
        copies=spec,
        views=args.views,
        size_px=args.size,
        color=not args.no_color,
        order=args.order,
        allow_missing=args.allow_missing,
    )
    for one in episode.missing:
        print(f"{args.room}: {one.object_type} {one.name} left out: {one.reason}", file=sys.stderr)
    if args.sheet:
        write_sheet(args.sheet, episode)
        print(f"contact sheet: {args.sheet}", file=sys.stderr)
    if args.out:
        from doro_sim_feeder.recording import (  # noqa: PLC0415 - only with --out
            TRUTH,
            write_recording,
        )

        metadata = {
            "room": args.room,
            "seed": str(args.seed),
            "source": "rendered",
            "generator": generator_version(),
        }
        messages = _with_progress(episode.messages(), len(episode.views))
        write_recording(args.out, messages, metadata, lambda: {TRUTH: truth_json(episode)})
    elif args.truth:
        for _ in _with_progress(episode.messages(), len(episode.views)):
            pass
    if args.truth:
        args.truth.write_bytes(truth_json(episode))


def main(arguments: list[str] | None = None) -> int:
    """Run a command line; ``arguments`` default to the process's own."""
    args = _parser().parse_args(arguments)
    try:
        run(args)
    except Refused as refused:
        print(f"error: {refused.reason}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
