"""Where the viewer's work goes: a Rerun recording, a live viewer, a picture file."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import rerun as rr
from numpy.typing import NDArray

from doro_schemas.errors import Refused
from doro_schemas.messages.base import Message
from doro_viewer.live import LiveViewer
from doro_viewer.rerun_log import RerunLog
from doro_viewer.settings import ViewerSettings

APPLICATION = "doro"
PNG_COMPRESSION = 6


class NoScreen:
    """Shows nothing: neither a recording nor a live viewer is wanted."""

    def show(self, message: Message) -> None:
        """Do nothing."""

    def close(self) -> None:
        """Do nothing."""


class RerunScreen:
    """A :class:`RerunLog` with its file and its live viewer.

    Args:
        settings: ``rrd``, ``serve`` and ``spawn``.

    Raises:
        Refused: the file cannot be written, or the live viewer does not start.
    """

    def __init__(self, settings: ViewerSettings) -> None:
        sinks: list[Any] = []
        self._live: LiveViewer | None = None
        if settings.rrd:
            sinks.append(rr.FileSink(str(_put_aside(writable(settings.rrd, "viewer.rrd")))))
        if settings.serve or settings.spawn:
            self._live = LiveViewer(settings)
            self._live.open()
            sinks.append(rr.GrpcSink(self._live.url))
            where = self._live.page if settings.serve else "Rerun's window"
            print(f"doro-viewer: watch the run in {where}", file=sys.stderr, flush=True)
        stream = rr.RecordingStream(APPLICATION)
        # Rerun's own clocks would put a second, meaningless time axis beside the data's.
        stream.set_log_time_enabled(False)
        stream.set_log_tick_enabled(False)
        stream.set_sinks(*sinks)
        self._log = RerunLog(stream, settings)

    def show(self, message: Message) -> None:
        """Show a message."""
        self._log.show(message)

    def close(self) -> None:
        """Complete the file and end the live viewer."""
        self._log.close()
        if self._live is not None:
            self._live.close()


class NoAlbum:
    """Keeps no picture."""

    def keep(self, picture: NDArray[np.uint8], dialogue: str) -> None:
        """Do nothing."""


class PngAlbum:
    """Keeps the pictures as PNG files; a reader never sees half of one.

    Args:
        path: the file of an episode's first dialogue; its directory must be there. Dialogue
            ``n`` goes beside it: ``map.png``, ``map-2.png``, ``map-3.png``.

    Raises:
        Refused: the directory is missing or not writable.
    """

    def __init__(self, path: str) -> None:
        self._path = writable(path, "viewer.png")

    def keep(self, picture: NDArray[np.uint8], dialogue: str) -> None:
        """Write an RGB picture, uint8 (height, width, 3), in place of the dialogue's last."""
        suffix = f"-{dialogue}" if dialogue.isdecimal() and dialogue != "1" else ""
        path = self._path.with_name(f"{self._path.stem}{suffix}{self._path.suffix}")
        unfinished = path.with_name(f".{path.name}.part")
        unfinished.write_bytes(png_bytes(picture))
        unfinished.replace(path)


def png_bytes(picture: NDArray[np.uint8]) -> bytes:
    """Return an RGB picture as a PNG file's bytes, equal for equal pictures."""
    bgr = cv2.cvtColor(picture, cv2.COLOR_RGB2BGR)
    done, data = cv2.imencode(".png", bgr, [cv2.IMWRITE_PNG_COMPRESSION, PNG_COMPRESSION])
    if not done:
        raise RuntimeError(f"OpenCV could not encode a picture of shape {picture.shape}")
    return bytes(data.tobytes())


def _put_aside(file: Path) -> Path:
    """Rename an older recording, so that a restart after a crash does not destroy it."""
    if file.exists():
        file.replace(file.with_name(f"{file.stem}.previous{file.suffix}"))
    return file


def writable(path: str, setting: str) -> Path:
    """Return the path of a file that may be written.

    Raises:
        Refused: its directory is missing or not writable, or it is a directory.
    """
    file = Path(path)
    if file.is_dir() or not os.access(file.parent, os.W_OK | os.X_OK):
        raise Refused(
            f"{setting} = '{path}' cannot be written: name a file in a directory that exists"
            " and may be written to"
        )
    return file
