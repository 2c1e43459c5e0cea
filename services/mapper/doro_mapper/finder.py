"""What every method of telling instances apart takes and gives."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from doro_mapper.existence import probability
from doro_mapper.sightings import FrameSightings
from doro_mapper.views import Camera, Floats
from doro_mapper.votes import Votes
from doro_schemas.vocabulary import name_satisfies

BORDER_WEIGHT = 0.3
FULL_AREA_SHARE = 4000 / 90000
GRAPH_MISMATCH = 2.0
"""Factor on the distance between things whose attributes contradict each other."""
NEVER = 99.0
Look = tuple[str, dict[str, str]]
"""Class, and value by attribute type."""


@dataclass(slots=True)
class Found:
    """An instance as a finder sees it; map axes, metres.

    Attributes:
        instance_id: its id for good; empty where the finder gives none.
        replaced: ids of things that turned out to be this one.
        name: class.
        low_m, high_m: axis-aligned box.
        hits, misses: frames that saw it; frames that should have and did not.
        votes: of its views.
        covariance_m2: (3, 3) of the centre.
        version: changes whenever anything else here does; a key for caches.
        first: serial of the first view, where ``instance_id`` is empty.
        small: may be hidden without anybody noticing less than larger things may.
        tentative: too little speaks for it to count.
        parts: messages made of it, kept by who made them.
        gone: its place was looked at again and it was not there.
    """

    name: str
    center_m: Floats
    low_m: Floats
    high_m: Floats
    hits: int
    misses: int
    votes: Votes
    points_m: NDArray[np.float32] = field(default_factory=lambda: np.zeros((0, 3), np.float32))
    covariance_m2: Floats = field(default_factory=lambda: np.zeros((3, 3)))
    instance_id: str = ""
    version: tuple[int, ...] = ()
    first: int = 0
    small: bool = False
    tentative: bool = False
    gone: bool = False
    replaced: tuple[str, ...] = ()
    parts: Any = None

    @property
    def confidence(self) -> float:
        """Probability that it exists, from hits and misses alone."""
        return probability(self.hits, self.misses)


@dataclass(frozen=True, slots=True)
class TrackSummary:
    """A track as a planner of views needs it; map axes, metres.

    Attributes:
        key: (row, birth): the same for the same track, never used again.
        related: captions state relations of it.
        spread_m: standard error of its centre.
        serials: views kept that saw it.
    """

    key: tuple[int, int]
    name: str
    attributes: dict[str, str]
    related: bool
    center_m: Floats
    low_m: Floats
    high_m: Floats
    hits: int
    misses: int
    spread_m: float
    serials: list[int]


class InstanceFinder(Protocol):
    """A method of telling instances apart, online. One file per method."""

    def add(self, frame: FrameSightings) -> None:
        """Take the sightings of one frame. Its view is in the views already."""

    def find(self) -> list[Found]:
        """Return all instances as of now; does not change what later frames lead to."""

    def lost(self) -> list[str]:
        """Return ids that were given to things forgotten since."""

    def tracks(self) -> list[TrackSummary]:
        """Return what is being tracked, for a planner; nothing where the method has no tracks."""

    def move(self, serial: int, old: Camera, new: Camera) -> None:
        """Take measurements of a view, whose pose was corrected, from one camera to another."""

    def moved(self) -> None:
        """Derive everything again after :meth:`move`; the views have their new cameras."""


def evidence_weight(score: float, area_share: float, range_m: float, at_border: bool) -> float:
    """Return what a sighting counts: large, near and whole in the image is best."""
    whole = BORDER_WEIGHT if at_border else 1.0
    size_px_like = 300.0 * math.sqrt(min(area_share, FULL_AREA_SHARE))
    return max(1e-6, score) * size_px_like * whole / (0.5 + range_m)


def family(name: str) -> str:
    """Return the head noun: classes of one family may be one thing ("desk lamp", "lamp")."""
    return name.rsplit(" ", 1)[-1]


@functools.lru_cache(maxsize=4096)
def names_agree(a: str, b: str) -> bool:
    """Tell whether two class names may mean one thing: equal, or one is a kind of the other."""
    return a == b or name_satisfies(a, b) or name_satisfies(b, a)


def attributes_agree(a: dict[str, str], b: dict[str, str]) -> bool:
    """Tell whether no attribute type has two values; one that is absent contradicts nothing."""
    return all(b.get(kind, value) == value for kind, value in a.items())


def graph_factor(a: Look, b: Look) -> float:
    """Return the factor on the distance of two things that look like this."""
    if not names_agree(a[0], b[0]):
        return NEVER
    return 1.0 if attributes_agree(a[1], b[1]) else GRAPH_MISMATCH
