"""Exact contact of one thing with the rest: where it comes to rest, gaps, penetration.

All is measured on the triangles as rendered. A thing *floats* by ``gap_m``, the drop until it
touches something; it *penetrates* by the smallest shift along an axis that frees it of every
other surface.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from doro_sim_feeder.rooms.instances import Instance
from doro_sim_feeder.rooms.parts import Part, bounds
from doro_sim_feeder.rooms.raycast import RayCaster, make_soup

ALLOWED_M = 0.01
ABOVE_M = 0.02
AROUND_M = 0.06
SHIFTS_M = (0.001, 0.002, 0.003, 0.005, 0.0075, 0.01, 0.02, 0.03)
DIRECTIONS = ((0, 1, 0), (0, -1, 0), (1, 0, 0), (-1, 0, 0), (0, 0, 1), (0, 0, -1))
DOWN = np.array([0.0, -1.0, 0.0])
Points = NDArray[np.float64]


@dataclass(frozen=True)
class Contact:
    """How a thing stands to the rest.

    Attributes:
        gap_m: vertical distance to what is below; inf where nothing is, 0 where it cuts in.
        penetration_m: 0 where no surfaces cross; inf where 3 cm do not free it.
    """

    object_id: str
    gap_m: float
    penetration_m: float

    def holds(self) -> bool:
        """Tell whether it neither floats nor penetrates by more than 1 cm."""
        return self.gap_m <= ALLOWED_M and self.penetration_m <= ALLOWED_M


class Body:
    """Triangles of a thing around which rays are cast."""

    def __init__(self, parts: tuple[Part, ...]) -> None:
        soup = make_soup([(1, parts)])
        self.vertices: Points = soup.vertices.astype(np.float64)
        self.edges = _edges(soup.faces)
        self.caster = RayCaster(soup)
        self.low, self.high = (corner.astype(np.float64) for corner in bounds(parts))


class Around:
    """What is near a place: the triangles of the things whose boxes come close to it."""

    def __init__(self, others: list[Instance], low: Points, high: Points) -> None:
        """Take what overlaps the box from ``low`` to ``high`` with a margin, and all below it."""
        near = [item for item in others if _close(item, low, high)]
        self._parts = tuple(
            part for item in near for part in item.parts if _box_close(*bounds((part,)), low, high)
        )
        self._body = Body(self._parts) if self._parts else None

    def drop_m(self, body: Body, raised_m: float = 0.0) -> float:
        """Return how far a thing may fall from ``raised_m`` above its pose; inf: for ever."""
        rest = self._body
        if rest is None:
            return float("inf")
        lift = np.array([0.0, raised_m, 0.0])
        drops = rest.caster.cast(body.vertices + lift, _all(DOWN, body.vertices)).distance
        least = float(drops.min(initial=np.inf))
        inside = _over(rest.vertices, body) & (rest.vertices[:, 1] < body.low[1] + raised_m)
        below = rest.vertices[inside] - lift
        if len(below):
            rises = body.caster.cast(below, _all(-DOWN, below)).distance
            least = min(least, float(rises.min()))
        return least

    def crosses(self, body: Body, shift_m: Points | None = None) -> bool:
        """Tell whether surfaces cross: an edge of the one passes through a face of the other."""
        rest = self._body
        if rest is None:
            return False
        shift = np.zeros(3) if shift_m is None else shift_m
        if _cut(rest.caster, body.vertices + shift, body.edges):
            return True
        start, end = (rest.vertices[rest.edges[:, k]] - shift for k in (0, 1))
        near = (np.maximum(start, end) >= body.low) & (np.minimum(start, end) <= body.high)
        return _cut(body.caster, rest.vertices - shift, rest.edges[near.all(axis=1)])

    def contact(self, object_id: str, body: Body) -> Contact:
        """Return gap and penetration of a thing as it stands."""
        if not self.crosses(body):
            return Contact(object_id, self.drop_m(body), 0.0)
        for step_m in SHIFTS_M:
            for direction in DIRECTIONS:
                if not self.crosses(body, step_m * np.asarray(direction, np.float64)):
                    return Contact(object_id, 0.0, step_m)
        return Contact(object_id, 0.0, float("inf"))


def contacts(instances: tuple[Instance, ...], only_copies: bool = True) -> list[Contact]:
    """Return the contact of every spawned copy (or of all that can be picked up) with the rest."""
    found = []
    for k, item in enumerate(instances):
        if item.copy if only_copies else item.pickupable:
            body = Body(item.parts)
            others = [*instances[:k], *instances[k + 1 :]]
            found.append(Around(others, body.low, body.high).contact(item.object_id, body))
    return found


def _edges(faces: NDArray[np.int32]) -> NDArray[np.int32]:
    pairs = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    edges: NDArray[np.int32] = np.unique(np.sort(pairs, axis=1), axis=0)
    return edges


def _cut(caster: RayCaster, vertices: Points, edges: NDArray[np.int32]) -> bool:
    if not len(edges):
        return False
    start = vertices[edges[:, 0]]
    return bool(caster.occluded(start, vertices[edges[:, 1]] - start, reach=1.0).any())


def _close(item: Instance, low: Points, high: Points) -> bool:
    return _box_close(*item.corners, low, high)


def _box_close(
    other_low: NDArray[Any], other_high: NDArray[Any], low: Points, high: Points
) -> bool:
    """Tell whether a box is near, or anywhere below."""
    apart = (other_low > high + AROUND_M) | (other_high < low - AROUND_M)
    return not (apart[0] or apart[2] or other_low[1] > high[1] + AROUND_M)


def _over(points: Points, body: Body) -> NDArray[np.bool_]:
    inside = (points >= body.low) & (points <= body.high)
    over: NDArray[np.bool_] = inside[:, 0] & inside[:, 2]
    return over


def _all(direction: Points, points: Points) -> Points:
    return np.broadcast_to(direction, points.shape)
