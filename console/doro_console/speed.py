"""``doro eval speed``: the paper's 32 ms and 3 ms, and what a frame and a question take."""

from __future__ import annotations

import click

from doro_console.counting import (
    Options,
    ensure_set,
    make_context,
    progress_bar,
    shared_options,
    show,
)
from doro_console.options import says_refusals
from doro_evaluation.figures import Figure


def run_speed(options: Options, most: int, taggers: bool = True) -> dict[str, Figure]:
    """Time the stages on some recordings and the taggers beside bert-base; print tables."""
    from doro_evaluation.bench import speed
    from doro_evaluation.queries.pairs import select_pairs
    from doro_evaluation.runs import recordings_of, spread
    from doro_evaluation.tagging import speed as tagging_speed
    from doro_evaluation.tagging.labels import SHIPPED, load_taggers

    folder = ensure_set(options, "set", "paper")
    every = recordings_of(folder, "paper")
    chosen = spread(every, most)
    context = make_context(every, "paper", options)
    pairs = select_pairs(folder, "test", 7)
    found: list[speed.Timed] = []
    with progress_bar() as progress:
        task = progress.add_task("speed", total=len(chosen))
        for one in chosen:
            own = [pair for pair in pairs if pair.episode == one.name]
            found += speed.time_recording(one, own, context)
            progress.update(task, advance=1, description=one.name)
    figures = speed.figures_of(found, len(chosen))
    show(speed.table_of(figures))
    if taggers:
        shipped = {name: load_taggers(None)[name] for name in SHIPPED}
        speeds = dict(tagging_speed.measure_speed(shipped, None))
        figures |= tagging_speed.speed_figures(speeds)
        show(tagging_speed.speed_table(speeds))
    return figures


@click.command("speed")
@click.option("--rooms", "most", default=8, show_default=True, help="Test recordings, spread.")
@click.option("--taggers/--no-taggers", default=True, help="Also the taggers beside bert-base.")
@shared_options
@says_refusals
def speed(options: Options, most: int, taggers: bool) -> None:
    """Time per sentence, frame and question; one thread, CPU and wall (paper, 32 ms and 3 ms)."""
    from doro_evaluation.figures import write_figures

    figures = run_speed(options, most, taggers)
    write_figures(options.json_path, figures, f"doro eval speed --rooms {most}", options.seed)
