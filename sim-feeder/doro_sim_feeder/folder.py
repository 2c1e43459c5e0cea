"""Imports a folder of frames: colour, depth and poses, such as recorded AI2-THOR walks.

The folder holds ``frames.json``::

    {"width": 640, "height": 640, "fov_vertical_deg": 90.0, "camera_offset_y_m": 0.675,
     "depth_scale_m": 0.0196, "depth_max_m": 5.0,
     "frames": [{"task": "walk_1", "index": 0, "position": {"x": .., "y": .., "z": ..},
                 "yaw_deg": 270, "horizon_deg": 30.0}, ...]}

and per frame ``<task>/<index:02d>.rgb.png`` and ``<task>/<index:02d>.depth_u8.png`` (8 bit,
``depth_scale_m`` per step) or ``.depth_u16.png`` (16 bit, millimetres). ``position`` is the
agent's; ``camera_offset_y_m`` (0.675 for the standing agent) is added, or give
``camera_position``. Keys may end in ``_INFERRED``.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from doro_schemas.camera import Intrinsics, intrinsics_from_vertical_fov, pose_from_ai2thor
from doro_schemas.errors import Refused
from doro_schemas.messages import ColorFrame, DepthFrame, Exploration
from doro_schemas.messages.base import Message

EPOCH_NS = 1_700_000_000_000_000_000
FRAME_PERIOD_NS = 100_000_000
DEFAULT_DEPTH_STEP_M = 5.0 / 255
DEFAULT_DEPTH_MAX_M = 5.0
JPEG_QUALITY = 90


class FrameFolder:
    """A folder of frames that is checked and ready to be read.

    Args:
        path: the folder with ``frames.json``.

    Raises:
        Refused: no or unreadable ``frames.json``.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        index = path / "frames.json"
        try:
            self._index: dict[str, Any] = json.loads(index.read_text(encoding="utf-8"))
            self._frames: list[dict[str, Any]] = self._index["frames"]
            self.height_px, self.width_px = int(self._index["height"]), int(self._index["width"])
        except OSError as error:
            raise Refused(f"{index} cannot be read: {error.strerror}") from error
        except (ValueError, KeyError, TypeError) as error:
            raise Refused(f"{index} is no frame index: {error!r} is missing or wrong") from error

    @property
    def tasks(self) -> list[str]:
        """Names of the walks in the folder, in order."""
        return list(dict.fromkeys(str(frame.get("task", "")) for frame in self._frames))

    def metadata(self, tasks: list[str]) -> dict[str, str]:
        """Return what a recording of these walks says about itself.

        Raises:
            Refused: an unknown walk.
        """
        unknown = sorted(set(tasks) - set(self.tasks))
        if unknown:
            raise Refused(f"{self.path.name} has no walk '{unknown[0]}'; it has {self.tasks}")
        return {"source": "folder", "room": self.path.name, "walks": ", ".join(tasks)}

    def intrinsics(self) -> Intrinsics:
        """Return the camera's intrinsics."""
        fov_deg = float(self._index.get("fov_vertical_deg", 90.0))
        return intrinsics_from_vertical_fov(self.height_px, self.width_px, fov_deg)

    def messages(self, tasks: list[str] | None = None, episode: str = "") -> Iterator[Message]:
        """Yield the walks as one episode of messages.

        Args:
            tasks: walks to take; all by default.
            episode: name of the episode; the folder's name by default.

        Raises:
            Refused: an image is missing or has another size; an unknown walk.
        """
        self.metadata(tasks or [])  # refuses unknown walks
        name = episode or self.path.name
        chosen = [frame for frame in self._frames if not tasks or frame.get("task") in tasks]
        yield Exploration(state="started", stamp_ns=EPOCH_NS, episode=name, room=self.path.name)
        for number, entry in enumerate(chosen):
            yield from self._frame(number, entry, name)
        yield Exploration(
            state="finished",
            stamp_ns=EPOCH_NS + len(chosen) * FRAME_PERIOD_NS,
            episode=name,
            frames=len(chosen),
            room=self.path.name,
        )

    def _frame(self, number: int, entry: dict[str, Any], episode: str) -> Iterator[Message]:
        stem = self.path / str(entry.get("task", "")) / f"{int(entry['index']):02d}"
        color = _read_image(Path(f"{stem}.rgb.png"), cv2.IMREAD_COLOR)
        depth_mm = self._depth_mm(stem)
        for image in (color, depth_mm):
            if image.shape[:2] != (self.height_px, self.width_px):
                raise Refused(
                    f"{stem.name} of {stem.parent.name} has {image.shape[1]}x{image.shape[0]} px,"
                    f" frames.json says {self.width_px}x{self.height_px}"
                )
        ok, jpeg = cv2.imencode(".jpg", color, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
        if not ok:
            raise Refused(f"{stem}.rgb.png cannot be encoded as JPEG")
        common: dict[str, Any] = {
            "stamp_ns": EPOCH_NS + number * FRAME_PERIOD_NS,
            "episode": episode,
            "frame": number,
            "height_px": self.height_px,
            "width_px": self.width_px,
        }
        yield ColorFrame(**common, encoding="jpeg", data=jpeg.ravel())
        yield DepthFrame(
            **common,
            encoding="u16_mm",
            max_depth_m=float(self._index.get("depth_max_m", DEFAULT_DEPTH_MAX_M)),
            intrinsics=self.intrinsics(),
            pose=self._pose(entry),
            data=depth_mm,
        )

    def _depth_mm(self, stem: Path) -> NDArray[np.uint16]:
        wide = Path(f"{stem}.depth_u16.png")
        if wide.exists():
            return _read_image(wide, cv2.IMREAD_UNCHANGED).astype(np.uint16)
        steps = _read_image(Path(f"{stem}.depth_u8.png"), cv2.IMREAD_UNCHANGED)
        if steps.ndim != 2:
            raise Refused(f"{stem.name}.depth_u8.png must have one channel, got {steps.shape}")
        step_m = float(self._index.get("depth_scale_m", DEFAULT_DEPTH_STEP_M))
        return np.rint(steps.astype(np.float64) * step_m * 1000).astype(np.uint16)

    def _pose(self, entry: dict[str, Any]) -> Any:
        position = entry.get("camera_position")
        if position is None:
            agent = entry["position"]
            height_m = agent["y"] + float(self._index.get("camera_offset_y_m", 0.675))
            position = {"x": agent["x"], "y": height_m, "z": agent["z"]}
        yaw_deg = entry.get("yaw_deg", entry.get("yaw_deg_INFERRED"))
        horizon_deg = entry.get("horizon_deg", entry.get("cameraHorizon_deg_INFERRED", 0.0))
        if yaw_deg is None:
            raise Refused(f"frame {entry.get('index')} of frames.json has no yaw_deg")
        return pose_from_ai2thor(position, float(yaw_deg), float(horizon_deg))


def _read_image(path: Path, mode: int) -> NDArray[Any]:
    image = cv2.imread(str(path), mode)
    if image is None:
        raise Refused(f"image {path.parent.name}/{path.name} is missing or damaged")
    return np.asarray(image)
