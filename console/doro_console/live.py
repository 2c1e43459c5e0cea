"""``doro eval live``: some of the pairs through the running services, beside the in-process run."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING

import click

from doro_console.bench_dialogue import instruct, running_services
from doro_console.conversation import Conversation
from doro_console.counting import Options, ensure_set, make_context, progress_bar, shared_options
from doro_console.options import says_refusals

if TYPE_CHECKING:
    from doro_evaluation.context import Context
    from doro_evaluation.queries.live import Compared


def compare_live(
    asked: Sequence[tuple[Path, str]], errors: str, context: Context
) -> Iterator[Compared]:
    """Yield each (recording, instruction), in order of recordings, asked in both ways."""
    from doro_evaluation.chain import ERROR_MODELS, Language
    from doro_evaluation.queries.live import Compared, InProcess, differences
    from doro_schemas.detector_errors import ErrorModels, read_pool
    from doro_sim_feeder.play import Player, PlaySettings
    from doro_sim_feeder.recording import Recording

    pool = read_pool(Path(context.pool)) if context.pool else None
    language = Language(context.perception, context.nlu, pool)
    models = ErrorModels(errors=ERROR_MODELS[errors], seed=context.seed)
    settings = PlaySettings(errors=models, pool=pool)
    with running_services("off") as bus:
        conversation = Conversation(bus)
        player = Player(bus, settings)
        by_path: Callable[[tuple[Path, str]], Path] = lambda one: one[0]  # noqa: E731
        for path, group in groupby(sorted(asked), by_path):
            own = InProcess(path, errors, context, language)
            player.play(Recording(path))
            for _, text in group:
                instruct(bus, conversation, text)
                live = conversation.queries[-1]
                query = own.query(text, live.dialogue_id)
                said = query.text if query is not None else ""
                yield Compared(path.stem, text, live.text, said, differences(live, query))


@click.command("live")
@click.option("--pairs", "count", default=20, show_default=True, help="One a recording.")
@click.option("--errors", default="cs+sd+fn", show_default=True, help="Of the detector.")
@shared_options
@says_refusals
def live(options: Options, count: int, errors: str) -> None:
    """Pairs through the services over Zenoh: the same query as in process?"""
    from doro_evaluation.figures import write_figures
    from doro_evaluation.queries.live import figures_of
    from doro_evaluation.queries.pairs import select_pairs
    from doro_evaluation.runs import error_names, recordings_of, spread

    folder = ensure_set(options, "set", "paper")
    recordings = recordings_of(folder, "paper")
    context = make_context(recordings, "test", options)
    pairs = {pair.episode: pair for pair in reversed(select_pairs(folder, "test", 7))}
    chosen = spread([one for one in recordings if one.name in pairs], count)
    asked = [(Path(one.path), pairs[one.name].instruction) for one in chosen]
    found = []
    with progress_bar() as progress:
        task = progress.add_task("live", total=len(asked))
        for one in compare_live(asked, error_names(errors)[0], context):
            found.append(one)
            progress.update(task, advance=1, description=one.recording)
    for one in found:
        told = f"differs in {', '.join(one.differences)}" if one.differences else "same"
        click.echo(f"{told}: {one.recording}: {one.instruction} -> {one.live}")
        if one.differences:
            click.echo(f"  in process: {one.in_process}")
    figures = figures_of(found)
    click.echo(f"{figures['live/ours/same_query']} of {len(found)} queries are the same")
    command = f"doro eval live --pairs {count} --errors {errors}"
    write_figures(options.json_path, figures, command, options.seed)
