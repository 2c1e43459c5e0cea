"""Things come in sets: chairs round a table, books on a shelf, two lamps beside a bed.

Where a detector that errs is believed on several things of a class, another one that many views
miss is rather a thing half hidden than a wrong name, unless it is a piece of one of them.
"""

from __future__ import annotations

from collections.abc import Iterable

from doro_mapper.settings import MapperSettings
from doro_mapper.views import Floats

Box = tuple[Floats, Floats]
"""Low and high corner, map axes, metres."""


def completes(box: Box, others: Iterable[Box], settings: MapperSettings) -> bool:
    """Tell whether a thing stands beside enough others of its class, and in none of them.

    Args:
        box: of the thing that is doubted.
        others: of the things of its class that are believed without it.
    """
    known = list(others)
    if settings.set_things < 1 or len(known) < settings.set_things:
        return False
    return all(apart(box, other) for other in known)


def apart(a: Box, b: Box) -> bool:
    """Tell whether two boxes have no space in common."""
    return bool(((a[1] <= b[0]) | (b[1] <= a[0])).any())
