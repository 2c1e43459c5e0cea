"""``doro-router``: the embedded Zenoh router as a process of its own."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from doro_schemas.bus import BusSettings, run_router
from doro_schemas.errors import Refused
from doro_schemas.runner import parse_arguments
from doro_schemas.settings import load_settings


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the router until SIGTERM."""
    path, overrides = parse_arguments("router", arguments)
    try:
        run_router(load_settings("bus", BusSettings, path, overrides))
    except Refused as refused:
        sys.exit(f"doro-router: {refused.reason}")


if __name__ == "__main__":
    main()
