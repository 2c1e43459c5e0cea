"""Joins the two halves of a frame: depth with pose, and the graphs of its detections."""

from __future__ import annotations

from dataclasses import dataclass

from doro_schemas.errors import Refused
from doro_schemas.messages import DepthFrame, FrameGraphs

Key = tuple[str, int]
"""(camera, frame) within one episode."""


@dataclass(slots=True)
class Half:
    """A frame of which one half, or none yet, is there."""

    depth: DepthFrame | None = None
    graphs: FrameGraphs | None = None


class Join:
    """Frames that wait for their other half, at most ``max_pending``, oldest dropped first.

    Memory: ``max_pending`` depth images (64 of 300x300 float32: 23 MB).
    """

    def __init__(self, max_pending: int) -> None:
        self._max_pending = max_pending
        self._pending: dict[Key, Half] = {}

    def __len__(self) -> int:
        return len(self._pending)

    def clear(self) -> None:
        """Forget all halves."""
        self._pending.clear()

    def add(self, message: DepthFrame | FrameGraphs) -> tuple[DepthFrame, FrameGraphs] | None:
        """Take a half; return the frame if it is complete now. A repeated half replaces.

        Raises:
            Refused: the halves disagree about the image's size; both are dropped.
        """
        key = (message.camera, message.frame)
        half = self._pending.setdefault(key, Half())
        if isinstance(message, DepthFrame):
            half.depth = message
        else:
            half.graphs = message
        if half.depth is None or half.graphs is None:
            return None
        del self._pending[key]
        depth, graphs = half.depth, half.graphs
        if (depth.height_px, depth.width_px) != (graphs.height_px, graphs.width_px):
            raise Refused(
                f"frame {message.frame} of {message.camera}: depth is"
                f" {depth.width_px}x{depth.height_px} px but the boxes refer to"
                f" {graphs.width_px}x{graphs.height_px} px: publish both for the same image size",
                episode=message.episode,
                frame=message.frame,
            )
        return depth, graphs

    def overflow(self) -> list[tuple[Key, Half]]:
        """Drop and return the oldest halves beyond the bound."""
        dropped = []
        while len(self._pending) > self._max_pending:
            key = next(iter(self._pending))
            dropped.append((key, self._pending.pop(key)))
        return dropped
