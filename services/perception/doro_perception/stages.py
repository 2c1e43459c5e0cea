"""Times of the stages of a frame, taken with a clock that the shell brings: cores read none."""

from __future__ import annotations

from collections.abc import Callable


class Stages:
    """Collects microseconds by stage.

    Args:
        now: seconds from any fixed point; None: nothing is timed, for replays and tests.
    """

    def __init__(self, now: Callable[[], float] | None = None) -> None:
        self._now = now
        self._last_s = 0.0
        self._taken: dict[str, float] = {}

    def start(self) -> None:
        """Begin a frame."""
        self._taken = {}
        if self._now is not None:
            self._last_s = self._now()

    def lap(self, name: str) -> None:
        """Charge the time since the last call to a stage."""
        if self._now is None:
            return
        now_s = self._now()
        spent_us = round((now_s - self._last_s) * 1e6, 1)
        self._taken[name] = self._taken.get(name, 0.0) + spent_us
        self._last_s = now_s

    def taken_us(self) -> dict[str, float]:
        """Return the frame's times by stage, microseconds."""
        return dict(self._taken)
