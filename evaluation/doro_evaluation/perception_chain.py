"""Counting end to end with a detector that looks: rendered test rooms, no oracle.

Rooms of the evaluation set are rendered in colour; their views go through perception, nlu and
mapper in process. The oracle on the same views and the detector without fusion over views stand
beside it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import msgspec
import numpy as np

from doro_evaluation.chain import Language, Room, run_mapper
from doro_evaluation.counting import summary, tally
from doro_evaluation.figures import Figure
from doro_evaluation.outcomes import Outcome, found_things, true_things
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
    InstancesRequest,
    SimDetections,
)
from doro_sim_feeder.rooms.episode import RoomEpisode
from doro_sim_feeder.rooms.evaluation_set import SetRow, plan_set

SYSTEMS = ("oracle", "fused", "not fused", "single frames")


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


def winners(said: Sequence[FrameCaptions], threshold: float) -> list[FrameCaptions]:
    """Return the captions as a detector without distributions gives them: above a threshold."""
    return [
        msgspec.structs.replace(
            frame,
            detections=[_winner(box) for box in frame.detections if box.score >= threshold],
            shares=[],
        )
        for frame in said
    ]


def _winner(box: CaptionedBox) -> CaptionedBox:
    return msgspec.structs.replace(box, classes=[])


def outcomes(
    room: ColorRoom, detector: DetectionBackend, settings: PerceptionSettings, single: float
) -> Iterator[Outcome]:
    """Yield what each system finds in a room.

    Args:
        settings: of the detector with fusion, whose threshold may be low.
        single: threshold of the systems without fusion.
    """
    nlu = Nlu(msgspec.structs.replace(NluSettings(), cache_size=1_000_000))
    plain = MapperSettings()
    unfused = msgspec.structs.replace(plain, fuse_names=False)
    said = captions(room, Perception(settings, detector))
    tops = winners(said, single)
    runs = {
        "oracle": (Language().graphs(room.room), plain),
        "fused": (graphs(said, nlu), plain),
        "not fused": (graphs(said, nlu), unfused),
        "single frames": (graphs(tops, nlu), unfused),
    }
    truth = true_things(room.room)
    for system in SYSTEMS:
        found, use = runs[system]
        instances = run_mapper(room.room, found, use).instances(InstancesRequest())
        yield Outcome(
            recording=room.room.name,
            room=room.room.room,
            part="test",
            system=system,
            errors=settings.backend,
            frames=len(room.room.depths),
            truth=truth,
            found=found_things(instances.instances),
        )


def figures_of(found: Sequence[Outcome]) -> dict[str, Figure]:
    """Return the counting figures of each system, ``perception_counting/<system>/...``."""
    figures: dict[str, Figure] = {}
    for system in SYSTEMS:
        tallies = [tally(one) for one in found if one.system == system]
        if not tallies:
            continue
        for metric, value in summary(np.sum(tallies, axis=0)).items():
            figures[f"perception_counting/{system}/{metric}"] = round(float(value), 4)
    return figures
