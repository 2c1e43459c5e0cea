"""The viewer's core: shows every message, and draws the map when the question is asked."""

from __future__ import annotations

from collections import Counter
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from doro_schemas.camera import World
from doro_schemas.effects import Ask, Output, Unanswered
from doro_schemas.messages import (
    DepthFrame,
    GridDelta,
    GridRequest,
    GridSnapshot,
    Instances,
    InstancesRequest,
    Query,
)
from doro_schemas.messages.base import Message
from doro_viewer.map_picture import draw_map
from doro_viewer.settings import ViewerSettings


class Screen(Protocol):
    """Shows messages to a person."""

    def show(self, message: Message) -> None:
        """Show a message in whatever way suits its type."""


class Album(Protocol):
    """Keeps pictures."""

    def keep(self, picture: NDArray[np.uint8], dialogue: str) -> None:
        """Keep an RGB picture, uint8 (height, width, 3), of a dialogue of the episode ("1")."""


class Viewer:
    """Listens to a run.

    Args:
        settings: the picture's width and the world's axes until a pose tells.
        screen: where messages are shown.
        album: where pictures of the map go.
    """

    def __init__(self, settings: ViewerSettings, screen: Screen, album: Album) -> None:
        self._settings = settings
        self._screen = screen
        self._album = album
        self._world: World = settings.world
        self._next_seq = 0
        self._query: Query | None = None
        self._snapshot: GridSnapshot | None = None
        self._found: Instances | None = None
        self._counters: Counter[str] = Counter()

    @property
    def counters(self) -> dict[str, int]:
        """Messages shown by type, pictures drawn, gaps and missing replies."""
        return dict(self._counters)

    def show(self, message: Message) -> list[Output]:
        """Show a message that asks for nothing more."""
        self._counters[f"shown.{type(message).__name__}"] += 1
        self._screen.show(message)
        return []

    def depth(self, frame: DepthFrame) -> list[Output]:
        """Show a depth frame and remember which world its pose is in."""
        self._world = frame.pose.world
        return self.show(frame)

    def delta(self, delta: GridDelta) -> list[Output]:
        """Show a change of the map; ask for the whole where changes before it were missed."""
        self.show(delta)
        missed = delta.seq != self._next_seq and not delta.reset
        self._next_seq = delta.seq + 1
        if not missed:
            return []
        self._counters["grid_gaps"] += 1
        return [Ask(GridRequest(episode=delta.episode, stamp_ns=delta.stamp_ns))]

    def query(self, query: Query) -> list[Output]:
        """Show the robot's question and ask for the map and the instances it is about."""
        self.show(query)
        self._query, self._snapshot, self._found = query, None, None
        name, episode, stamp_ns = query.input_graph.name, query.episode, query.stamp_ns
        return [
            Ask(GridRequest(episode=episode, stamp_ns=stamp_ns)),
            Ask(InstancesRequest(name=name, episode=episode, stamp_ns=stamp_ns)),
        ]

    def grid(self, snapshot: GridSnapshot) -> list[Output]:
        """Take the whole map."""
        self._snapshot = snapshot
        return [*self.show(snapshot), *self._draw()]

    def instances(self, found: Instances) -> list[Output]:
        """Take the instances of the class in question."""
        self._found = found
        return [*self.show(found), *self._draw()]

    def unanswered(self, lost: Unanswered) -> list[Output]:
        """Say that there is no picture of this query."""
        self._counters["unanswered"] += 1
        return self.show(lost)

    def _draw(self) -> list[Output]:
        if self._query is None or self._snapshot is None or self._found is None:
            return []
        picture = draw_map(
            self._snapshot,
            self._found.instances,
            self._query,
            world=self._world,
            width_px=self._settings.png_width_px,
        )
        self._album.keep(picture, self._query.dialogue_id.rpartition("/")[2])
        self._counters["pictures"] += 1
        self._query = None
        return []
