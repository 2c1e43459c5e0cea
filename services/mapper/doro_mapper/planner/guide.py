"""The mapper with its planner: the core's answers, and goals among them.

The core knows nothing of goals. The guide sees what goes in and what comes out, gives the
planner each merged frame, and asks it for the next view: after every frame when the robot said
in ``started`` that it follows goals, otherwise now and then, for whoever watches.
"""

from __future__ import annotations

import msgspec
import numpy as np

from doro_mapper.core import Mapper
from doro_mapper.finder import TrackSummary
from doro_mapper.planner.goals import Planner
from doro_mapper.planner.settings import PlannerSettings
from doro_mapper.planner.things import MOST_FROM, Thing
from doro_mapper.planner.views import Look, look_of
from doro_mapper.views import Floats
from doro_schemas.effects import Output
from doro_schemas.messages import (
    DepthFrame,
    Exploration,
    ExplorationGoal,
    FrameGraphs,
    GridDelta,
    InstructionGraph,
)

SPREAD_FLOOR_M = 0.03
"""What a single measurement may be off by at least."""
SPREAD_PER_M = 0.05
MOST_PLACES = 4096


class Guide:
    """A :class:`Mapper` whose outputs carry goals as well."""

    def __init__(self, core: Mapper, settings: PlannerSettings, max_pending: int = 64) -> None:
        self._core = core
        self._settings = settings
        self._planner = Planner(settings)
        self._looks: dict[tuple[str, str, int], Look] = {}
        self._max_pending = max_pending
        self._last: GridDelta | None = None
        self._from_m: dict[int, Floats] = {}
        self._things: dict[tuple[int, int], tuple[int, Thing]] = {}

    def depth_frame(self, message: DepthFrame) -> list[Output]:
        """As the core's; a goal may follow the delta."""
        self._looks[message.episode, message.camera, message.frame] = look_of(message)
        while len(self._looks) > self._max_pending:
            del self._looks[next(iter(self._looks))]
        return self._guided(self._core.depth_frame(message))

    def frame_graphs(self, message: FrameGraphs) -> list[Output]:
        """As the core's; a goal may follow the delta."""
        return self._guided(self._core.frame_graphs(message))

    def exploration(self, message: Exploration) -> list[Output]:
        """As the core's; ``started`` says which views are reachable and whether goals count."""
        outputs = self._guided(self._core.exploration(message))
        if message.state == "started":
            self._planner.start(message)
        return outputs

    def instruction(self, message: InstructionGraph) -> list[Output]:
        """Prefer what the person asks for."""
        self._planner.ask(message.graph)
        return []

    def goal(self) -> ExplorationGoal:
        """Return the next view as of now; "nothing seen yet" before the first frame."""
        goal = self._planner.goal(self._current)
        if self._last is None:
            return goal
        return msgspec.structs.replace(
            goal,
            stamp_ns=self._last.stamp_ns,
            episode=self._last.episode,
            camera=self._last.camera,
            frame=self._last.frame,
            frames_merged=self._last.frames_merged,
            unseen_share=self._core.unseen_share(),
        )

    def _current(self) -> list[Thing]:
        """Return the tracks as things; made again only where a sighting was added."""
        known, self._things = self._things, {}
        for track in self._core.tracks():
            count, thing = known.get(track.key, (0, None))
            if thing is None or count != track.hits:
                thing = thing_of(track, self._from_m)
            self._things[track.key] = track.hits, thing
        return [thing for _, thing in self._things.values()]

    def _guided(self, outputs: list[Output]) -> list[Output]:
        out: list[Output] = []
        for output in outputs:
            out.append(output)
            if not isinstance(output, GridDelta):
                continue
            self._last = output
            if output.reset:
                self._planner.start()
                self._from_m.clear()
                continue
            frame = (output.camera, output.frame)
            look = self._looks.pop((output.episode, *frame), None)
            look = look or self._looks.pop(("", *frame), None)
            if look is not None:
                self._planner.frame(look)
                serial = output.frames_merged - 1
                self._from_m[serial] = look.camera.position_m
                self._from_m.pop(serial - MOST_PLACES, None)
            every = 1 if self._planner.wanted else self._settings.every
            if every and output.frames_merged % every == 0:
                out.append(self.goal())
        return out


def thing_of(track: TrackSummary, from_m: dict[int, Floats]) -> Thing:
    """Return a track as the planner takes it.

    Args:
        from_m: camera positions of merged frames by serial, map axes.
    """
    latest = [from_m[serial] for serial in track.serials[-MOST_FROM:] if serial in from_m]
    places = np.array(latest).reshape(-1, 3)
    return Thing(
        name=track.name,
        attributes=track.attributes,
        related=track.related,
        center_m=track.center_m,
        size_m=track.high_m - track.low_m,
        hits=track.hits,
        spread_m=_spread_m(track, places),
        seen_in=frozenset(track.serials),
        from_m=places,
    )


def _spread_m(track: TrackSummary, from_m: Floats) -> float:
    """Return the standard error of the centre: what views disagree by, or their range allows."""
    ranges = np.linalg.norm(from_m - track.center_m, axis=1)
    single = SPREAD_FLOOR_M + SPREAD_PER_M * float(ranges.mean() if len(ranges) else 0.0)
    return max(single / float(np.sqrt(min(track.hits, MOST_FROM))), track.spread_m)
