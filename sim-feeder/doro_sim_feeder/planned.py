"""Playing in the order that the map asks for: the recorded view nearest to each goal.

The recording stands for a robot that can take any of its views. ``started`` tells the mapper
which ones those are; after each merged frame it answers with the next view worth taking
(``ExplorationGoal``), until it is done or enough views were played.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import Literal

import msgspec

from doro_schemas import codec
from doro_schemas.errors import Refused
from doro_schemas.messages import DepthFrame, Exploration
from doro_schemas.topics import topic_of
from doro_schemas.viewpoint import Viewpoint, viewpoint_of
from doro_sim_feeder.recording import Sample
from doro_sim_feeder.steps import Step

TURN_M = 1 / 90
"""A degree of another direction counts as so many metres of another place."""


def nearest_view(views: Sequence[Viewpoint], left: Iterable[int], goal: Viewpoint) -> int:
    """Return which of the views left is nearest to a goal; of equal ones the first.

    Distance in metres plus 1 m for each 90 degrees between headings and between tilts; an angle
    that the goal leaves open counts nothing.

    Raises:
        ValueError: no view is left.
    """
    return min(left, key=lambda number: (round(_gap(views[number], goal), 6), number))


def _gap(view: Viewpoint, goal: Viewpoint) -> float:
    gap = math.dist(view.position_m, goal.position_m)
    for own, wanted in ((view.yaw_deg, goal.yaw_deg), (view.horizon_deg, goal.horizon_deg)):
        if own is not None and wanted is not None:
            gap += abs((own - wanted + 180) % 360 - 180) * TURN_M
    return gap


def view_count(text: str, views: int) -> int:
    """Return how many of ``views`` a text means: "60", "33%", or all for "".

    Raises:
        Refused: it is neither, or less than one view.
    """
    try:
        share = text.strip().endswith("%")
        number = float(text.strip().removesuffix("%")) if text.strip() else views
        count = round(number / 100 * views) if share else int(number)
    except (ValueError, OverflowError):
        count = 0
    if count < 1:
        raise Refused(f"--views {text}: give a number of views (60) or a share of them (33%)")
    return min(count, views)


class Tour:
    """The views of one episode, taken in any order.

    Args:
        started, finished: the episode's own marks; None where the recording has none.
        frames: steps with depth; all are held in memory.
    """

    def __init__(self, started: Step | None, frames: list[Step], finished: Step | None) -> None:
        self.frames = frames
        self.views = [_view(step) for step in frames]
        self._marks = {"started": started, "finished": finished}
        self._left = dict.fromkeys(range(len(frames)))

    def start(self) -> Step:
        """Return the word that the robot starts, follows goals, and can take these views."""
        return self._mark("started", goals=True, reachable=self.views)

    def finish(self, count: int) -> Step:
        """Return the word that it has finished after ``count`` views."""
        return self._mark("finished", frames=count)

    def next(self, goal: Viewpoint | None) -> Step | None:
        """Return the view nearest to a goal, without one the first left; None: all were taken."""
        if not self._left:
            return None
        first = next(iter(self._left))
        chosen = first if goal is None else nearest_view(self.views, self._left, goal)
        del self._left[chosen]
        return self.frames[chosen]

    def _mark(self, state: Literal["started", "finished"], **fields: object) -> Step:
        own = self._marks[state]
        stamp_ns = (self.frames[0] if state == "started" else self.frames[-1]).stamp_ns
        plain = Exploration(
            stamp_ns=stamp_ns, episode=self.frames[0].episode, state=state, frames=len(self.frames)
        )
        message = own.samples[0].message() if own is not None else plain
        payload = codec.encode(msgspec.structs.replace(message, **fields))
        topic = topic_of(Exploration)
        encoding = codec.encoding_of(Exploration)
        sample = Sample(topic, topic.key_for(), payload, encoding, message.stamp_ns)
        return Step(state, -1, "", message.episode, [sample])


def tours(steps: Iterable[Step]) -> Iterator[Tour]:
    """Yield the episodes of a recording as tours; steps of other kinds are left out."""
    started: Step | None = None
    finished: Step | None = None
    frames: list[Step] = []
    for step in steps:
        begins = step.kind == "started" or (
            step.kind == "frame" and (finished or (frames and frames[0].episode != step.episode))
        )
        if begins and frames:
            yield Tour(started, frames, finished)
            started, frames = None, []
        if begins:
            finished = None
        if step.kind == "started":
            started = step
        elif step.kind == "finished":
            finished = step
        elif step.kind == "frame":
            frames.append(step)
    if frames:
        yield Tour(started, frames, finished)


def _view(step: Step) -> Viewpoint:
    for sample in step.samples:
        if sample.topic.name == "depth":
            message = sample.message()
            if isinstance(message, DepthFrame):
                return viewpoint_of(message.pose)
    raise Refused(
        f"frame {step.frame} of {step.camera} has no depth and so no pose: views can only be"
        " chosen by pose, play it as recorded"
    )
