"""What the mapper's benchmark looks at: scenes, and any number of distinct frames of them.

========  ============================================================================
room      A living room, rendered: the first in iTHOR, nothing was chosen. An episode of the
          paper is one room.
home      The first kitchen, living room and bedroom, 20 m apart in one map.
fronts    The packaged sample: a kitchen with rows of cabinet doors, drawers and burners that
          look alike. The worst case.
========  ============================================================================

Of the rendered rooms only views are taken that show as many things as a frame is to have
detections: all of them are true. Views of ``fronts`` that show less are filled up with
detections of other views, which are false there.

Every frame differs from every other: each round has other detector errors (shift and size;
missing by the choice of detections), the camera stands up to 2 cm and half a degree elsewhere,
depth is off by up to half a percent.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import msgspec
import numpy as np

from doro_evaluation.chain import ERROR_MODELS, Language, Room, load_room
from doro_schemas.camera import Intrinsics, Pose
from doro_schemas.errors import Refused
from doro_schemas.messages import DepthFrame, FrameGraphs, GraphBox, SimDetections

KITCHEN, LIVING_ROOM, BEDROOM = "FloorPlan1", "FloorPlan201", "FloorPlan301"
HOME_SEED, APART_M = 7, 20.0
MOVED_M, TURNED_DEG, DEPTH_SHARE = 0.02, 0.5, 0.005
EPISODE = "bench"
Pair = tuple[DepthFrame, FrameGraphs]


@dataclass(frozen=True)
class Scene:
    """Rooms of one map, and how frames are made of them.

    Attributes:
        fill: views that show too little are filled up with false detections; else left out.
        errors: of the detector, see :data:`ERROR_MODELS`.
    """

    rooms: tuple[Room, ...]
    fill: bool
    errors: str


SCENES = ("room", "home", "fronts")


def scene_of(name: str, recording: Path) -> Scene:
    """Return a scene; rendering takes some seconds.

    Args:
        name: one of :data:`SCENES`.
        recording: of ``fronts``.

    Raises:
        Refused: the packages for rendering are missing.
    """
    if name == "fronts":
        return Scene((load_room(recording),), True, "cs+sd+fn")
    names = (LIVING_ROOM,) if name == "room" else (KITCHEN, LIVING_ROOM, BEDROOM)
    rooms = tuple(_apart(_rendered(room), number) for number, room in enumerate(names))
    return Scene(rooms, False, "cs+sd")


@functools.cache
def _rendered(name: str) -> Room:
    try:
        from doro_sim_feeder.rooms.episode import RoomEpisode  # noqa: PLC0415 - an extra
    except ImportError as error:
        raise Refused(
            f"the benchmark's rooms are rendered, and '{error.name}' is not there for it:"
            " install doro-sim-feeder[render], or take --scene fronts"
        ) from error
    episode = RoomEpisode(name, seed=HOME_SEED, color=False)
    messages = list(episode.messages())
    return Room(
        name=name,
        room=name,
        episode=EPISODE,
        depths=tuple(one for one in messages if isinstance(one, DepthFrame)),
        detections=tuple(one for one in messages if isinstance(one, SimDetections)),
        truth=(),
    )


def _apart(room: Room, number: int) -> Room:
    """Return a room moved to its own place in the map."""
    depths = []
    for depth in room.depths:
        x, y, z = depth.pose.position_m
        pose = msgspec.structs.replace(depth.pose, position_m=[x + APART_M * number, y, z])
        depths.append(msgspec.structs.replace(depth, pose=pose))
    return replace(room, depths=tuple(depths))


class Endless:
    """Makes any number of distinct frames out of a scene, room after room, round after round.

    Args:
        detections: as many in every frame; views that show more lose some by a seeded choice.
        size_px: (height, width) to which the images are scaled and cut; None: as recorded.

    Raises:
        Refused: no view shows so many things.
    """

    def __init__(
        self, scene: Scene, detections: int, size_px: tuple[int, int] | None = None
    ) -> None:
        self._scene, self._detections, self._size_px = scene, detections, size_px
        self._views = [
            (k, view)
            for k, room in enumerate(scene.rooms)
            for view, shown in enumerate(room.detections)
            if scene.fill or len(shown.detections) >= detections
        ]
        if not self._views:
            raise Refused(f"no view of the scene shows {detections} things: take fewer")
        self._language = Language()
        self._round, self._graphs = -1, list[list[FrameGraphs]]()

    @property
    def views(self) -> int:
        """Number of different views in a round."""
        return len(self._views)

    def make(self, number: int) -> Pair:
        """Return frame ``number``; the same number gives the same frame."""
        turn, place = divmod(number, len(self._views))
        if turn != self._round:
            self._round = turn
            self._graphs = [self._of(room) for room in self._scene.rooms]
        rng = np.random.default_rng([number, self._detections])
        room, view = self._views[place]
        graphs = self._graphs[room][view]
        boxes = self._chosen(graphs, self._graphs[room], rng)
        depth = _moved(self._scene.rooms[room].depths[view], number, rng)
        graphs = msgspec.structs.replace(graphs, episode=EPISODE, frame=number, detections=boxes)
        return (depth, graphs) if self._size_px is None else scaled(depth, graphs, self._size_px)

    def _of(self, room: Room) -> list[FrameGraphs]:
        return self._language.graphs(room, ERROR_MODELS[self._scene.errors], seed=self._round)

    def _chosen(
        self, graphs: FrameGraphs, others: Sequence[FrameGraphs], rng: np.random.Generator
    ) -> list[GraphBox]:
        own = list(graphs.detections)
        while self._scene.fill and len(own) < self._detections:
            other = others[int(rng.integers(len(others)))].detections
            own += [other[int(rng.integers(len(other)))]] if other else []
        kept = sorted(rng.permutation(len(own))[: self._detections])
        return [own[int(k)] for k in kept]


def _moved(depth: DepthFrame, number: int, rng: np.random.Generator) -> DepthFrame:
    """Return the frame with a slightly other pose and depth."""
    yaw = np.radians(rng.uniform(-TURNED_DEG, TURNED_DEG))
    turn = np.array([[np.cos(yaw), 0, np.sin(yaw)], [0, 1, 0], [-np.sin(yaw), 0, np.cos(yaw)]])
    rotation = turn @ depth.pose.matrix()
    x, y, z = depth.pose.position_m
    dx, dz = rng.uniform(-MOVED_M, MOVED_M, 2)
    pose = Pose(
        position_m=[x + float(dx), y, z + float(dz)],
        rotation=[float(value) for value in rotation.ravel()],
        world=depth.pose.world,
    )
    share = 1 + float(rng.uniform(-DEPTH_SHARE, DEPTH_SHARE))
    data = (depth.data * share).astype(depth.data.dtype)
    return msgspec.structs.replace(depth, episode=EPISODE, frame=number, pose=pose, data=data)


def scaled(depth: DepthFrame, graphs: FrameGraphs, size_px: tuple[int, int]) -> Pair:
    """Return a frame scaled to the width and cut to the height of ``size_px``."""
    height, width = size_px
    factor = width / depth.width_px
    top = (depth.height_px * factor - height) / 2
    rows = np.minimum(((np.arange(height) + top) / factor).astype(int), depth.height_px - 1)
    columns = (np.arange(width) / factor).astype(int)
    lens = depth.intrinsics
    boxes = []
    for box in graphs.detections:
        left, upper, right, lower = (value * factor for value in box.box_px)
        upper, lower = max(0.0, upper - top), min(float(height), lower - top)
        if lower - upper < 1:  # outside of what is left of the image: at its border instead
            upper, lower = 0.0, max(8.0, lower - upper)
        boxes.append(msgspec.structs.replace(box, box_px=[left, upper, right, lower]))
    image = msgspec.structs.replace(
        depth,
        height_px=height,
        width_px=width,
        intrinsics=Intrinsics(lens.fx * factor, lens.fy * factor, lens.cx * factor,
                              lens.cy * factor - top),
        data=np.ascontiguousarray(depth.data[np.ix_(rows, columns)]),
    )  # fmt: skip
    return image, msgspec.structs.replace(
        graphs, height_px=height, width_px=width, detections=boxes
    )
