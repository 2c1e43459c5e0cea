"""Detections of a frame, measured: what every method of telling instances apart is fed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from doro_mapper.projection import Measured
from doro_mapper.views import Floats
from doro_schemas.graph import ObjectGraph
from doro_schemas.messages import ClassProbability


@dataclass(frozen=True, slots=True)
class Sighting:
    """One detection of one frame, measured.

    Attributes:
        serial: the frame's number in order of merging.
        graph: canonical graph of the detection, relations included.
        classes: the detector's class distribution, canonical; may be empty.
        weight: what it counts in votes and geometry.
        doubt: probability that it is wrong, by a calibrated score; 0 where there is none.
    """

    serial: int
    camera: str
    frame: int
    box_px: tuple[float, ...]
    score: float
    caption: str
    graph: ObjectGraph
    classes: tuple[ClassProbability, ...] = ()
    weight: float = 1.0
    doubt: float = 0.0


@dataclass(frozen=True, slots=True)
class FrameSightings:
    """All sightings of one frame; row k of ``measured`` is where ``sightings[k]`` is."""

    serial: int
    camera: str
    frame: int
    sightings: list[Sighting]
    measured: Measured

    def weights(self) -> Floats:
        """Return the sightings' weights, (n,)."""
        return np.array([sighting.weight for sighting in self.sightings])
