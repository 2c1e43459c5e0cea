"""Plays a recording onto the bus as if it were the robot.

Lossless playing (the default) uses the mapper's deltas as acknowledgements: at most
``window`` frames are under way, so nothing is dropped and a replay is bit-identical however
the processes are scheduled. Real-time playing follows the stamps.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import Literal

import msgspec

from doro_schemas import codec
from doro_schemas.bus import Bus
from doro_schemas.errors import Refused
from doro_schemas.messages import Exploration, GridDelta, Rejected
from doro_schemas.messages.base import FrameMessage, Message
from doro_schemas.topics import TOPICS
from doro_sim_feeder.recording import Recording, Sample

INPUT_TOPICS = ("exploration", "color", "depth", "sim_detections")


class PlaySettings(msgspec.Struct, frozen=True, kw_only=True):
    """How to play.

    Attributes:
        speed: 0 = as fast as the chain takes it without loss; 1 = real time; 2 = twice.
        window: frames under way at most, when lossless.
        ack_timeout_s: a frame that nobody merged within it counts as lost.
        topics: names of the topics to play.
    """

    speed: float = 0.0
    window: int = 8
    ack_timeout_s: float = 10.0
    topics: tuple[str, ...] = INPUT_TOPICS


class PlayReport(msgspec.Struct, kw_only=True):
    """What came of a play."""

    episode: str = ""
    frames: int = 0
    merged: int = 0
    refused: int = 0
    lost: int = 0
    elapsed_s: float = 0.0


class Step(msgspec.Struct, frozen=True):
    """Samples that belong together: a frame, or one message of another kind."""

    kind: Literal["frame", "started", "finished", "other"]
    frame: int
    camera: str
    episode: str
    samples: list[Sample]


def steps(recording: Recording, topics: tuple[str, ...]) -> Iterator[Step]:
    """Group a recording's samples into steps, in order.

    Raises:
        Refused: a sample does not fit, or frames of two episodes are mixed.
    """
    episode = ""
    pending: list[Sample] = []
    current: tuple[str, int] | None = None
    for sample in recording.samples():
        if sample.topic.name not in topics:
            continue
        message = _decoded(sample, recording)
        if isinstance(message, FrameMessage) and (message.camera, message.frame) == current:
            pending.append(sample)
            continue
        if pending and current is not None:
            yield Step("frame", current[1], current[0], episode, pending)
            pending, current = [], None
        if isinstance(message, FrameMessage):
            current, episode, pending = (message.camera, message.frame), message.episode, [sample]
        elif isinstance(message, Exploration):
            yield Step(message.state, -1, "", message.episode, [sample])
        else:
            yield Step("other", -1, "", message.episode, [sample])
    if pending and current is not None:
        yield Step("frame", current[1], current[0], episode, pending)


class Player:
    """Plays steps and keeps account of what the map took.

    Args:
        bus: an open bus; its counters and rejections are the player's.
        progress: called with (frames sent, frames merged) after each step.
    """

    def __init__(
        self,
        bus: Bus,
        settings: PlaySettings,
        progress: Callable[[int, int], None] = lambda _sent, _merged: None,
    ) -> None:
        self._bus = bus
        self._settings = settings
        self._progress = progress
        self._under_way: dict[tuple[str, int], float] = {}
        self._episode = ""
        self._reset_seen = False
        self._report = PlayReport()
        bus.subscribe(TOPICS["grid_delta"], self._on_delta, late=False)
        bus.subscribe(TOPICS["rejected"], self._on_rejected, late=False)

    def play(self, recording: Recording) -> PlayReport:
        """Play a recording to its end.

        Raises:
            Refused: the recording does not fit, or nobody maps.
        """
        started_s = time.monotonic()
        first_stamp_ns: int | None = None
        for step in steps(recording, self._settings.topics):
            if self._bus.stopping:
                break
            stamp_ns = step.samples[0].stamp_ns
            first_stamp_ns = stamp_ns if first_stamp_ns is None else first_stamp_ns
            if self._settings.speed > 0:
                due_s = (stamp_ns - first_stamp_ns) / 1e9 / self._settings.speed
                self._bus.run_until(started_s + due_s)
            self._play_step(step)
        self._drain(0)
        self._report.elapsed_s = time.monotonic() - started_s
        return self._report

    def _play_step(self, step: Step) -> None:
        if step.kind == "started":
            self._start(step)
            return
        if step.kind == "finished":
            self._drain(0)
        if step.kind == "frame":
            self._episode = step.episode
            self._report.episode = step.episode
            self._report.frames += 1
            self._under_way[step.camera, step.frame] = time.monotonic()
        self._send(step)
        if step.kind == "frame" and self._settings.speed == 0:
            self._drain(self._settings.window - 1)
        self._progress(self._report.frames, self._report.merged)

    def _start(self, step: Step) -> None:
        """Send ``started`` and wait until the map is empty, so that no frame overtakes it."""
        self._episode, self._reset_seen = step.episode, False
        self._send(step)
        deadline_s = time.monotonic() + self._settings.ack_timeout_s
        if not self._bus.run_until(deadline_s, lambda: self._reset_seen):
            raise Refused(
                f"the mapper did not start episode '{step.episode}' within"
                f" {self._settings.ack_timeout_s:g} s: is doro-mapper running on this router?"
            )

    def _drain(self, allowed: int) -> None:
        """Wait until at most ``allowed`` frames are under way; give up on frames that are late."""
        while len(self._under_way) > allowed and not self._bus.stopping:
            oldest_s = min(self._under_way.values())
            deadline_s = oldest_s + self._settings.ack_timeout_s
            before = len(self._under_way)
            self._bus.run_until(deadline_s, lambda: len(self._under_way) <= allowed)
            if len(self._under_way) == before and time.monotonic() >= deadline_s:
                late = min(self._under_way, key=lambda name: self._under_way[name])
                del self._under_way[late]
                self._report.lost += 1
                self._bus.counters["frames.lost"] += 1
            self._progress(self._report.frames, self._report.merged)

    def _send(self, step: Step) -> None:
        for sample in step.samples:
            self._bus.put_raw(sample.topic, sample.key, sample.payload, sample.encoding)

    def _on_delta(self, message: Message) -> None:
        if not isinstance(message, GridDelta) or message.episode != self._episode:
            return
        if message.reset:
            self._reset_seen = True
        elif self._under_way.pop((message.camera, message.frame), None) is not None:
            self._report.merged += 1

    def _on_rejected(self, message: Message) -> None:
        """A refused frame will never be merged: do not wait for it."""
        if not isinstance(message, Rejected) or message.frame < 0:
            return
        for name in [name for name in self._under_way if name[1] == message.frame]:
            del self._under_way[name]
            self._report.refused += 1


def _decoded(sample: Sample, recording: Recording) -> Message:
    """Return what a sample is, for grouping; one that is refused is still played as it is."""
    try:
        return codec.decode(sample.payload, sample.encoding, sample.topic.messages)
    except Refused as refused:
        if refused.frame >= 0:
            return FrameMessage(
                frame=refused.frame, episode=refused.episode, height_px=1, width_px=1
            )
        raise Refused(f"recording {recording.path.name}: {refused.reason}") from refused
