"""Found instances as messages: ids, voted graphs, evidence, world axes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from doro_mapper.finder import Found
from doro_mapper.relations import relations_of
from doro_mapper.settings import MapperSettings
from doro_mapper.unnamed import Place
from doro_mapper.views import Floats
from doro_schemas.camera import World, bev_axes
from doro_schemas.graph import ObjectGraph
from doro_schemas.messages import ClassProbability, GoneInstance, Instance, UnnamedPlace
from doro_schemas.vocabulary import name_satisfies

POSITION_GRAIN_M = 0.05
MOST_CLASSES = 5


@dataclass(frozen=True, slots=True)
class Answer:
    """All that is known, as messages.

    Attributes:
        counted: instances, ordered by class and number.
        loose: things seen too little to count; there may be many, so that messages wait.
        gone: by id given that stands for no counted instance: the word, and its class.
        unnamed: places with something that has no name.
    """

    counted: list[Instance]
    loose: list[Found]
    gone: list[tuple[GoneInstance, str]]
    world: World
    settings: MapperSettings
    unnamed: list[UnnamedPlace]

    def tentative_of(self, name: str) -> list[Instance]:
        """Return things of a class and its kinds that were seen too little; of all for no name."""
        return [
            _message(found, _voted(found), self.world, self.settings)
            for found in self.loose
            if not name or name_satisfies(name, found.name)
        ]

    def gone_of(self, name: str) -> list[GoneInstance]:
        """Return what is gone of a class and its kinds; of all for no name."""
        return [word for word, own in self.gone if not name or name_satisfies(name, own)]


def build(
    instances: list[Found],
    lost: list[str],
    world: World,
    settings: MapperSettings,
    unnamed: Sequence[Place] = (),
) -> Answer:
    """Return all instances as messages, ordered by class and number.

    Where the finder gives no ids, numbers go by the frame that saw the instance first, then by
    position: they change as little as can be while the map grows.

    Args:
        lost: ids given to things that were forgotten.
        unnamed: places with something that has no name.
    """
    ordered = sorted(instances, key=_order)
    counted = [found for found in ordered if not found.tentative and not found.gone]
    _give_ids(counted)
    graphs = [_voted(found) for found in counted]
    relations = relations_of(counted, graphs, settings)
    messages = [
        _message(found, ObjectGraph(graph.name, graph.attributes, related), world, settings)
        for found, graph, related in zip(counted, graphs, relations, strict=True)
    ]
    loose = [found for found in ordered if found.tentative and not found.gone]
    places = [UnnamedPlace(_world(place.center_m, world), place.views) for place in unnamed]
    return Answer(messages, loose, _gone(ordered, lost), world, settings, places)


def _give_ids(counted: list[Found]) -> None:
    numbers: dict[str, int] = {}
    for found in counted:
        if not found.version:
            numbers[found.name] = numbers.get(found.name, 0) + 1
            found.instance_id = f"{found.name.replace(' ', '-')}-{numbers[found.name]}"


def _order(found: Found) -> tuple[str, str, int, int, list[float]]:
    word, _, number = found.instance_id.rpartition("-")
    grain = np.round(found.center_m / POSITION_GRAIN_M).tolist()
    return found.name, word, int(number or 0), found.first, grain


def _voted(found: Found) -> ObjectGraph:
    """Return class + attributes with most evidence each."""
    return ObjectGraph(found.name, dict(found.votes.look()[1]))


def _gone(ordered: list[Found], lost: list[str]) -> list[tuple[GoneInstance, str]]:
    out = []
    for found in ordered:
        counts = not found.tentative and not found.gone
        if found.instance_id and not counts:
            reason = "moved" if found.gone else "doubted"
            word = GoneInstance(found.instance_id, "moved" if reason == "moved" else "doubted")
            out.append((word, found.name))
        heir = found.instance_id if counts else ""
        out += [(GoneInstance(name, "merged", heir), found.name) for name in found.replaced]
    for name in lost:
        out.append((GoneInstance(name, "doubted"), name.rpartition("-")[0].replace("-", " ")))
    return sorted(out, key=lambda pair: pair[0].instance_id)


def _message(found: Found, graph: ObjectGraph, world: World, settings: MapperSettings) -> Instance:
    if found.parts is None:
        found.parts = _parts(found, world, settings)
    parts: Instance = found.parts
    return Instance(
        instance_id=found.instance_id,
        graph=graph,
        position_m=parts.position_m,
        extent_m=parts.extent_m,
        confidence=round(found.confidence, 6),
        hits=found.hits,
        misses=found.misses,
        evidence=parts.evidence,
        cells=parts.cells,
        runner_up=parts.runner_up,
        status="confirmed" if found.hits >= settings.min_hits else "tentative",
        covariance_m2=parts.covariance_m2,
        classes=parts.classes,
        replaces=list(found.replaced),
    )


def _parts(found: Found, world: World, settings: MapperSettings) -> Instance:
    """Return what depends on the instance alone; kept until it changes."""
    classes = found.votes.classes()[:MOST_CLASSES]
    return Instance(
        instance_id="",
        graph=ObjectGraph(found.name),
        position_m=_world(found.center_m, world),
        extent_m=_world(found.high_m - found.low_m, world),
        evidence=[shown for *_, shown in found.votes.evidence[: settings.max_evidence]],
        cells=_cells(found, settings),
        runner_up=found.votes.second(),
        covariance_m2=_covariance(found.covariance_m2, world),
        classes=[ClassProbability(name, round(share, 4)) for name, share in classes],
    )


def _world(values: Floats, world: World) -> list[float]:
    """Return map-axes values in world axes, rounded to 0.1 mm."""
    out = [0.0, 0.0, 0.0]
    for axis, value in zip(bev_axes(world), values.tolist(), strict=True):
        out[axis] = round(value, 4)
    return out


def _covariance(matrix_m2: Floats, world: World) -> list[float]:
    """Return xx, xy, xz, yy, yz, zz in world axes."""
    axes = list(bev_axes(world))
    turned = np.empty((3, 3))
    turned[np.ix_(axes, axes)] = matrix_m2
    return [round(float(turned[i, j]), 8) for i in range(3) for j in range(i, 3)]


def _cells(found: Found, settings: MapperSettings) -> list[list[int]]:
    """Return the ground cells (a, b, band) of the instance's own points."""
    inside = np.all((found.points_m >= found.low_m) & (found.points_m <= found.high_m), axis=1)
    edges = np.array([settings.cell_m, settings.cell_m, settings.band_m])
    cells = np.floor(found.points_m[inside] / edges).astype(int)
    return [list(cell) for cell in sorted(set(map(tuple, cells.tolist())))]
