"""Which generator made a room: part of every recording and of its digest."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, version

# Counts up whenever the same room and seed give other bytes.
ROOMS = 4


def generator_version() -> str:
    """Return the version of this package, of its rooms and of the ray caster."""
    try:
        caster = version("embreex")
    except PackageNotFoundError:
        caster = "none"
    return f"doro-sim-feeder {version('doro-sim-feeder')}, rooms {ROOMS}, embreex {caster}"
