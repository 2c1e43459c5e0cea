"""Places where a detector saw something that it could not name.

They are no instances and count as nothing; but "there is no cup" and "there is no cup, and two
things there I cannot name" are different answers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from doro_mapper.finder import Found
from doro_mapper.projection import Measured
from doro_mapper.views import Camera, Floats, moved_points

MOST_SEEN = 2000
LEAST_VIEWS = 3
NEAR_M, NEAR_SHARE, NAMED_M = 0.15, 0.4, 0.1
PART_SHARE = 0.4
"""What is in a much larger thing lies on or in it and is no part of it."""


@dataclass(frozen=True, slots=True)
class Place:
    """A place with something: centre in map axes, metres, and how many views showed it."""

    center_m: Floats
    views: int


@dataclass(slots=True)
class _Seen:
    serial: int
    center_m: Floats
    side_m: float


class UnnamedPlaces:
    """What was seen and not named in one episode. Memory: the latest 2000 sightings, 0.4 MB."""

    def __init__(self) -> None:
        self._seen: list[_Seen] = []

    def add(self, serial: int, measured: Measured) -> None:
        """Keep the sightings of a view."""
        sides = (measured.high_m - measured.low_m).max(axis=1) if len(measured) else np.zeros(0)
        for center_m, side_m in zip(measured.center_m, sides.tolist(), strict=True):
            self._seen.append(_Seen(serial, center_m, side_m))
        del self._seen[:-MOST_SEEN]

    def move(self, serial: int, old: Camera, new: Camera) -> None:
        """Take the sightings of a view from one camera to another."""
        for seen in self._seen:
            if seen.serial == serial:
                seen.center_m = moved_points(seen.center_m, old, new)

    def places(self, found: list[Found]) -> list[Place]:
        """Return the places that three views or more showed, most views first.

        Args:
            found: things that have a name, tentative ones among them; what lies inside of one
                of its size is taken for it.
        """
        groups: list[list[_Seen]] = []
        for seen in self._seen:
            near = [g for g in groups if _same(seen, g)]
            if near:
                near[0].append(seen)
            else:
                groups.append([seen])
        named = [item for item in found if not item.gone]
        out = []
        for group in groups:
            views = len({seen.serial for seen in group})
            center_m: Floats = np.mean([seen.center_m for seen in group], axis=0)
            side_m = float(np.median([seen.side_m for seen in group]))
            if views >= LEAST_VIEWS and not any(_is(center_m, side_m, item) for item in named):
                out.append(Place(center_m, views))
        return sorted(out, key=lambda place: (-place.views, place.center_m.tolist()))


def _same(seen: _Seen, group: list[_Seen]) -> bool:
    reach = max(NEAR_M, NEAR_SHARE * max(seen.side_m, group[0].side_m))
    return bool(np.linalg.norm(seen.center_m - group[0].center_m) <= reach)


def _is(center_m: Floats, side_m: float, item: Found) -> bool:
    if side_m < PART_SHARE * float((item.high_m - item.low_m).max()):
        return False
    low, high = item.low_m - NAMED_M, item.high_m + NAMED_M
    return bool(((center_m >= low) & (center_m <= high)).all())
