"""Joins the two halves of a frame: depth with pose, and the graphs of its detections."""

from __future__ import annotations

import bisect
import sys
from dataclasses import dataclass

from doro_schemas.errors import Refused
from doro_schemas.messages import DepthFrame, FrameGraphs

Key = tuple[str, int]
"""(camera, frame) within one episode."""


MAX_RUNS = 256


class FrameRuns:
    """Which frames were merged, as runs of numbers by camera.

    Memory: bounded by MAX_RUNS runs a camera; beyond them the gap between the two lowest runs
    closes, and what still comes for it counts as merged.
    """

    def __init__(self) -> None:
        self._runs: dict[str, list[list[int]]] = {}
        self._count = 0

    def __len__(self) -> int:
        return self._count

    def __contains__(self, key: Key) -> bool:
        runs = self._runs.get(key[0], [])
        at = bisect.bisect_right(runs, [key[1], sys.maxsize]) - 1
        return at >= 0 and key[1] <= runs[at][1]

    def add(self, key: Key) -> None:
        """Add a frame that is not in yet."""
        runs, number = self._runs.setdefault(key[0], []), key[1]
        self._count += 1
        at = bisect.bisect_right(runs, [number, sys.maxsize]) - 1
        if at >= 0 and runs[at][1] == number - 1:
            runs[at][1] = number
        else:
            at += 1
            runs.insert(at, [number, number])
        if at + 1 < len(runs) and runs[at + 1][0] == number + 1:
            runs[at][1] = runs.pop(at + 1)[1]
        if len(runs) > MAX_RUNS:
            runs[0][1] = runs.pop(1)[1]


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
