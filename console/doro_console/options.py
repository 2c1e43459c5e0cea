"""What all commands share: settings, the bus, and how a refusal is said."""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import AbstractContextManager
from functools import wraps
from importlib.resources import as_file, files
from pathlib import Path
from typing import ParamSpec

import click
import msgspec
from rich.console import Console

from doro_schemas.bus import Bus, BusSettings
from doro_schemas.errors import Refused
from doro_schemas.settings import load_settings

P = ParamSpec("P")
SAMPLE = "sample-kitchen.mcap"
talk = Console(stderr=True, highlight=False, soft_wrap=True)
"""Talk and progress go to stderr; outputs meant for programs go to stdout."""


class Common(msgspec.Struct, frozen=True):
    """The settings file and overrides of a command line."""

    config: Path | None
    overrides: tuple[str, ...]

    def bus_settings(self, **changes: float | str) -> BusSettings:
        """Return the table ``[bus]``, with changes."""
        settings = load_settings("bus", BusSettings, self.config, self.overrides)
        return msgspec.structs.replace(settings, **changes)

    def bus(self, name: str, open_timeout_s: float = 2.0) -> Bus:
        """Return a bus that gives up quickly where no router runs."""
        return Bus(name, self.bus_settings(open_timeout_s=open_timeout_s))


def sample_recording() -> AbstractContextManager[Path]:
    """Return the sample room that comes with sim-feeder, as a file."""
    return as_file(files("doro_sim_feeder") / "data" / SAMPLE)


def deploy_folder() -> Path:
    """Return the folder with the process list and the settings of one host.

    Raises:
        Refused: it is neither in the package nor in the checkout.
    """
    here = Path(__file__).resolve().parent
    for folder in (here / "deploy", here.parent.parent / "deploy"):
        if (folder / "supervisord.conf").exists():
            return folder
    raise Refused("the folder deploy/ is missing: reinstall doro-console or use the checkout")


def common_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add ``--config`` and ``--set`` to a command, handed in as ``common``."""

    @click.option(
        "--config",
        type=click.Path(path_type=Path, dir_okay=False),
        help="Settings file (TOML); default: deploy/doro.toml.",
    )
    @click.option("--set", "overrides", multiple=True, metavar="TABLE.KEY=VALUE")
    @wraps(command)
    def wrapped(config: Path | None, overrides: tuple[str, ...], **others: object) -> None:
        command(common=Common(config or deploy_folder() / "doro.toml", overrides), **others)

    return wrapped


def says_refusals(command: Callable[P, None]) -> Callable[P, None]:
    """End a command with exit status 1 and one sentence where something is refused."""

    @wraps(command)
    def wrapped(*args: P.args, **kwargs: P.kwargs) -> None:
        try:
            command(*args, **kwargs)
        except Refused as refused:
            talk.print(f"doro: {refused.reason}", style="red", markup=False)
            sys.exit(1)
        except KeyboardInterrupt:
            sys.exit(130)

    return wrapped
