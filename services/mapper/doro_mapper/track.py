"""One object track: its sightings, robust geometry and votes."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from doro_mapper.boxes import Boxes
from doro_mapper.finder import Sighting, attributes_agree, names_agree
from doro_mapper.views import Bools, Views
from doro_schemas.vocabulary import name_satisfies

LATEST = 64
"""Measurements that make the geometry."""
QUANTILE = 0.2
BORDER_WEIGHT = 0.3
FULL_AREA_SHARE = 4000 / 90000
GRAPH_MISMATCH = 2.0
"""Factor on the distance between things whose attributes contradict each other."""
NAME_SHARE = 0.25
EXPECT_SHARE = 0.45
EXPECT_FILL = 0.5
EXPECT_AREA_SHARE = 1 / 600
EXPECT_CHUNKS = 8
NEVER = 99.0


def evidence_weight(sighting: Sighting) -> float:
    """Return what a sighting counts: large, near and whole in the image is best."""
    place = sighting.place
    whole = BORDER_WEIGHT if place.at_border else 1.0
    size_px_like = 300.0 * math.sqrt(min(place.area_share, FULL_AREA_SHARE))
    return max(1e-6, sighting.score) * size_px_like * whole / (0.5 + place.range_m)


class Track:
    """Sightings believed to be of one thing.

    Attributes:
        sightings, weights: in order of arrival.
        measured: whether a sighting adds geometry (not one matched only by reprojection).
        center_m, low_m, high_m: (3,) robust geometry.
        name, attributes: voted.
    """

    __slots__ = (
        "_attribute_votes",
        "_checked",
        "_expected",
        "_name_votes",
        "attributes",
        "center_m",
        "high_m",
        "low_m",
        "measured",
        "name",
        "sightings",
        "weights",
    )

    def __init__(self) -> None:
        self.sightings: list[Sighting] = []
        self.weights: list[float] = []
        self.measured: list[bool] = []
        self.center_m = self.low_m = self.high_m = np.zeros(3)
        self.name = ""
        self.attributes: dict[str, str] = {}
        self._name_votes: dict[str, float] = {}
        self._attribute_votes: dict[str, dict[str, float]] = {}
        self._expected: Bools = np.zeros(0, dtype=bool)
        self._checked = 0

    def copy(self) -> Track:
        """Return an independent copy (sightings themselves are immutable)."""
        other = Track()
        other.sightings, other.weights = list(self.sightings), list(self.weights)
        other.measured = list(self.measured)
        other.center_m, other.low_m, other.high_m = self.center_m, self.low_m, self.high_m
        other.name, other.attributes = self.name, self.attributes
        other._name_votes = dict(self._name_votes)
        other._attribute_votes = {k: dict(v) for k, v in self._attribute_votes.items()}
        other._expected, other._checked = self._expected, self._checked
        return other

    def add(self, sighting: Sighting, measured: bool = True) -> None:
        """Add one sighting."""
        weight = evidence_weight(sighting)
        self.append(sighting, weight, measured)
        self._vote(sighting, weight)
        self._update()

    def append(self, sighting: Sighting, weight: float, measured: bool) -> None:
        """Add a sighting without its vote and geometry."""
        self.sightings.append(sighting)
        self.weights.append(weight)
        self.measured.append(measured)

    def join(self, other: Track, measured: bool) -> None:
        """Take over all of another track; its geometry only if ``measured``."""
        for sighting, weight, own in zip(
            other.sightings, other.weights, other.measured, strict=True
        ):
            self.append(sighting, weight, own and measured)
            self._vote(sighting, weight)
        self._update()

    def remembered(self, oldest: int) -> Track | None:
        """Return the track without sightings older than serial ``oldest``; None if none is left."""
        if self.sightings[0].serial >= oldest:
            return self
        out = Track()
        for sighting, weight, measured in zip(
            self.sightings, self.weights, self.measured, strict=True
        ):
            if sighting.serial >= oldest:
                out.append(sighting, weight, measured)
                out._vote(sighting, weight)
        if not any(out.measured):
            return None
        out._update()
        return out

    def _vote(self, sighting: Sighting, weight: float) -> None:
        graph = sighting.graph
        self._name_votes[graph.name] = self._name_votes.get(graph.name, 0.0) + weight
        for kind, value in graph.attributes.items():
            votes = self._attribute_votes.setdefault(kind, {})
            votes[value] = votes.get(value, 0.0) + weight

    def _update(self) -> None:
        self.name = voted_name(self._name_votes)
        self.attributes = {
            kind: ranked(votes)[0] for kind, votes in sorted(self._attribute_votes.items())
        }
        self._checked = 0
        pairs = zip(self.sightings, self.weights, self.measured, strict=True)
        chosen = [(s.place, w) for s, w, measured in pairs if measured][-LATEST:]
        center = np.array([place.center_m for place, _ in chosen])
        low = np.array([place.low_m for place, _ in chosen])
        high = np.array([place.high_m for place, _ in chosen])
        weight = np.array([w for _, w in chosen])
        if len(chosen) < 3:
            weight /= weight.sum()
            self.center_m, self.low_m, self.high_m = weight @ center, weight @ low, weight @ high
            return
        residual = np.linalg.norm(center - np.median(center, axis=0), axis=1)
        scale = np.median(residual) + 0.02
        weight = weight * np.exp(-0.5 * np.minimum(residual / (2 * scale), 6) ** 2) + 1e-9
        self.low_m = np.quantile(low, QUANTILE, axis=0)
        self.high_m = np.quantile(high, 1 - QUANTILE, axis=0)
        mean = weight @ center / weight.sum()
        self.center_m = 0.5 * mean + 0.25 * (self.low_m + self.high_m)

    def points_m(self) -> NDArray[np.float32]:
        """Return points of up to EXPECT_CHUNKS sightings spread over time, (n, 3)."""
        own = [
            s.place for s, measured in zip(self.sightings, self.measured, strict=True) if measured
        ]
        chunks = np.linspace(0, len(own) - 1, min(len(own), EXPECT_CHUNKS)).astype(int)
        step = 1 if len(own) < 3 else 2
        return np.concatenate([own[i].points_m[::step] for i in chunks])

    def seen(self, views: Views) -> Bools:
        """Return by slot the views that have a sighting."""
        out = np.zeros(views.count, dtype=bool)
        out[views.slots([sighting.serial for sighting in self.sightings])] = True
        return out

    def expected(self, views: Views) -> Bools:
        """Return by slot the views that ought to have seen it.

        At least 45 % of its points in the image and not occluded, and large enough.
        """
        if self._checked == views.total:
            return self._expected
        size = np.linalg.norm(np.maximum(self.high_m - self.low_m, 0.02))
        out = np.zeros(views.count, dtype=bool)
        slots = views.near(self.center_m, float(size))
        if self._checked and views.total <= len(out):  # only what came since is new
            out[: len(self._expected)] = self._expected
            slots = slots[slots >= self._checked]
        if len(slots):
            slack = max(0.06, 0.35 * float(size))
            visible, depth = views.visible(self.points_m(), slots, slack)
            share = visible.mean(axis=1)
            range_m = np.maximum(np.median(depth, axis=1), 0.1)
            area_m2 = float(
                np.median(
                    [
                        s.place.size_m[0] * s.place.size_m[1]
                        for s, measured in zip(self.sightings, self.measured, strict=True)
                        if measured
                    ]
                )
            )
            per_m2, image = views.image_px(slots)
            area_share = area_m2 * per_m2 / image / range_m**2 * EXPECT_FILL * share
            out[slots] = (share >= EXPECT_SHARE) & (area_share >= EXPECT_AREA_SHARE)
        self._expected, self._checked = out, views.total
        return out


def ranked(votes: dict[str, float]) -> list[str]:
    """Return the values by votes, most first; equal votes in alphabetical order."""
    return sorted(votes, key=lambda value: (-votes[value], value))


def voted_name(votes: dict[str, float]) -> str:
    """Return the class: votes for a hypernym count for its kinds ("lamp" for "desk lamp")."""
    if len(votes) == 1:
        return next(iter(votes))
    total = sum(votes.values())
    backed = {
        name: sum(w for other, w in votes.items() if name_satisfies(other, name))
        for name, weight in votes.items()
        if weight >= NAME_SHARE * total
    }
    return ranked(backed or votes)[0]


def boxes_of(tracks: list[Track]) -> Boxes:
    """Return the geometry of tracks."""
    return Boxes(
        np.array([track.center_m for track in tracks]),
        np.array([track.low_m for track in tracks]),
        np.array([track.high_m for track in tracks]),
    )


def graph_factor(
    name: str, attributes: dict[str, str], other_name: str, other_attributes: dict[str, str]
) -> float:
    """Return the factor on the distance of two things with these graphs."""
    if not names_agree(name, other_name):
        return NEVER
    return 1.0 if attributes_agree(attributes, other_attributes) else GRAPH_MISMATCH
