"""What every method of telling instances apart takes and gives."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from doro_mapper.projection import Measurement
from doro_mapper.views import Floats
from doro_schemas.graph import ObjectGraph
from doro_schemas.vocabulary import name_satisfies


@dataclass(frozen=True, slots=True)
class Sighting:
    """One detection of one frame, measured.

    Attributes:
        serial: the frame's number in order of merging.
        graph: canonical graph of the detection, relations included.
    """

    serial: int
    camera: str
    frame: int
    box_px: tuple[float, float, float, float]
    score: float
    caption: str
    graph: ObjectGraph
    place: Measurement


@dataclass(slots=True)
class Found:
    """An instance as a finder sees it; map axes, metres.

    Attributes:
        name: class.
        low_m, high_m: axis-aligned box.
        sightings: its views, in order.
        weights: evidence of each sighting, for votes.
        misses: frames that should have seen it and did not.
    """

    name: str
    center_m: Floats
    low_m: Floats
    high_m: Floats
    sightings: list[Sighting]
    weights: list[float]
    misses: int
    points_m: NDArray[np.float32] = field(default_factory=lambda: np.zeros((0, 3), np.float32))

    @property
    def hits(self) -> int:
        """Number of frames that saw it."""
        return len({sighting.serial for sighting in self.sightings})


class InstanceFinder(Protocol):
    """A method of telling instances apart, online. One file per method."""

    def add(self, serial: int, sightings: list[Sighting]) -> None:
        """Take the sightings of one frame. Its view is in the views already."""

    def find(self) -> list[Found]:
        """Return all instances as of now; does not change what later frames lead to."""


def family(name: str) -> str:
    """Return the head noun: only classes of one family can be one thing ("desk lamp", "lamp")."""
    return name.rsplit(" ", 1)[-1]


def names_agree(a: str, b: str) -> bool:
    """Tell whether two class names may mean one thing: equal, or one is a kind of the other."""
    return a == b or name_satisfies(a, b) or name_satisfies(b, a)


def attributes_agree(a: dict[str, str], b: dict[str, str]) -> bool:
    """Tell whether no attribute type has two values; one that is absent contradicts nothing."""
    return all(b.get(kind, value) == value for kind, value in a.items())


def extent(places: list[Measurement]) -> tuple[Floats, Floats]:
    """Return (low, high) corners of what several measurements of one thing show.

    The median over views: a view's own bounds hold some background or miss a side. Views cut
    off by the image's border are left out where there are others.
    """
    whole = [place for place in places if not place.at_border] or places
    low = np.median([place.outer_low_m for place in whole], axis=0)
    high = np.median([place.outer_high_m for place in whole], axis=0)
    return low, high
