"""Names fused over views: what a detector calls a thing is decided by all that it said of it.

A detector that looks at images names a thing now this, now that, and its class distribution is
right more often than its winner. Distributions seen at one place are multiplied (dampened, as
views of one thing err alike), and each sighting goes on with the name that is likeliest after
all views so far, so that one thing makes one track. Detections without a distribution, and those
of an oracle, pass untouched.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import msgspec
import numpy as np

from doro_mapper.projection import Measured
from doro_mapper.views import Floats
from doro_schemas.graph import ObjectGraph
from doro_schemas.messages import ClassProbability, GraphBox
from doro_schemas.vocabulary import canonical_name

FLOOR = 0.02
"""Of a class that a distribution leaves out."""
DAMPING = 0.6
NEAR_M, NEAR_SHARE = 0.08, 0.3
MOST_RATIO = 2.0
"""Of the sizes of two sightings of one thing."""
LEAST_AGREEMENT = 0.1
"""What the distributions of two sightings of one thing have in common."""
MOST_SPOTS, MOST_NAMES, SHOWN = 2000, 24, 5


@dataclass(slots=True)
class _Spot:
    """A place with a thing: its measured centre (mean over views) and the names' log weights."""

    center_m: Floats
    side_m: float
    views: int = 0
    names: dict[str, float] = field(default_factory=dict)
    unnamed: float = 0.0

    def add(self, center_m: Floats, classes: dict[str, float], score: float) -> None:
        """Take a sighting in; a detector that is unsure of it counts less."""
        weight = DAMPING * score
        self.views += 1
        self.center_m = self.center_m + (center_m - self.center_m) / self.views
        for name in classes:
            # What came up only now had the floor in all views before.
            self.names.setdefault(name, self.unnamed)
        self.unnamed += weight * float(np.log(FLOOR))
        for name in self.names:
            self.names[name] += weight * float(np.log(max(classes.get(name, 0.0), FLOOR)))
        if len(self.names) > MOST_NAMES:
            del self.names[min(self.names, key=lambda name: (self.names[name], name))]

    def agrees(self, classes: dict[str, float]) -> bool:
        """Tell whether a distribution may be of the same thing."""
        own = dict(self.shares())
        common = sum(min(own.get(name, 0.0), share) for name, share in classes.items())
        return common >= LEAST_AGREEMENT

    def shares(self) -> list[tuple[str, float]]:
        """Return the names with their probabilities, best first, ties by name."""
        top = max(self.names.values())
        weights = {name: float(np.exp(value - top)) for name, value in self.names.items()}
        total = sum(weights.values())
        ranked = sorted(weights.items(), key=lambda item: (-item[1], item[0]))
        return [(name, weight / total) for name, weight in ranked]


class NameMemory:
    """The places of one episode and what was said of them. Memory: bounded."""

    def __init__(self) -> None:
        self._spots: list[_Spot] = []

    def fused(self, boxes: list[GraphBox], measured: Measured) -> list[GraphBox]:
        """Return the detections of one frame with names and distributions of all views so far.

        Args:
            boxes: row k of ``measured`` is where ``boxes[k]`` is.
        """
        taken: set[int] = set()
        out = list(boxes)
        for k in sorted(range(len(boxes)), key=lambda index: (-boxes[index].score, index)):
            classes = {canonical_name(one.name): one.probability for one in boxes[k].classes}
            if len(classes) < 2:
                continue
            size_m = measured.high_m[k] - measured.low_m[k]
            number = self._spot(measured.center_m[k], float(size_m.max()), classes, taken)
            taken.add(number)
            spot = self._spots[number]
            spot.add(measured.center_m[k], classes, boxes[k].score)
            out[k] = _renamed(boxes[k], spot.shares())
        return out

    def _spot(
        self, center_m: Floats, side_m: float, classes: dict[str, float], taken: set[int]
    ) -> int:
        """Return the number of the nearest free place within reach whose thing may be this one,
        a new one where none is.
        """
        if self._spots:
            centers = np.array([spot.center_m for spot in self._spots])
            sides = np.array([spot.side_m for spot in self._spots])
            gaps = np.linalg.norm(centers - center_m, axis=1)
            reach = np.maximum(NEAR_M, NEAR_SHARE * np.minimum(sides, side_m))
            alike = np.maximum(sides, side_m) <= MOST_RATIO * np.minimum(sides, side_m)
            near = np.flatnonzero((gaps <= reach) & alike)
            for number in near[np.argsort(gaps[near], kind="stable")].tolist():
                if number not in taken and self._spots[number].agrees(classes):
                    return int(number)
        if len(self._spots) >= MOST_SPOTS:
            oldest = min(range(len(self._spots)), key=lambda n: (self._spots[n].views, n))
            self._spots[oldest] = _Spot(center_m.copy(), side_m)
            return oldest
        self._spots.append(_Spot(center_m.copy(), side_m))
        return len(self._spots) - 1


def _renamed(box: GraphBox, shares: list[tuple[str, float]]) -> GraphBox:
    name = shares[0][0]
    graph = box.graph
    if name != graph.name:
        graph = ObjectGraph(name=name, attributes=graph.attributes, relations=graph.relations)
    classes = [ClassProbability(name=word, probability=share) for word, share in shares[:SHOWN]]
    return msgspec.structs.replace(box, graph=graph, classes=classes)
