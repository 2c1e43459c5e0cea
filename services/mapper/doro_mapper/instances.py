"""Found instances as messages: ids, voted graphs, evidence, world axes."""

from __future__ import annotations

import numpy as np

from doro_mapper.finder import Found, Sighting
from doro_mapper.relations import relations_of
from doro_mapper.settings import MapperSettings
from doro_mapper.track import ranked
from doro_mapper.views import Floats
from doro_schemas.camera import World, bev_axes
from doro_schemas.graph import ObjectGraph
from doro_schemas.messages import Evidence, Instance

POSITION_GRAIN_M = 0.05


def build(instances: list[Found], world: World, settings: MapperSettings) -> list[Instance]:
    """Return all instances as messages, ordered by class and number.

    Numbers go by the frame that saw the instance first, then by position: they change as
    little as can be while the map grows, and not at all for equal input.
    """
    ordered = sorted(instances, key=_order)
    voted = [_vote(found) for found in ordered]
    graphs = [graph for graph, _ in voted]
    relations = relations_of(ordered, graphs, settings)
    numbers: dict[str, int] = {}
    out = []
    for found, (graph, runner_up), related in zip(ordered, voted, relations, strict=True):
        numbers[graph.name] = numbers.get(graph.name, 0) + 1
        hits = found.hits
        out.append(
            Instance(
                instance_id=f"{graph.name.replace(' ', '-')}-{numbers[graph.name]}",
                graph=ObjectGraph(graph.name, graph.attributes, related),
                position_m=_world(found.center_m, world),
                extent_m=_world(found.high_m - found.low_m, world),
                confidence=round((hits + 1) / (hits + found.misses + 2), 6),
                hits=hits,
                misses=found.misses,
                evidence=_evidence(found, settings.max_evidence),
                cells=_cells(found, settings),
                runner_up=runner_up,
            )
        )
    return out


def _order(found: Found) -> tuple[str, int, list[float]]:
    grain = np.round(found.center_m / POSITION_GRAIN_M).tolist()
    return found.name, min(sighting.serial for sighting in found.sightings), grain


def _vote(found: Found) -> tuple[ObjectGraph, dict[str, str]]:
    """Return class + attributes with most evidence each, and the second most seen values."""
    votes: dict[str, dict[str, float]] = {}
    for sighting, weight in zip(found.sightings, found.weights, strict=True):
        for kind, value in sighting.graph.attributes.items():
            counts = votes.setdefault(kind, {})
            counts[value] = counts.get(value, 0.0) + weight
    order = {kind: ranked(votes[kind]) for kind in sorted(votes)}
    best = {kind: values[0] for kind, values in order.items()}
    second = {kind: values[1] for kind, values in order.items() if len(values) > 1}
    return ObjectGraph(found.name, best), second


def _world(values: Floats, world: World) -> list[float]:
    """Return map-axes values in world axes, rounded to 0.1 mm."""
    out = [0.0, 0.0, 0.0]
    for axis, value in zip(bev_axes(world), values, strict=True):
        out[axis] = round(float(value), 4)
    return out


def _evidence(found: Found, most: int) -> list[Evidence]:
    """Return the strongest views: whole in the image, large, near, with a high score."""
    pairs = list(zip(found.sightings, found.weights, strict=True))
    best = sorted(pairs, key=lambda pair: (-pair[1], pair[0].serial))[:most]
    return [_shown(sighting) for sighting, _ in best]


def _shown(sighting: Sighting) -> Evidence:
    return Evidence(sighting.camera, sighting.frame, list(sighting.box_px), sighting.caption)


def _cells(found: Found, settings: MapperSettings) -> list[list[int]]:
    """Return the ground cells (a, b, band) of the instance's own points."""
    inside = np.all((found.points_m >= found.low_m) & (found.points_m <= found.high_m), axis=1)
    edges = np.array([settings.cell_m, settings.cell_m, settings.band_m])
    cells = np.unique(np.floor(found.points_m[inside] / edges).astype(int), axis=0)
    return [[int(value) for value in cell] for cell in cells]
