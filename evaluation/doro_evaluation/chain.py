"""The chain in process: a recording through error models, captions, parser and mapper.

No bus is between the cores; a recording is read once and kept, as decoding its depth costs more
than all the rest of reading it. Perception and nlu are the services' own cores.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import msgspec

from doro_mapper.core import Mapper
from doro_mapper.settings import MapperSettings
from doro_nlu.core import Nlu
from doro_nlu.settings import NluSettings
from doro_perception.core import Perception
from doro_perception.settings import PerceptionSettings
from doro_schemas.detector_errors import ErrorModels as Errors
from doro_schemas.detector_errors import ErrorName, FalsePositivePool, disturb, pool_of
from doro_schemas.errors import Refused
from doro_schemas.messages import (
    DepthFrame,
    Exploration,
    FrameCaptions,
    FrameGraphs,
    Instances,
    InstancesRequest,
    SimDetections,
)
from doro_sim_feeder.recording import TRUTH, Recording
from doro_sim_feeder.rooms.classes import BY_TYPE
from doro_sim_feeder.rooms.truth import TrueInstance

ERROR_MODELS: dict[str, tuple[ErrorName, ...]] = {
    "gt": (),
    "cs": ("cs",),
    "cs+sd": ("cs", "sd"),
    "cs+sd+fn": ("cs", "sd", "fn"),
    "fp": ("fp",),
    "all": ("cs", "sd", "fn", "fp"),
}
"""The rows of the paper's Table II, and all errors at once."""
POOL_VIEWS = 40
"""Views of a room that false positives are drawn from, evenly spread."""


class _TruthFile(msgspec.Struct):
    """What is read of a ``truth.json``, inside of a recording or beside it."""

    instances: tuple[TrueInstance, ...]


@dataclass(frozen=True)
class Room:
    """A recorded exploration with its truth, in memory; depth takes 180 kB a frame.

    Attributes:
        name: the recording's name; room: iTHOR's room.
        episode: episode of the messages.
        depths, detections: one per view, in order of recording.
        truth: all instances, ``views`` counts the frames that show 30 pixels or more.
    """

    name: str
    room: str
    episode: str
    depths: tuple[DepthFrame, ...]
    detections: tuple[SimDetections, ...]
    truth: tuple[TrueInstance, ...]

    def start(self) -> Exploration:
        """Return the word that empties a map for this room."""
        return Exploration(episode=self.episode, state="started", frames=len(self.depths))


def load_room(path: Path) -> Room:
    """Return a recording with depth, the simulator's detections and the truth.

    Raises:
        Refused: one of these is missing, or the file is damaged.
    """
    recording = Recording(path)
    depths: dict[tuple[str, int], DepthFrame] = {}
    found: dict[tuple[str, int], SimDetections] = {}
    for sample in recording.samples():
        message = sample.message()
        if isinstance(message, DepthFrame):
            depths[message.camera, message.frame] = message
        elif isinstance(message, SimDetections):
            found[message.camera, message.frame] = message
    if not depths or depths.keys() != found.keys():
        raise Refused(
            f"{path} has {len(depths)} depth frames and {len(found)} frames of simulator's"
            " detections: make it with 'doro rooms set' or 'doro rooms render'"
        )
    first = next(iter(depths.values()))
    return Room(
        name=path.stem,
        room=recording.metadata.get("room", ""),
        episode=first.episode,
        depths=tuple(depths.values()),
        detections=tuple(found[key] for key in depths),
        truth=truth_of(recording),
    )


def load_detections(path: Path) -> list[SimDetections]:
    """Return the simulator's detections of a recording, without decoding its depth."""
    found = []
    for sample in Recording(path).samples():
        if SimDetections in sample.topic.messages:
            message = sample.message()
            assert isinstance(message, SimDetections)
            found.append(message)
    return found


def false_positives(paths: Sequence[Path]) -> FalsePositivePool:
    """Return the pool of recordings: detections of the 21 classes, of up to 40 views a room.

    The paper pastes boxes and captions of its 21 classes; pasting others (cabinets, drawers)
    would be too easy, as nobody counts them.
    """
    frames: list[SimDetections] = []
    for path in sorted(paths):
        views = [
            msgspec.structs.replace(frame, detections=counted)
            for frame in load_detections(path)
            if (counted := [item for item in frame.detections if item.object_type in BY_TYPE])
        ]
        step = max(1, len(views) // POOL_VIEWS)
        frames += views[::step][:POOL_VIEWS]
    return pool_of(frames)


class Language:
    """Detections to graphs, as perception's oracle and nlu do it; parses are kept.

    Args:
        perception, nlu: settings of the two services.
        pool: what false positives are pasted from; needed by ``fp`` and ``all``.
    """

    def __init__(
        self,
        perception: PerceptionSettings | None = None,
        nlu: NluSettings | None = None,
        pool: FalsePositivePool | None = None,
    ) -> None:
        kept = msgspec.structs.replace(nlu or NluSettings(), cache_size=1_000_000)
        self._perception = Perception(perception or PerceptionSettings())
        self._nlu = Nlu(kept)
        self._pool = pool

    def captions(
        self, room: Room, errors: Sequence[ErrorName] = (), seed: int = 0
    ) -> list[FrameCaptions]:
        """Return the captions of every view under the error models.

        Raises:
            Refused: false positives are asked for and there is no pool of another room.
        """
        models = Errors(errors=tuple(errors), seed=seed)
        found: list[FrameCaptions] = []
        for frame in room.detections:
            seen = disturb(frame, models, self._pool) if errors else frame
            said = self._perception.sim_detections(seen)
            found += [message for message in said if isinstance(message, FrameCaptions)]
        return found

    def graphs(
        self, room: Room, errors: Sequence[ErrorName] = (), seed: int = 0
    ) -> list[FrameGraphs]:
        """Return the object graphs of every view under the error models, in order."""
        found: list[FrameGraphs] = []
        for frame in self.captions(room, errors, seed):
            parsed = self._nlu.captions(frame)
            found += [message for message in parsed if isinstance(message, FrameGraphs)]
        return found


def run_mapper(
    room: Room,
    graphs: Sequence[FrameGraphs],
    settings: MapperSettings | None = None,
    order: Sequence[int] | None = None,
) -> Mapper:
    """Return a mapper that has merged the views.

    Args:
        order: which views, in which order; None: all as recorded.
    """
    mapper = Mapper(settings or MapperSettings())
    mapper.exploration(room.start())
    for view in range(len(room.depths)) if order is None else order:
        mapper.depth_frame(room.depths[view])
        mapper.frame_graphs(graphs[view])
    return mapper


def count_instances(
    room: Room,
    graphs: Sequence[FrameGraphs],
    settings: MapperSettings | None = None,
    order: Sequence[int] | None = None,
) -> Instances:
    """Return the mapper's unique instances of all classes after the views."""
    return run_mapper(room, graphs, settings, order).instances(InstancesRequest())


def truth_of(recording: Recording) -> tuple[TrueInstance, ...]:
    """Return the truth inside of a recording or, for older ones, beside it.

    Raises:
        Refused: there is none, or it cannot be read.
    """
    inside = recording.attachment(TRUTH)
    beside = recording.path.with_suffix(".truth.json")
    try:
        raw = inside if inside is not None else beside.read_bytes()
        return msgspec.json.decode(raw, type=_TruthFile).instances
    except OSError as error:
        raise Refused(
            f"recording {recording.path} has no truth inside and no {beside.name} beside it:"
            " make it with 'doro rooms set'"
        ) from error
    except msgspec.DecodeError as error:
        raise Refused(f"the truth of {recording.path} cannot be read: {error}") from error
