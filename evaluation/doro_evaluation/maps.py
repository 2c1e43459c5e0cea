"""A recording with its truth and what the mapper makes of it; what is costly is done once.

The whole map under the errors of the end-to-end tables is kept on disk, without its cells, so
that counting, queries, ablations and the report share the mapper's runs.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import cached_property
from pathlib import Path
from typing import TypeVar

import msgspec

from doro_evaluation.chain import ERROR_MODELS, Language, Room, count_instances, load_room
from doro_evaluation.context import SYSTEMS, Context, Recorded, with_finder
from doro_evaluation.counting.conceptgraphs import count_like_conceptgraphs
from doro_evaluation.outcomes import Outcome, Thing, found_things, true_things
from doro_schemas.messages import FrameGraphs, Instance, Instances

Kept = TypeVar("Kept")
CONCEPTGRAPHS = "conceptgraphs_like"
KEPT_ERRORS = ("cs+sd+fn",)
"""Error models whose maps are kept whole: those of the paper's Tables III and IV."""


class Found(msgspec.Struct, frozen=True):
    """What of the mapper's answer is kept.

    Attributes:
        instances: of all classes, without cells; unseen_share: as in the answer.
    """

    instances: tuple[Instance, ...]
    unseen_share: float


class MappedRoom:
    """A recording, loaded and mapped when asked for.

    Args:
        speak: gives perception and nlu; not called where all is kept.
    """

    def __init__(
        self, recording: Recorded, context: Context, speak: Callable[[], Language]
    ) -> None:
        self.recording, self.context = recording, context
        self._speak = speak
        self._graphs: dict[str, list[FrameGraphs]] = {}

    @cached_property
    def room(self) -> Room:
        """The recording in memory."""
        return load_room(Path(self.recording.path))

    @cached_property
    def truth(self) -> tuple[Thing, ...]:
        """The true instances of the evaluated classes."""
        return true_things(self.room, self.context.perception)

    def graphs(self, errors: str) -> list[FrameGraphs]:
        """Return the object graphs of all views under an error model."""
        if errors not in self._graphs:
            models, seed = ERROR_MODELS[errors], self.context.seed
            self._graphs[errors] = self._speak().graphs(self.room, models, seed)
        return self._graphs[errors]

    def found(self, finder: str, errors: str) -> Found:
        """Return the map's instances; from disk where an earlier run has kept them."""
        digest = self.context.digest(self.recording, finder, errors, "map")
        kept = Path(self.context.cache) / f"{self.recording.name}-map-{digest}.json"
        if errors in KEPT_ERRORS and not self.context.fresh:
            known = read_kept(kept, Found)
            if known is not None:
                return known
        settings = with_finder(self.context.mapper, finder)
        found = _trimmed(count_instances(self.room, self.graphs(errors), settings))
        if errors in KEPT_ERRORS:
            write_kept(kept, found)
        return found

    def outcome(self, finder: str, errors: str) -> Outcome:
        """Return what counting looks at; from disk where an earlier run has kept it."""
        digest = self.context.digest(self.recording, finder, errors)
        kept = Path(self.context.cache) / f"{self.recording.name}-{digest}.json"
        known = None if self.context.fresh else read_kept(kept, Outcome)
        if known is not None:
            return known
        outcome = Outcome(
            recording=self.recording.name,
            room=self.room.room,
            part=self.recording.part,
            system=SYSTEMS.get(finder, finder),
            errors=errors,
            frames=len(self.room.depths),
            truth=self.truth,
            found=self._things(finder, errors),
        )
        write_kept(kept, outcome)
        return outcome

    def _things(self, finder: str, errors: str) -> tuple[Thing, ...]:
        if finder == CONCEPTGRAPHS:
            return count_like_conceptgraphs(self.room.depths, self.graphs(errors))
        return found_things(self.found(finder, errors).instances)


def read_kept(path: Path, kind: type[Kept]) -> Kept | None:
    """Return what was kept; None where it is not there or not whole."""
    try:
        return msgspec.json.decode(path.read_bytes(), type=kind)
    except (OSError, msgspec.DecodeError):
        return None


def write_kept(path: Path, value: object) -> None:
    """Keep a value as JSON; nobody sees half of it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_suffix(f".{os.getpid()}.part")
    part.write_bytes(msgspec.json.encode(value))
    part.replace(path)


def _trimmed(answer: Instances) -> Found:
    instances = tuple(
        msgspec.structs.replace(one, cells=[], classes=[]) for one in answer.instances
    )
    return Found(instances, answer.unseen_share)
