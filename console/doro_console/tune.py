"""``doro tune``: fine-tune the shipped tagger on own labelled sentences."""

from __future__ import annotations

from pathlib import Path

import click

from doro_console.options import says_refusals

FOLDER = click.Path(path_type=Path, file_okay=False)


@click.command()
@click.argument("data", type=click.Path(path_type=Path, dir_okay=False))
@click.option("--out", type=FOLDER, required=True, help="Directory to write the model to.")
@click.option("--model", type=FOLDER, help="Encoder to start from; default: the shipped one.")
@click.option("--extend", is_flag=True, help="Learn types that the tagger does not know.")
@click.option("--steps", default=200, show_default=True)
@click.option("--seed", default=7, show_default=True)
@says_refusals
def tune(data: Path, out: Path, model: Path | None, extend: bool, steps: int, seed: int) -> None:
    """Fine-tune the tagger on DATA (JSON lines or BIO); prints F1 before and after.

    Needs torch and onnx: pip install 'doro-nlu[train]'. Use the result with nlu.model_dir.
    """
    from doro_nlu.train.tune import table, tune
    from doro_nlu.train.tune_job import Job

    job = Job(data=data, out=out, model=model, extend=extend, steps=steps, seed=seed)
    click.echo(table(tune(job)))
