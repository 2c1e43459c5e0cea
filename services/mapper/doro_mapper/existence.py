"""When views make an instance, and when they say that it has gone."""

from __future__ import annotations

import math

from doro_mapper.settings import MapperSettings

DETECTED, FALSE = 0.6, 0.02
"""How often a thing in view is detected, and how often something is where nothing is."""
PRIOR = math.log(9.0)
"""Of ten tracks that a detector opens, one is a thing."""
LEAST_PROBABILITY = 0.8
FURNITURE_M = 0.6
"""Things with a longer side are seen in part more often than whole."""
LEAST_CERTAIN = 0.5
GONE_MISSES = 10
GONE_CHANCE = 1e-8
GONE_EMPTY = 5
MOST_RATE = 0.9


def probability(hits: int, misses: int) -> float:
    """Return the probability that a thing exists, from the views that saw it and those that
    should have and did not."""
    odds = hits * math.log(DETECTED / FALSE) + misses * math.log((1 - DETECTED) / (1 - FALSE))
    return 1 / (1 + math.exp(-max(-30.0, min(30.0, odds - PRIOR))))


def enough(
    counted: tuple[int, int],
    views: int,
    settings: MapperSettings,
    doubt: float = 0.0,
    *,
    singles: bool = False,
    longest_m: float = 0.0,
    of_set: bool = False,
) -> bool:
    """Tell whether hits against misses make an instance (study, point 7).

    Args:
        counted: hits and misses.
        views: frames merged so far.
        doubt: how many of the hits are wrong by the detector's own calibrated scores.
        singles: what one view saw, and no other should have seen, is believed.
        longest_m: side of its box. Detectors that err overlook furniture that is seen in part.
        of_set: stands beside others of its class that are believed (``sets.py``).

    What many views saw for certain may be missed by more: a chair behind a table is seen from one
    side of the room only, and nothing that is not there is seen so often.
    """
    hits, misses = counted
    certain = hits - doubt
    least, share = float(settings.min_hits), settings.min_hit_share
    if doubt > 0:
        least, share = settings.min_certain, settings.min_certain_share
        if longest_m >= FURNITURE_M:
            share = settings.min_certain_share_furniture
        if certain >= settings.many_certain:
            share = min(share, settings.many_certain_share)
        if of_set:
            share = min(share, settings.set_share)
    if hits < share * (hits + misses):
        return False
    if certain >= least:
        return hits == 1 or probability(hits, misses) >= LEAST_PROBABILITY
    alone = hits >= 1 and misses == 0 and (singles or views < settings.few_views)
    return alone and certain >= LEAST_CERTAIN


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
