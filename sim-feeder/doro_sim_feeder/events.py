"""AI2-THOR events as messages: live ones, and those of a folder (a dump).

A dump holds, per event, ``<name>.metadata.json.gz`` (or ``.json``; ``event.metadata``),
``<name>.rgb.png`` (``event.frame``) and, if they were recorded, ``<name>.depth.npy`` (float32
metres) or ``<name>.depth_u16.png`` (millimetres), and ``<name>.detections2D.json``
(``instance_detections2D``). Events lie in the folder itself or in one folder per episode.

Without ``detections2D`` boxes are projected from the 3-D metadata, of visible objects only.
Without depth the recording says so (metadata ``depth: none``) and serves perception only.
"""

from __future__ import annotations

import gzip
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from doro_schemas.errors import Refused
from doro_schemas.messages import ColorFrame, DepthFrame, Exploration, SimDetections
from doro_schemas.messages.base import Message
from doro_sim_feeder.ai2thor_objects import (
    InclusiveBoxes,
    camera_of,
    detections_from_boxes,
    objects_of,
    projected_detections,
)

EPOCH_NS = 1_700_000_000_000_000_000
FRAME_PERIOD_NS = 100_000_000
JPEG_QUALITY = 90
FAR_M = 20.0  # AI2-THOR's far plane: what lies there is unknown
METADATA_ENDINGS = (".metadata.json.gz", ".metadata.json")


class SimEvent(Protocol):
    """What is needed of an ``ai2thor.server.Event``."""

    @property
    def metadata(self) -> Any: ...
    @property
    def frame(self) -> Any: ...
    @property
    def depth_frame(self) -> Any: ...
    @property
    def instance_detections2D(self) -> Any: ...  # noqa: N802 - AI2-THOR's name


@dataclass(frozen=True)
class DumpedEvent:
    """An event read from files, with the names of AI2-THOR's own class."""

    metadata: Mapping[str, Any]
    frame: NDArray[np.uint8]
    depth_frame: NDArray[np.float32] | None
    instance_detections2D: InclusiveBoxes | None  # noqa: N815 - AI2-THOR's name


def messages_of_event(event: SimEvent, frame: int, episode: str) -> list[Message]:
    """Return an event as ColorFrame (jpeg), DepthFrame (f32_m, if there is depth), SimDetections.

    Args:
        event: ``frame`` uint8 (h, w, 3) RGB; ``depth_frame`` float32 (h, w) planar metres or
            None; ``instance_detections2D`` by object id, last pixel inclusive, or None.
        frame: its number in the episode.

    Raises:
        Refused: images of other sizes or kinds, or metadata that is not AI2-THOR's.
    """
    try:
        return _messages(event, frame, episode)
    except Refused as refused:
        raise Refused(f"event {frame}: {refused.reason}", episode=episode, frame=frame) from refused


def _messages(event: SimEvent, frame: int, episode: str) -> list[Message]:
    rgb, depth = event.frame, event.depth_frame
    if rgb is None or rgb.ndim != 3 or rgb.shape[2] != 3 or rgb.dtype != np.uint8:
        raise Refused("it has no colour frame of uint8 (height, width, 3)")
    height_px, width_px = rgb.shape[:2]
    common: dict[str, Any] = {
        "stamp_ns": EPOCH_NS + frame * FRAME_PERIOD_NS,
        "episode": episode,
        "frame": frame,
        "height_px": height_px,
        "width_px": width_px,
    }
    intrinsics, pose = camera_of(event.metadata, height_px, width_px)
    messages: list[Message] = [ColorFrame(**common, encoding="jpeg", data=_jpeg(rgb))]
    if depth is not None:
        if depth.shape != (height_px, width_px):
            raise Refused(f"depth of shape {depth.shape}, colour has {height_px}x{width_px}")
        messages.append(
            DepthFrame(
                **common,
                encoding="f32_m",
                max_depth_m=FAR_M,
                intrinsics=intrinsics,
                pose=pose,
                data=np.ascontiguousarray(depth, np.float32),
            )
        )
    objects = objects_of(event.metadata)
    boxes = event.instance_detections2D
    if boxes is None:
        found = projected_detections(objects, intrinsics, pose, height_px, width_px)
    else:
        found = detections_from_boxes(objects, boxes)
    messages.append(SimDetections(**common, detections=found))
    return messages


class EventFolder:
    """A dump of events that is checked and ready to be read.

    Args:
        path: the folder.

    Raises:
        Refused: there is no event in it.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._events = _find(path)
        if not self._events:
            raise Refused(
                f"{path} holds no events: <name>.metadata.json.gz beside <name>.rgb.png is needed"
            )

    @property
    def tasks(self) -> list[str]:
        """Names of the episodes in the folder, in order; one empty name where it is one."""
        return list(self._events)

    def metadata(self, tasks: list[str]) -> dict[str, str]:
        """Return what a recording of these episodes says about itself.

        Raises:
            Refused: no such episode, or several rooms.
        """
        files = self._chosen(tasks)
        rooms = sorted({self._room(stem) for stem in files})
        if len(rooms) > 1:
            raise Refused(
                f"{self.path.name} holds events of {len(rooms)} rooms ({', '.join(rooms[:3])},"
                " ...): choose episodes of one room with --walk"
            )
        without = [stem for stem in files if _depth_file(stem) is None]
        if without and len(without) < len(files):
            raise Refused(
                f"event {without[0].name} has no depth, others of {self.path.name} have: import"
                " them apart"
            )
        depth = "none" if without else "f32_m"
        return {"source": "ai2thor events", "room": rooms[0], "depth": depth}

    def messages(self, tasks: list[str] | None = None, episode: str = "") -> Iterator[Message]:
        """Yield the events as one episode of messages.

        Args:
            tasks: episodes to take; all by default.
            episode: name of the episode; the folder's (or the one task's) name by default.

        Raises:
            Refused: a file is missing or damaged, or the events are of several rooms.
        """
        room = self.metadata(tasks or [])["room"]
        files = self._chosen(tasks or [])
        name = episode or (tasks[0] if tasks and len(tasks) == 1 else self.path.name)
        yield Exploration(
            state="started", stamp_ns=EPOCH_NS, episode=name, frames=len(files), room=room
        )
        for number, stem in enumerate(files):
            yield from messages_of_event(read_event(stem), number, name)
        yield Exploration(
            state="finished",
            stamp_ns=EPOCH_NS + len(files) * FRAME_PERIOD_NS,
            episode=name,
            frames=len(files),
            room=room,
        )

    def _chosen(self, tasks: list[str]) -> list[Path]:
        unknown = sorted(set(tasks) - set(self.tasks))
        if unknown:
            raise Refused(f"{self.path.name} has no episode '{unknown[0]}'; it has {self.tasks}")
        return [
            stem
            for task, files in self._events.items()
            if not tasks or task in tasks
            for stem in files
        ]

    def _room(self, stem: Path) -> str:
        return str(_metadata(stem).get("sceneName", "")).removesuffix("_physics")


def read_event(stem: Path) -> DumpedEvent:
    """Return one event; ``stem`` is the path without the endings.

    Raises:
        Refused: a file is missing or damaged.
    """
    bgr = cv2.imread(f"{stem}.rgb.png", cv2.IMREAD_COLOR)
    if bgr is None:
        raise Refused(f"image {stem.name}.rgb.png is missing or damaged")
    boxes = Path(f"{stem}.detections2D.json")
    return DumpedEvent(
        metadata=_metadata(stem),
        frame=np.ascontiguousarray(bgr[..., ::-1]).astype(np.uint8),
        depth_frame=_depth(stem),
        instance_detections2D=_json(boxes) if boxes.exists() else None,
    )


def _find(path: Path) -> dict[str, list[Path]]:
    """Return the events by episode, in order of their names."""
    found: dict[str, list[Path]] = {}
    for folder in (path, *sorted(child for child in path.glob("*") if child.is_dir())):
        stems = sorted(
            {
                file.parent / file.name.removesuffix(ending)
                for ending in METADATA_ENDINGS
                for file in folder.glob(f"*{ending}")
            }
        )
        if stems:
            found["" if folder == path else folder.name] = stems
    return found


def _metadata(stem: Path) -> dict[str, Any]:
    for ending in METADATA_ENDINGS:
        path = Path(f"{stem}{ending}")
        if path.exists():
            content = _json(path)
            if isinstance(content, dict):
                return content
            raise Refused(f"{path.name} is no event metadata: an object is needed")
    raise Refused(f"{stem.name}.metadata.json.gz is missing")


def _json(path: Path) -> Any:
    try:
        raw = path.read_bytes()
        return json.loads(gzip.decompress(raw) if path.suffix == ".gz" else raw)
    except (OSError, EOFError, ValueError) as error:
        raise Refused(f"{path.parent.name}/{path.name} cannot be read: {error}") from error


def _depth_file(stem: Path) -> Path | None:
    for ending in (".depth.npy", ".depth_u16.png"):
        path = Path(f"{stem}{ending}")
        if path.exists():
            return path
    return None


def _depth(stem: Path) -> NDArray[np.float32] | None:
    path = _depth_file(stem)
    if path is None:
        return None
    if path.suffix == ".npy":
        try:
            return np.asarray(np.load(path, allow_pickle=False), np.float32)
        except (OSError, EOFError, ValueError) as error:
            raise Refused(f"{path.name} is no depth image: {error}") from error
    millimetres = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    if millimetres is None or millimetres.dtype != np.uint16:
        raise Refused(f"{path.name} is no depth image of 16 bits")
    return (np.asarray(millimetres, np.float32) / np.float32(1000)).astype(np.float32)


def _jpeg(rgb: NDArray[np.uint8]) -> NDArray[np.uint8]:
    done, data = cv2.imencode(".jpg", rgb[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
    if not done:
        raise Refused("OpenCV cannot write JPEG: reinstall opencv-python-headless")
    return np.asarray(data, np.uint8).ravel()
