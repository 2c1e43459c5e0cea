"""End to end with a detector that looks: rendered test rooms, no oracle.

Rooms of the evaluation set are rendered in colour; their views go through perception, nlu and
mapper in process, things are counted, and instructions of the paper's three kinds are answered
from the map. The oracle on the same views and the detector without fusion over views stand
beside it.
"""

from __future__ import annotations

import pickle
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np

from doro_evaluation.chain import Language, Room, run_mapper
from doro_evaluation.counting.metrics import pair_up, relevant, summary, tally
from doro_evaluation.figures import Figure
from doro_evaluation.maps import Found
from doro_evaluation.outcomes import Outcome, found_things, true_things
from doro_evaluation.queries.pairs import Pair
from doro_evaluation.queries.scores import score_queries
from doro_evaluation.queries.systems import QueryOutcome, multi_view
from doro_mapper.settings import MapperSettings
from doro_nlu.core import Nlu
from doro_nlu.settings import NluSettings
from doro_perception.backend import DetectionBackend
from doro_perception.core import Perception
from doro_perception.settings import PerceptionSettings
from doro_schemas.messages import (
    CaptionedBox,
    ColorFrame,
    DepthFrame,
    FrameCaptions,
    FrameGraphs,
    Instances,
    InstancesRequest,
    SimDetections,
)
from doro_sim_feeder.rooms.episode import RoomEpisode
from doro_sim_feeder.rooms.evaluation_set import SetRow, plan_set
from doro_sim_feeder.rooms.expressions import KINDS, expressions

PAIRS_OF_A_KIND = 4
"""Instructions of each of the paper's three kinds that are asked in a room."""
MATCHED_M = 0.5
ENOUGH_VIEWS = 3
"""Counting is told besides of things that a perfect detector reports in so many views."""


@dataclass(frozen=True)
class Way:
    """How a map is made of what the detector says.

    Attributes:
        score: boxes below it are left out.
        mapper: settings of the map.
        distributions: boxes come with their class distributions; else with the likeliest name.
    """

    score: float
    mapper: MapperSettings
    distributions: bool = False


UNVOTED = MapperSettings(min_hits=1, min_hit_share=0.0, without=("voting", "observability"))
"""One view is enough, names the thing, and nothing that another view says or misses counts."""
WAYS = {
    "fused": Way(PerceptionSettings().captioner_threshold, MapperSettings(), distributions=True),
    "votes": Way(0.7, MapperSettings(min_hits=2, min_hit_share=0.4)),
    "single frames": Way(0.93, UNVOTED),
}
"""``fused``: as shipped. ``votes``: the likeliest name of each view, and the map lets views vote.
``single frames``: the likeliest name of one view. Each with its own best thresholds on the rooms of
``tuning_rooms``, which are no test rooms."""
SYSTEMS = ("oracle", *WAYS)


@dataclass(frozen=True)
class Chained:
    """What a system made of a room: its counts and its answers."""

    outcome: Outcome
    answers: tuple[QueryOutcome, ...]


@dataclass(frozen=True)
class ColorRoom:
    """A test room with its colour frames."""

    room: Room
    colors: tuple[ColorFrame, ...]


def test_rows(count: int) -> list[SetRow]:
    """Return rows of the test parts, evenly spread; all for 0."""
    rows = [row for row in plan_set() if row.part in ("default", "copies")]
    if not count or count >= len(rows):
        return rows
    return [rows[k * len(rows) // count] for k in range(count)]


test_rows.__test__ = False  # type: ignore[attr-defined]


def render(row: SetRow, views: int | None, size_px: int = 300) -> ColorRoom:
    """Return a room of the set in colour (OpenGL), with at most so many of its views."""
    episode = RoomEpisode(
        row.room,
        seed=row.seed,
        copies=row.spec(),
        views=views,
        size_px=size_px,
        renderer="gl",
        allow_missing=True,
        name=row.name,
    )
    colors: list[ColorFrame] = []
    depths: list[DepthFrame] = []
    detections: list[SimDetections] = []
    for message in episode.messages():
        if isinstance(message, ColorFrame):
            colors.append(message)
        elif isinstance(message, DepthFrame):
            depths.append(message)
        elif isinstance(message, SimDetections):
            detections.append(message)
    truth = tuple(episode.truth())
    room = Room(row.name, row.room, row.name, tuple(depths), tuple(detections), truth)
    return ColorRoom(room, tuple(colors))


def kept_or_rendered(row: SetRow, views: int | None, folder: Path | None) -> ColorRoom:
    """Return :func:`render`'s room, from the folder if it was rendered and kept there before."""
    if folder is None:
        return render(row, views)
    path = folder / f"{row.name}-{views or 'all'}.pkl"
    if path.exists():
        kept: ColorRoom = pickle.loads(path.read_bytes())
        return kept
    folder.mkdir(parents=True, exist_ok=True)
    room = render(row, views)
    part = path.with_suffix(".part")
    part.write_bytes(pickle.dumps(room))
    part.rename(path)
    return room


def captions(room: ColorRoom, core: Perception) -> list[FrameCaptions]:
    """Return what the detector says of each view."""
    found: list[FrameCaptions] = []
    for frame in room.colors:
        said = core.color_frame(frame)
        found += [message for message in said if isinstance(message, FrameCaptions)]
    return found


def graphs(said: Sequence[FrameCaptions], nlu: Nlu) -> list[FrameGraphs]:
    """Return the object graphs of captions."""
    found: list[FrameGraphs] = []
    for frame in said:
        found += [m for m in nlu.captions(frame) if isinstance(m, FrameGraphs)]
    return found


def taken(said: Sequence[FrameCaptions], way: Way) -> list[FrameCaptions]:
    """Return what a way takes of the captions."""
    return [
        msgspec.structs.replace(
            frame,
            detections=[_box(box, way) for box in frame.detections if box.score >= way.score],
            shares=[],
        )
        for frame in said
    ]


def _box(box: CaptionedBox, way: Way) -> CaptionedBox:
    return box if way.distributions else msgspec.structs.replace(box, classes=[])


def outcomes(
    room: ColorRoom, detector: DetectionBackend, settings: PerceptionSettings
) -> Iterator[Chained]:
    """Yield what each system finds and answers in a room; the detector looks once for all.

    Args:
        settings: of the detector; its threshold is the least of :data:`WAYS`.
    """
    nlu = Nlu(msgspec.structs.replace(NluSettings(), cache_size=1_000_000))
    said = captions(room, Perception(settings, detector))
    asked = pairs_of(room.room)
    for system in SYSTEMS:
        if system == "oracle":
            found, use = Language().graphs(room.room), MapperSettings()
        else:
            found, use = graphs(taken(said, WAYS[system]), nlu), WAYS[system].mapper
        reply = run_mapper(room.room, found, use).instances(InstancesRequest())
        yield Chained(
            _counted(room.room, reply, system, settings.backend),
            tuple(_answered(room.room, asked, reply, nlu, system)),
        )


def lowest_score() -> float:
    """Return the threshold of the detector that looks for all ways."""
    return min(way.score for way in WAYS.values())


def _counted(room: Room, reply: Instances, system: str, backend: str) -> Outcome:
    return Outcome(
        recording=room.name,
        room=room.room,
        part="test",
        system=system,
        errors=backend,
        frames=len(room.depths),
        truth=true_things(room),
        found=found_things(reply.instances),
    )


def pairs_of(room: Room, most: int = PAIRS_OF_A_KIND) -> list[Pair]:
    """Return instructions about a room, so many of each kind, drawn by their ids."""
    made = expressions(room.name, room.truth)
    chosen = []
    for kind in KINDS:
        of_kind = [one for one in made if one.kind == kind]
        numbers = np.random.default_rng(len(made)).permutation(len(of_kind))[:most]
        chosen += [of_kind[k] for k in sorted(numbers.tolist())]
    return [
        Pair(one.id, room.name, one.kind, one.variant, one.text, one.task, one.graph)
        for one in chosen
    ]


def _answered(
    room: Room, asked: Sequence[Pair], reply: Instances, nlu: Nlu, system: str
) -> Iterator[QueryOutcome]:
    found = Found(tuple(reply.instances), reply.unseen_share)
    for one in multi_view(room, asked, found, nlu):
        yield msgspec.structs.replace(one, system=system)


def figures_of(found: Sequence[Chained]) -> dict[str, Figure]:
    """Return counting and answering figures of each system: ``perception_counting/<system>/...``
    and ``perception_answers/<system>/...``; of things seen often as ``.../3_views/...``.
    """
    figures: dict[str, Figure] = {}
    for system in SYSTEMS:
        own = [one for one in found if one.outcome.system == system]
        if not own:
            continue
        prefix = f"perception_counting/{system}"
        for part, least in ((prefix, 1), (f"{prefix}/{ENOUGH_VIEWS}_views", ENOUGH_VIEWS)):
            total = np.sum([tally(one.outcome, least) for one in own], axis=0)
            for metric, value in summary(total).items():
                figures[f"{part}/{metric}"] = round(float(value), 4)
        for kind, (true, told, matched) in by_class([one.outcome for one in own]).items():
            figures[f"{prefix}/class/{kind}/true"] = true
            figures[f"{prefix}/class/{kind}/found"] = told
            figures[f"{prefix}/class/{kind}/matched"] = matched
        scores = score_queries([answer for one in own for answer in one.answers])
        answers = f"perception_answers/{system}"
        figures[f"{answers}/pairs"] = scores.pairs
        figures[f"{answers}/qa"] = round(scores.qa.value, 4)
        figures[f"{answers}/aa"] = round(scores.aa.value, 4)
        figures[f"{answers}/bleu"] = round(scores.bleu.value, 4)
    return figures


def by_class(found: Sequence[Outcome]) -> dict[str, tuple[int, int, int]]:
    """Return of each class how many are true, found, and pairs of both within half a metre."""
    counts: dict[str, list[int]] = {}
    for outcome in found:
        true, told = relevant(outcome)
        for thing in true:
            counts.setdefault(thing.object_type, [0, 0, 0])[0] += 1
        for thing in told:
            counts.setdefault(thing.object_type, [0, 0, 0])[1] += 1
        for index, _, _ in pair_up(true, told, MATCHED_M):
            counts[true[index].object_type][2] += 1
    return {kind: (row[0], row[1], row[2]) for kind, row in sorted(counts.items())}
