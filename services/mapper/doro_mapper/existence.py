"""When views make an instance, and when they say that it has gone."""

from __future__ import annotations

from doro_mapper.settings import MapperSettings

LEAST_CERTAIN = 0.5
GONE_MISSES = 10
GONE_CHANCE = 1e-8
GONE_EMPTY = 5
MOST_RATE = 0.9


def enough(
    hits: int, misses: int, views: int, settings: MapperSettings, doubt: float = 0.0
) -> bool:
    """Tell whether hits against misses make an instance (study, point 7).

    Args:
        views: frames merged so far.
        doubt: how many of the hits are wrong by the detector's own calibrated scores.
    """
    certain = hits - doubt
    if hits < settings.min_hit_share * (hits + misses):
        return False
    alone = hits >= 1 and misses == 0 and views < settings.few_views
    return certain >= settings.min_hits or (alone and certain >= LEAST_CERTAIN)


def has_gone(hits: int, misses: int, telling: int, run: int, empty_run: int) -> bool:
    """Tell whether a thing that was there is there no longer.

    Either several views in a row looked through the place where it was, or so many views in a
    row should have seen it and did not that this would happen by chance once in 10^8 times.

    Args:
        telling: of the run, views whose missing it tells something.
        run: views since the last hit that should have seen it.
        empty_run: those of them that saw something farther away there.
    """
    if hits < 2:
        return False
    if empty_run >= GONE_EMPTY and empty_run >= 0.8 * run:
        return True
    rate = min(MOST_RATE, hits / max(1, hits + misses - run))
    return telling >= GONE_MISSES and (1 - rate) ** telling < GONE_CHANCE
