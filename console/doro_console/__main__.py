"""The command ``doro``; what each command does stands in a file of its own."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import IO

import click
import msgspec
from rich.console import Console

from doro_console.bench_mapper import bench_mapper
from doro_console.caption import caption
from doro_console.evaluate import evaluate
from doro_console.hosts import hosts
from doro_console.media import import_folder, play, record
from doro_console.options import Common, common_options, says_refusals, talk
from doro_console.rooms import rooms
from doro_console.sheets import sheet
from doro_console.study import study
from doro_console.tune import tune

SENTENCES = (
    "bring me the red cup",
    "bring me the blue cup",
    "pick up the white toaster",
    "find the vase",
)
OUT = Path("out/demo")


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="doro-console")
def main() -> None:
    """DoRO: a robot that asks which one you mean."""


@main.command()
@click.option("--room", "recording", type=click.Path(path_type=Path), help="A recording (MCAP).")
@click.option("--instruction", "-i", "instructions", multiple=True, help="May be repeated.")
@click.option("--out", type=click.Path(path_type=Path, file_okay=False), default=OUT)
@click.option(
    "--backend", type=click.Choice(["oracle", "captioner", "coco", "onnx"]), default="oracle"
)
@click.option("--json", "as_json", is_flag=True, help="Queries as JSON lines on stdout.")
@common_options
@says_refusals
def demo(
    common: Common,
    recording: Path | None,
    instructions: tuple[str, ...],
    out: Path,
    backend: str,
    as_json: bool,
) -> None:
    """Start everything, play a room, say an instruction, print the question."""
    from doro_console.demo import DemoSettings, run_demo

    settings = DemoSettings(
        recording=recording,
        instructions=instructions or SENTENCES,
        out=out,
        backend=backend,
        as_json=as_json,
    )
    for query in run_demo(common, settings):
        if as_json:
            click.echo(json.dumps(msgspec.to_builtins(query)))


@main.command()
@common_options
@says_refusals
def up(common: Common) -> None:
    """Run the router and all services on this host until Ctrl-C; loopback only."""
    from doro_console.up import run_up

    sys.exit(run_up(common))


@main.command()
@click.argument("text")
@click.option("--wait", "wait_s", default=3.0, show_default=True, help="Seconds for the query.")
@common_options
@says_refusals
def say(common: Common, text: str, wait_s: float) -> None:
    """Say an instruction to the running services and print what comes back."""
    from doro_console.conversation import Conversation
    from doro_console.report import describe_graph, describe_query

    with common.bus("say") as bus:
        bus.stop_on_signals()
        conversation = Conversation(bus)
        parsed = conversation.say(text)
        talk.print(f"heard:  {describe_graph(parsed)}", markup=False)
        if parsed.graph is None:
            sys.exit(1)
        query = conversation.wait_for_query(1, wait_s)
        if query is None:
            talk.print("robot:  still looking around; the question comes when it has finished.")
            return
        click.echo("\n".join(describe_query(query)))


@main.command()
@click.option("--seconds", default=2.5, show_default=True, help="How long to listen at most.")
@click.option("--json", "as_json", is_flag=True, help="JSON lines on stdout.")
@common_options
@says_refusals
def status(common: Common, seconds: float, as_json: bool) -> None:
    """Show which services are alive, what they did, and what they refused."""
    from doro_console.status import gather, table

    with common.bus("status") as bus:
        statuses = gather(bus, seconds)
    for entry in statuses if as_json else []:
        click.echo(json.dumps(msgspec.to_builtins(entry)))
    if not as_json:
        Console().print(table(statuses))
    sys.exit(0 if all(entry.alive for entry in statuses) else 1)


@main.command()
@common_options
@says_refusals
def view(common: Common) -> None:
    """Watch a live run in Rerun's web viewer, on loopback."""
    from doro_viewer.service import main as viewer

    sys.argv = ["doro-viewer", "--config", str(common.config), "--set", "viewer.serve=true"]
    for override in common.overrides:
        sys.argv += ["--set", override]
    viewer()


@main.command()
@click.option("--caption", is_flag=True, help="The texts are captions, not instructions.")
@click.option("--labels", is_flag=True, help="Tokens, labels and their probabilities as well.")
@click.option("--conllu", type=click.File("r", encoding="utf-8"), help="CoNLL-U file; - = stdin.")
@common_options
@says_refusals
def parse(common: Common, caption: bool, labels: bool, conllu: IO[str] | None) -> None:
    """JSON lines {"id","text"} on stdin, or CoNLL-U -> {"id","graph"} on stdout."""
    from doro_console.lines import load_nlu, parse_record, parse_trees, run_lines

    if conllu is not None:
        for answer in parse_trees(conllu, caption=caption, labels=labels):
            click.echo(json.dumps(answer, ensure_ascii=False))
        return
    nlu = load_nlu(common.overrides)
    run_lines(
        sys.stdin, sys.stdout, lambda one: parse_record(nlu, one, caption=caption, labels=labels)
    )


@main.command()
@click.option("--paper-literal", is_flag=True, help="Decide by the paper's formulas as printed.")
@click.option("--seed", default=0, show_default=True, help="Chooses the wording.")
@click.option("--wordings", is_flag=True, help="Also give every wording, as a list.")
@common_options
@says_refusals
def decide(common: Common, paper_literal: bool, seed: int, wordings: bool) -> None:
    """JSON lines {"id","instruction" or "graph","instances"} -> {"id","state",...}."""
    from doro_console.lines import decide_line, load_nlu, run_lines

    nlu = load_nlu(common.overrides)
    run_lines(
        sys.stdin,
        sys.stdout,
        lambda one: decide_line(
            nlu, one, paper_literal=paper_literal, seed=seed, wordings=wordings
        ),
    )


@main.command()
@click.option("--seed", default=0, show_default=True, help="Chooses the wording.")
@common_options
@says_refusals
def answer(common: Common, seed: int) -> None:
    """JSON lines as for decide with "query","answer" -> {"id","action","target",...}."""
    from doro_console.lines import answer_line, load_nlu, run_lines

    nlu = load_nlu(common.overrides)
    run_lines(sys.stdin, sys.stdout, lambda one: answer_line(nlu, one, seed=seed))


@main.command()
@click.option("--wait", "wait_s", default=60.0, show_default=True, help="Seconds for a query.")
@common_options
@says_refusals
def chat(common: Common, wait_s: float) -> None:
    """Talk with the running services: instructions, questions, answers, until end of input."""
    from doro_console.chat import run_chat

    with common.bus("chat") as bus:
        bus.stop_on_signals()
        run_chat(bus, sys.stdin, wait_s)


@main.group()
def bench() -> None:
    """Measure; figures go to stdout and, with --json, into a file."""


@bench.command("bus")
@click.option("--json", "json_path", type=click.Path(path_type=Path, dir_okay=False))
@click.option("--count", default=400, show_default=True, help="Messages per series.")
@says_refusals
def bench_bus(json_path: Path | None, count: int) -> None:
    """Publish-to-receive of our bus beside raw zenoh with the same settings, in one run."""
    from doro_console.bench import run_bench_bus

    run_bench_bus(json_path, count)


@bench.command("play")
@click.option("--json", "json_path", type=click.Path(path_type=Path, dir_okay=False))
@click.option("--paced", default=60, show_default=True, help="Frames of the real-time play.")
@says_refusals
def bench_play(json_path: Path | None, paced: int) -> None:
    """167 frames of 300x300 through the bus with nothing else limiting, and the pacing."""
    from doro_console.bench import run_bench_play

    run_bench_play(json_path, paced)


@bench.command("dialogue")
@click.option("--json", "json_path", type=click.Path(path_type=Path, dir_okay=False))
@click.option(
    "--count", default=100, show_default=True, type=click.IntRange(1, 180), help="Instructions."
)
@click.option("--scenes", default=300, show_default=True, type=click.IntRange(8))
@click.option("--bus/--no-bus", "through_bus", default=True, help="Also through real services.")
@says_refusals
def bench_dialogue(json_path: Path | None, count: int, scenes: int, through_bus: bool) -> None:
    """Decision, question and answer on one thread; instruction to query through the bus."""
    from doro_console.bench_dialogue import run_bench_dialogue

    run_bench_dialogue(json_path, count, scenes, through_bus)


for command in (play, record, import_folder, rooms, hosts, evaluate, study, tune, caption):
    main.add_command(command)
rooms.add_command(sheet)
bench.add_command(bench_mapper)

if __name__ == "__main__":
    main()
