"""A recording as the steps of a play: frames, starts, ends; checked, cut, and repaired.

Recordings are streamed: the check reads them once and keeps only frame numbers.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Literal

import msgspec

from doro_schemas import codec
from doro_schemas.errors import Refused
from doro_schemas.messages import Exploration
from doro_schemas.messages.base import FrameMessage, Message
from doro_sim_feeder.recording import Recording, Sample

OPEN_FRAMES = 16
INPUT_TOPICS = ("exploration", "color", "depth", "sim_detections")


class Step(msgspec.Struct, frozen=True):
    """Samples that belong together: a frame, or one message of another kind."""

    kind: Literal["frame", "started", "finished", "other"]
    frame: int
    camera: str
    episode: str
    samples: list[Sample]

    @property
    def stamp_ns(self) -> int:
        """Time of the step's first sample."""
        return self.samples[0].stamp_ns

    @property
    def topics(self) -> frozenset[str]:
        """Names of the topics in the step."""
        return frozenset(sample.topic.name for sample in self.samples)


class Cut(msgspec.Struct, frozen=True, kw_only=True):
    """Which part of a recording to play.

    Attributes:
        topics: names of the topics.
        from_s, to_s: seconds since the recording's start; ``started`` is always played.
    """

    topics: tuple[str, ...] = INPUT_TOPICS
    from_s: float = 0.0
    to_s: float = float("inf")


def steps(recording: Recording, topics: tuple[str, ...] = INPUT_TOPICS) -> Iterator[Step]:
    """Group a recording's samples into steps, frames in the order of their first sample.

    A recording from the bus holds the keys of a frame some frames apart, so a frame stays open
    until ``OPEN_FRAMES`` later ones have begun.

    Raises:
        Refused: a sample does not fit.
    """
    opened: dict[tuple[str, str, int], list[Sample]] = {}
    for sample in recording.samples():
        if sample.topic.name not in topics:
            continue
        message = _decoded(sample, recording)
        if isinstance(message, FrameMessage):
            name = (message.episode, message.camera, message.frame)
            opened.setdefault(name, []).append(sample)
            if len(opened) > OPEN_FRAMES:
                yield _close_first(opened)
            continue
        while opened:
            yield _close_first(opened)
        kind = message.state if isinstance(message, Exploration) else "other"
        yield Step(kind, -1, "", message.episode, [sample])
    while opened:
        yield _close_first(opened)


def _close_first(opened: dict[tuple[str, str, int], list[Sample]]) -> Step:
    episode, camera, frame = name = next(iter(opened))
    return Step("frame", frame, camera, episode, opened.pop(name))


def problem_of(recording: Recording, topics: tuple[str, ...] = INPUT_TOPICS) -> str:
    """Return what is wrong with a recording in one sentence; empty where it can be played.

    Looked for: frames of another episode inside one, frames out of order, frames without
    depth, and depth without anything to see in it.
    """
    episode, last = "", dict[str, int]()
    for step in steps(recording, topics):
        if step.kind == "started":
            episode, last = step.episode, {}
        if step.kind != "frame":
            continue
        where = f"frame {step.frame} of {step.camera}"
        if episode and step.episode != episode:
            return f"two rooms are mixed: {where} is of '{step.episode}' inside '{episode}'"
        episode = episode or step.episode
        if step.frame <= last.get(step.camera, -1):
            return f"the frames are out of order: {where} comes after {last[step.camera]}"
        last[step.camera] = step.frame
        if len({sample.key for sample in step.samples}) < len(step.samples):
            return f"{where} is there twice"
        if "depth" in topics and "depth" not in step.topics:
            return f"{where} has no depth, and the map needs it"
        if {"color", "sim_detections"} & set(topics) and step.topics == {"depth"}:
            return f"{where} has depth only: neither colour nor detections"
    return ""


def checked_steps(recording: Recording, cut: Cut, *, repair: bool = False) -> Iterator[Step]:
    """Return the steps to play.

    Args:
        repair: sort what is out of order, separate what is mixed, leave out incomplete
            frames; otherwise such a recording is refused.

    Raises:
        Refused: the recording has a problem and is not to be repaired.
    """
    problem = problem_of(recording, cut.topics)
    if not problem:
        return _within(steps(recording, cut.topics), cut)
    if not repair:
        raise Refused(
            f"recording {recording.path.name}: {problem}; --repair plays it sorted, by room, and"
            " without incomplete frames"
        )
    return _within(repaired(steps(recording, cut.topics), cut.topics), cut)


def repaired(given: Iterable[Step], topics: tuple[str, ...]) -> Iterator[Step]:
    """Yield the episodes one after the other, each started, its frames in order, and finished.

    Samples of a frame that are apart in the file are joined; of two on one key the first
    counts. Everything is held in memory.
    """
    frames: dict[str, dict[tuple[int, str], Step]] = {}
    marks: dict[tuple[str, str], Step] = {}
    for step in given:
        if step.kind == "frame":
            kept = frames.setdefault(step.episode, {})
            have = kept.get((step.frame, step.camera))
            every = [*(have.samples if have else []), *step.samples]
            samples = list({one.key: one for one in reversed(every)}.values())[::-1]
            kept[step.frame, step.camera] = msgspec.structs.replace(step, samples=samples)
        elif step.kind != "other":
            marks.setdefault((step.episode, step.kind), step)
    for episode, kept in frames.items():
        if (episode, "started") in marks:
            yield marks[episode, "started"]
        for name in sorted(kept):
            complete = "depth" not in topics or "depth" in kept[name].topics
            if complete and kept[name].topics != {"depth"}:
                yield kept[name]
        if (episode, "finished") in marks:
            yield marks[episode, "finished"]


def _within(given: Iterable[Step], cut: Cut) -> Iterator[Step]:
    """Yield the steps of a span of time; starts are kept, so that a map is begun."""
    first_ns: int | None = None
    for step in given:
        first_ns = step.stamp_ns if first_ns is None else first_ns
        at_s = (step.stamp_ns - first_ns) / 1e9
        if step.kind in ("started", "finished") or cut.from_s <= at_s <= cut.to_s:
            yield step


def _decoded(sample: Sample, recording: Recording) -> Message:
    """Return what a sample is, for grouping; a frame that will be refused is played as it is."""
    if sample.topic.plain_text and ";" not in sample.encoding:
        return codec.decode_text(sample.payload, sample.topic.messages[0])
    try:
        return codec.decode(sample.payload, sample.encoding, sample.topic.messages)
    except Refused as refused:
        if refused.frame >= 0:
            return FrameMessage(
                frame=refused.frame, episode=refused.episode, height_px=1, width_px=1
            )
        raise Refused(f"recording {recording.path.name}: {refused.reason}") from refused
