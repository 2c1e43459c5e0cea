"""A rendered exploration as messages of the wire."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator

import cv2
import msgspec
import numpy as np
from numpy.typing import NDArray

from doro_schemas.camera import Intrinsics
from doro_schemas.errors import Refused
from doro_schemas.messages import ColorFrame, DepthFrame, Exploration, SimDetections
from doro_schemas.messages.base import Message
from doro_sim_feeder.rooms.camera import Picture
from doro_sim_feeder.rooms.copies import CopySpec, Unplaced
from doro_sim_feeder.rooms.exploration import View, plan_views
from doro_sim_feeder.rooms.footprints import CELL_M
from doro_sim_feeder.rooms.lighting import Lighting
from doro_sim_feeder.rooms.placement import Spawned, place_copies, spawn_copies
from doro_sim_feeder.rooms.renderers import RendererName, make_renderer
from doro_sim_feeder.rooms.scene import Scene, build_scene
from doro_sim_feeder.rooms.truth import TrueInstance, detections, true_instances

EPOCH_NS = 1_700_000_000_000_000_000
FRAME_NS = 100_000_000
JPEG_QUALITY = 88


class RoomEpisode:
    """One room, its copies and the views of its exploration.

    Attributes:
        name: the episode, ``<room>-seed<seed>`` where none is given.
        scene: what is rendered.
        views: where from, in order.
        missing: copies that were asked for and found no place.

    ``arrange`` changes the room before it is rendered: chairs round a table, piles.
    """

    def __init__(
        self,
        room: str,
        *,
        seed: int,
        copies: CopySpec | None = None,
        views: int | None = None,
        size_px: int = 300,
        color: bool = True,
        renderer: RendererName = "embree",
        lighting: Lighting | None = None,
        order: str = "random",
        allow_missing: bool = False,
        name: str = "",
        arrange: Callable[[Scene], Spawned] | None = None,
    ) -> None:
        scene = build_scene(room)
        self.missing: tuple[Unplaced, ...] = ()
        if copies is not None and allow_missing:
            spawned = place_copies(scene, copies, seed)
            scene, self.missing = spawned.scene, spawned.missing
        elif copies is not None:
            scene = spawn_copies(scene, copies, seed)
        if arrange is not None:
            spawned = arrange(scene)
            scene, self.missing = spawned.scene, self.missing + spawned.missing
        if not len(scene.cells):
            raise Refused(f"{room} has no cell where the agent can stand: take another room")
        self.name = name or f"{room}-seed{seed}"
        self.scene: Scene = scene
        self.views: list[View] = plan_views(scene.cells, views, seed, order)
        self._renderer = make_renderer(renderer, scene, size_px, color=color, lighting=lighting)
        self._seen: Counter[int] = Counter()

    @property
    def intrinsics(self) -> Intrinsics:
        """The camera's intrinsics, the same in every view."""
        return self._renderer.camera.intrinsics

    def picture(self, view: View) -> Picture:
        """Render one view."""
        return self._renderer.take(view.pose())

    def truth(self) -> list[TrueInstance]:
        """Return all instances; ``views`` counts the frames that :meth:`messages` has given."""
        return true_instances(self.scene.instances, dict(self._seen))

    def messages(self) -> Iterator[Message]:
        """Render the views: started, then colour, depth and detections of each, then finished.

        The same episode gives the same bytes: stamps count 100 ms a frame from a fixed epoch.
        """
        self._seen.clear()
        truth = {item.number: item for item in self.truth()}
        by_id = {item.object_id: item.number for item in truth.values()}
        count, room = len(self.views), self.scene.name
        yield Exploration(
            stamp_ns=EPOCH_NS, episode=self.name, state="started", frames=count, room=room
        )
        for frame, view in enumerate(self.views):
            picture = self.picture(view)
            found = self._detections(frame, picture, truth)
            self._seen.update(by_id[item.object_id] for item in found.detections)
            if picture.color is not None:
                yield self._color_frame(frame, picture.color)
            yield self._depth_frame(frame, view, picture)
            yield found
        yield Exploration(
            stamp_ns=EPOCH_NS + count * FRAME_NS,
            episode=self.name,
            state="finished",
            frames=count,
            room=room,
            covered_area_m2=round(len(self.scene.cells) * CELL_M**2, 4),
        )

    def _color_frame(self, frame: int, color: NDArray[np.uint8]) -> ColorFrame:
        done, data = cv2.imencode(
            ".jpg", color[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY]
        )
        if not done:
            raise Refused("OpenCV cannot write JPEG: reinstall opencv-python-headless")
        return ColorFrame(
            stamp_ns=EPOCH_NS + frame * FRAME_NS,
            episode=self.name,
            frame=frame,
            height_px=color.shape[0],
            width_px=color.shape[1],
            encoding="jpeg",
            data=np.asarray(data, np.uint8).ravel(),
        )

    def _depth_frame(self, frame: int, view: View, picture: Picture) -> DepthFrame:
        depth_mm = np.rint(picture.depth_m * np.float32(1000))
        return DepthFrame(
            stamp_ns=EPOCH_NS + frame * FRAME_NS,
            episode=self.name,
            frame=frame,
            height_px=depth_mm.shape[0],
            width_px=depth_mm.shape[1],
            encoding="u16_mm",
            intrinsics=self.intrinsics,
            pose=view.pose(),
            data=np.clip(depth_mm, 0, 65535).astype(np.uint16),
        )

    def _detections(
        self, frame: int, picture: Picture, truth: dict[int, TrueInstance]
    ) -> SimDetections:
        return SimDetections(
            stamp_ns=EPOCH_NS + frame * FRAME_NS,
            episode=self.name,
            frame=frame,
            height_px=picture.ids.shape[0],
            width_px=picture.ids.shape[1],
            detections=detections(picture.ids, truth),
        )


def truth_json(episode: RoomEpisode) -> bytes:
    """Return the ground truth of what was rendered: instances, and copies without a place.

    The number of views of each instance is known once the messages were taken.
    """
    fields = {
        "episode": episode.name,
        "instances": episode.truth(),
        "missing": episode.missing,
    }
    return msgspec.json.format(msgspec.json.encode(fields), indent=1) + b"\n"


def render_episode(
    room: str,
    *,
    seed: int,
    copies: CopySpec | None = None,
    views: int | None = None,
    size_px: int = 300,
    color: bool = True,
) -> Iterator[Message]:
    """Render the exploration of an iTHOR room.

    Args:
        room: ``FloorPlan1`` and so on.
        seed: of the places and colours of the copies, the order of cells and the yaws.
        copies: things to spawn besides the room's own.
        views: number of views; None: one per reachable cell (paper, Section V).
        color: False leaves the colour frames out, which is some twenty times faster.

    Raises:
        Refused: no such room or class, no place for the copies, or a package is missing.
    """
    episode = RoomEpisode(room, seed=seed, copies=copies, views=views, size_px=size_px, color=color)
    return episode.messages()
