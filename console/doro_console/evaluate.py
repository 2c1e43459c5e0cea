"""``doro eval``: the paper's evaluation, a command per table."""

from __future__ import annotations

import click

JSON = click.Path(dir_okay=False)


@click.group("eval")
def evaluate() -> None:
    """Measure how well it works; tables on stdout, with --json flat figures in a file."""
