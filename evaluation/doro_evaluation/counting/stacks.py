"""Stacked and contained things: is everything counted once, and the chain of holders right?

A *stack* is a chain of spawned things of which each stands on or in the one below. It is tried
if a perfect detector reports each of its things in ``MIN_VIEWS`` views or more. It is

- *counted* if, within ``AROUND_M`` of its axis and ``ABOVE_M`` of its height, as many instances
  of each of its classes are found as are there;
- *linked* if every thing but the lowest is paired with a found instance within ``PAIRED_M`` (pairs
  of least total distance; an attribute that contradicts counts as ``CONTRADICTS_M``, since things
  a centimetre apart are told apart by their looks)
  whose graph has as holder (its first is-on or is-at) the thing below: its class, no attribute
  that contradicts it, and the relation that the shared rule (:mod:`doro_schemas.spatial`) gives
  for the true boxes;
- *right* if both. Whether the lowest thing's holder is right too is told apart (*supported*).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path

import msgspec
import numpy as np
from rich.table import Table

from doro_evaluation.bootstrap import bounds
from doro_evaluation.chain import ERROR_MODELS, Language, Room, count_instances, load_room
from doro_evaluation.context import room_of
from doro_evaluation.counting.report import Figures
from doro_evaluation.outcomes import reported_views
from doro_evaluation.runs import Context, Recorded, in_processes
from doro_mapper.assignment import assign
from doro_schemas.detector_errors import read_pool
from doro_schemas.graph import ObjectGraph, Relation
from doro_schemas.messages import FrameGraphs, Instance
from doro_schemas.spatial import Box3, relation_between
from doro_schemas.vocabulary import canonical_name, canonical_value, split_camel_case
from doro_sim_feeder.rooms.truth import TrueInstance

MIN_VIEWS = 3
AROUND_M, ABOVE_M, PAIRED_M = 0.3, 0.15, 0.3
CONTRADICTS_M = 0.05
HOLDERS = ("is-on", "is-at")
MOST = 100
CAPTIONED, MEASURED = "captioned", "measured"


class StackResult(msgspec.Struct, frozen=True):
    """How one stack was understood.

    Attributes:
        things: classes from below to the top.
        relations: ``captioned``: captions say what holds what, as the oracle does;
            ``measured``: captions say nothing of relations, the map measures them.
        why: what is wrong, for people.
    """

    recording: str
    things: tuple[str, ...]
    errors: str
    relations: str
    counted: bool
    linked: bool
    supported: bool
    why: str = ""

    @property
    def right(self) -> bool:
        return self.counted and self.linked


def true_stacks(room: Room) -> list[list[TrueInstance]]:
    """Return the chains of spawned things, each from below to the top."""
    copies = {item.object_id: item for item in room.truth if item.copy}
    above = {item.receptacle: item for item in copies.values() if item.receptacle in copies}
    chains = []
    for item in copies.values():
        if item.receptacle not in copies and item.object_id in above:
            chain = [item]
            while chain[-1].object_id in above:
                chain.append(above[chain[-1].object_id])
            chains.append(chain)
    return chains


def judge_room(
    room: Room, instances: Sequence[Instance], errors: str, relations: str
) -> list[StackResult]:
    """Return the results of the stacks of a room that can be seen."""
    views = reported_views(room)
    return [
        judge(chain, room, instances, (errors, relations))
        for chain in true_stacks(room)
        if min(views[item.object_id] for item in chain) >= MIN_VIEWS
    ]


def judge(
    chain: Sequence[TrueInstance],
    room: Room,
    instances: Sequence[Instance],
    run: tuple[str, str],
) -> StackResult:
    """Return how a stack was understood; ``run``: error model and source of relations."""
    views = reported_views(room)
    why: list[str] = []
    partners: dict[str, Instance] = {}
    for kind in dict.fromkeys(item.object_type for item in chain):
        there = [
            item
            for item in room.truth
            if item.object_type == kind and views[item.object_id] and _near(item.center_m, chain)
        ]
        found = [one for one in instances if one.graph.name == _word(kind)]
        found = [one for one in found if _near(one.position_m, chain)]
        if len(found) != len(there):
            why.append(f"{len(found)} {_word(kind)} of {len(there)}")
        partners.update(_paired(there, found))
    links = [_link(upper, lower, partners) for lower, upper in pairwise(chain)]
    support = _support(chain[0], partners)
    return StackResult(
        recording=room.name,
        things=tuple(item.object_type for item in chain),
        errors=run[0],
        relations=run[1],
        counted=not why,
        linked=not any(links),
        supported=not support,
        why="; ".join([*why, *(link for link in links if link), *([support] if support else [])]),
    )


def without_relations(graphs: Sequence[FrameGraphs]) -> list[FrameGraphs]:
    """Return the graphs without what captions say of relations."""
    return [
        msgspec.structs.replace(
            frame,
            detections=[
                msgspec.structs.replace(
                    box, graph=ObjectGraph(box.graph.name, box.graph.attributes, []), caption=""
                )
                for box in frame.detections
            ],
        )
        for frame in graphs
    ]


def run_stacks(
    recordings: Sequence[Recorded], errors: Sequence[str], context: Context, workers: int
) -> Iterator[list[StackResult]]:
    """Yield the results of each recording, in order of recordings."""
    calls = [(item.path, tuple(errors), context) for item in recordings]
    yield from in_processes(_run, calls, workers)


def tried(results: Sequence[StackResult]) -> dict[tuple[str, str], list[StackResult]]:
    """Return by (errors, relations) the first hundred results, in order of recordings."""
    groups: dict[tuple[str, str], list[StackResult]] = {}
    for one in sorted(results, key=lambda result: result.recording):
        groups.setdefault((one.errors, one.relations), []).append(one)
    return {key: group[:MOST] for key, group in groups.items()}


def figures_of(results: Sequence[StackResult]) -> Figures:
    """Return ``stacks/ours/errors/relations/right`` and so on."""
    figures: Figures = {}
    for (errors, relations), group in tried(results).items():
        name = f"stacks/ours/{errors}/{relations}"
        figures[f"{name}/stacks"] = len(group)
        for metric in ("right", "counted", "linked", "supported"):
            flags = [(room_of(one.recording), bool(getattr(one, metric))) for one in group]
            figures[f"{name}/{metric}"] = sum(flag for _, flag in flags)
            figures |= bounds(f"{name}/{metric}", flags)
    return figures


def table_of(results: Sequence[StackResult]) -> Table:
    """Return the table of stacks that are right, counted, linked."""
    table = Table("errors", "relations", "stacks", "right", "counted", "linked", "supported")
    table.title = "Stacks of 2 to 4 things"
    for (errors, relations), group in tried(results).items():
        counts = [
            sum(getattr(one, metric) for one in group)
            for metric in ("right", "counted", "linked", "supported")
        ]
        table.add_row(errors, relations, str(len(group)), *(str(count) for count in counts))
    return table


def write_failures(path: Path, results: Sequence[StackResult]) -> None:
    """Write the stacks that are not right as JSON lines."""
    wrong = [one for group in tried(results).values() for one in group if not one.right]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(b"".join(msgspec.json.encode(one) + b"\n" for one in wrong))


def _run(call: tuple[str, tuple[str, ...], Context]) -> list[StackResult]:
    path, errors, context = call
    room = load_room(Path(path))
    pool = read_pool(Path(context.pool)) if context.pool else None
    language = Language(context.perception, context.nlu, pool)
    found: list[StackResult] = []
    for name in errors:
        graphs = language.graphs(room, ERROR_MODELS[name], context.seed)
        for relations, given in ((CAPTIONED, graphs), (MEASURED, without_relations(graphs))):
            instances = count_instances(room, given, context.mapper).instances
            found += judge_room(room, instances, name, relations)
    return found


def _near(center_m: Sequence[float], chain: Sequence[TrueInstance]) -> bool:
    axis = np.mean([item.center_m for item in chain], axis=0)
    low = min(item.center_m[1] - item.size_m[1] / 2 for item in chain)
    high = max(item.center_m[1] + item.size_m[1] / 2 for item in chain)
    aside = float(np.hypot(center_m[0] - axis[0], center_m[2] - axis[2]))
    return aside <= AROUND_M and low - ABOVE_M <= center_m[1] <= high + ABOVE_M


def _paired(there: Sequence[TrueInstance], found: Sequence[Instance]) -> dict[str, Instance]:
    if not there or not found:
        return {}
    a = np.array([item.center_m for item in there])
    b = np.array([one.position_m for one in found])
    distance = np.linalg.norm(a[:, None] - b[None], axis=2)
    looks = np.array([[_contradictions(item, one) for one in found] for item in there])
    return {
        there[row].object_id: found[column]
        for row, column in assign(distance + CONTRADICTS_M * looks)
        if distance[row, column] <= PAIRED_M
    }


def _contradictions(thing: TrueInstance, one: Instance) -> int:
    """Return how many attributes of a found instance are not those of a thing."""
    true = {kind: canonical_value(value) for kind, value in thing.attributes.items()}
    said = one.graph.attributes.items()
    return sum(true.get(kind, value) != value for kind, value in said)


def _link(upper: TrueInstance, lower: TrueInstance, partners: dict[str, Instance]) -> str:
    """Return what is wrong with a link, empty where nothing is."""
    wanted = relation_between(_box(upper), _box(lower))
    instance = partners.get(upper.object_id)
    if instance is None:
        return f"{_word(upper.object_type)} not found in its place"
    holder = _holder(instance)
    if holder is not None and holder.type == wanted and _fits(holder.target, lower):
        return ""
    looks = " ".join([*sorted(lower.attributes.values()), _word(lower.object_type)])
    return f"{_word(upper.object_type)} {_said(holder)} in place of {wanted} {looks}"


def _support(lowest: TrueInstance, partners: dict[str, Instance]) -> str:
    wanted = next((one for one in lowest.relations if one.type in HOLDERS), None)
    instance = partners.get(lowest.object_id)
    if wanted is None or instance is None:
        return "" if wanted is None else f"{_word(lowest.object_type)} not found in its place"
    holder, name = _holder(instance), _word(wanted.object_type)
    if holder is not None and (holder.type, holder.target.name) == (wanted.type, name):
        return ""
    return f"{_word(lowest.object_type)} {_said(holder)} in place of {wanted.type} {name}"


def _holder(instance: Instance) -> Relation | None:
    return next((one for one in instance.graph.relations if one.type in HOLDERS), None)


def _said(holder: Relation | None) -> str:
    if holder is None:
        return "nothing"
    return " ".join([holder.type, *sorted(holder.target.attributes.values()), holder.target.name])


def _fits(target: ObjectGraph, thing: TrueInstance) -> bool:
    """Tell whether a landmark's graph describes a thing: its class, nothing that contradicts."""
    true = {kind: canonical_value(value) for kind, value in thing.attributes.items()}
    return target.name == _word(thing.object_type) and all(
        true.get(kind, value) == value for kind, value in target.attributes.items()
    )


def _box(item: TrueInstance) -> Box3:
    (x, y, z), (width, height, depth) = item.center_m, item.size_m
    return Box3((x, z, y), (width, depth, height))


def _word(object_type: str) -> str:
    return canonical_name(split_camel_case(object_type))
