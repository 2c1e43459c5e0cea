"""Plays a recording onto the bus as if it were the robot.

Lossless playing (the default) uses the mapper's deltas as acknowledgements: at most
``window`` frames are under way, so nothing is dropped and a replay is bit-identical however
the processes are scheduled. Real-time playing follows the stamps.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Literal

import msgspec

from doro_schemas.bus import Bus
from doro_schemas.detector_errors import ErrorModels, FalsePositivePool
from doro_schemas.errors import Refused
from doro_schemas.messages import ExplorationGoal, GridDelta, Rejected
from doro_schemas.messages.base import Message
from doro_schemas.topics import TOPICS
from doro_sim_feeder.disturb import disturbed
from doro_sim_feeder.planned import Tour, tours, view_count
from doro_sim_feeder.recording import Recording
from doro_sim_feeder.steps import Cut, Step, checked_steps


class PlaySettings(msgspec.Struct, frozen=True, kw_only=True):
    """How to play.

    Attributes:
        speed: 0 = as fast as the chain takes it without loss; 1 = real time; 2 = twice.
        window: frames under way at most, when lossless.
        ack_timeout_s: a frame that nobody merged within it counts as lost.
        cut: which topics and which span of time.
        repair: play a recording with problems as far as it can be put right.
        errors: detector errors to put into the simulator's detections.
        pool: where false positives are pasted from; needed for them only.
        order: ``recorded``, or ``planned``: the views that the mapper's goals ask for.
        views: planned: how many at most, a number or a share ("33%"); "": until done.
    """

    speed: float = 0.0
    window: int = 8
    ack_timeout_s: float = 10.0
    cut: Cut = Cut()
    repair: bool = False
    errors: ErrorModels = ErrorModels()
    pool: FalsePositivePool | None = None
    order: Literal["recorded", "planned"] = "recorded"
    views: str = ""

    def __post_init__(self) -> None:
        if self.order == "planned" and self.speed > 0:
            raise Refused("--order planned goes at the map's pace: leave out --speed")
        if self.order == "recorded" and self.views:
            raise Refused("--views is for --order planned; use --from and --to to cut")


class PlayReport(msgspec.Struct, kw_only=True):
    """What came of a play.

    Attributes:
        pacing_p95_ms: how late a step was sent, 95th percentile; -1 where not by the clock.
        goals: planned: goals that came.
        done: planned: the mapper said that no view left promises enough.
    """

    episode: str = ""
    frames: int = 0
    merged: int = 0
    refused: int = 0
    lost: int = 0
    elapsed_s: float = 0.0
    pacing_p95_ms: float = -1.0
    goals: int = 0
    done: bool = False


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
        self._goal: ExplorationGoal | None = None
        self._merged: set[tuple[str, int]] = set()
        bus.subscribe(TOPICS["grid_delta"], self._on_delta, late=False)
        bus.subscribe(TOPICS["rejected"], self._on_rejected, late=False)
        bus.subscribe(TOPICS["goal"], self._on_goal, late=False)

    def play(self, recording: Recording) -> PlayReport:
        """Play a recording to its end.

        Raises:
            Refused: the recording does not fit, or nobody maps.
        """
        self._report = PlayReport()
        self._under_way.clear()
        started_s = begun_s = time.monotonic()
        first_stamp_ns: int | None = None
        late_ms: list[float] = []
        given = checked_steps(recording, self._settings.cut, repair=self._settings.repair)
        given = disturbed(given, self._settings.errors, self._settings.pool)
        planned = self._settings.order == "planned"
        for tour in tours(given) if planned else ():
            self._play_tour(tour)
        for step in () if planned else given:
            if self._bus.stopping:
                break
            if self._settings.speed > 0:
                if step.kind == "frame" and first_stamp_ns is None:
                    first_stamp_ns, started_s = step.stamp_ns, time.monotonic()
                since_ns = 0 if first_stamp_ns is None else step.stamp_ns - first_stamp_ns
                due_s = started_s + since_ns / 1e9 / self._settings.speed
                self._bus.run_until(due_s)
                late_ms.append((time.monotonic() - due_s) * 1e3)
            self._play_step(step)
        self._drain(0)
        if late_ms:
            self._report.pacing_p95_ms = sorted(late_ms)[int(len(late_ms) * 0.95)]
        self._report.elapsed_s = time.monotonic() - begun_s
        return self._report

    def _play_tour(self, tour: Tour) -> None:
        """Play an episode view by view, each the one left that is nearest to the goal."""
        most = view_count(self._settings.views, len(tour.frames))
        self._goal = None
        self._play_step(tour.start())
        sent, step = 0, tour.next(None)
        while step is not None and not self._bus.stopping:
            self._play_step(step)
            self._drain(0)
            sent += 1
            goal = self._goal_after(step)
            done = goal is not None and goal.done
            self._report.done = done
            if done or sent == most:
                break
            step = tour.next(None if goal is None else goal.view)
        self._play_step(tour.finish(sent))

    def _goal_after(self, step: Step) -> ExplorationGoal | None:
        """Wait for the goal that answers a merged frame; return the last where none comes.

        Raises:
            Refused: the mapper sends no goals at all.
        """
        name, wait_s = (step.camera, step.frame), self._settings.ack_timeout_s
        if name not in self._merged:
            return self._goal

        def came() -> bool:
            return self._goal is not None and (self._goal.camera, self._goal.frame) == name

        if not self._bus.run_until(time.monotonic() + wait_s, came) and self._goal is None:
            raise Refused(
                f"no goal came within {wait_s:g} s of frame {step.frame}: this mapper does not"
                " plan views, play without --order planned"
            )
        return self._goal

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
            self._merged = {(message.camera, message.frame)}

    def _on_goal(self, message: Message) -> None:
        if isinstance(message, ExplorationGoal) and message.episode == self._episode:
            self._goal = message
            self._report.goals += 1

    def _on_rejected(self, message: Message) -> None:
        """A refused frame will never be merged: do not wait for it."""
        if not isinstance(message, Rejected) or message.frame < 0:
            return
        if message.episode not in ("", self._episode):
            return
        for name in [name for name in self._under_way if name[1] == message.frame]:
            del self._under_way[name]
            self._report.refused += 1
