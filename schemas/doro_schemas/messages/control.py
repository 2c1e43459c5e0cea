"""Exploration and its goals, health and refusals."""

from __future__ import annotations

from typing import Literal

import msgspec

from doro_schemas.camera import Pose
from doro_schemas.messages.base import Message
from doro_schemas.viewpoint import Viewpoint


class Exploration(Message, kw_only=True):
    """The robot starts to look around, or has finished.

    Attributes:
        state: ``started`` empties the map; ``finished`` asks for the decision.
        frames: number of frames of the episode; -1 where unknown.
        room: name of the place, for people.
        covered_area_m2: area the robot has been to see; -1 where unknown.
        goals: with ``started``: the robot follows :class:`ExplorationGoal`, one after each frame.
        reachable: with ``started``: the views that goals are chosen from, where the robot knows
            them; an angle left open may be any. Empty: the mapper proposes views from the free
            floor that it has seen.

    ``goals`` and ``reachable`` came after the first golden bytes: unset, they are not sent.
    """

    state: Literal["started", "finished"]
    frames: int = -1
    room: str = ""
    covered_area_m2: float = -1.0
    goals: bool | msgspec.UnsetType = msgspec.UNSET
    reachable: list[Viewpoint] | msgspec.UnsetType = msgspec.UNSET


class ExplorationGoal(Message, kw_only=True):
    """The next view worth taking, as of one merged frame.

    Attributes:
        camera, frame: the frame merged last.
        frames_merged: frames in the map.
        done: no reachable view promises enough; the robot may finish.
        view: where to look from; None when done and nothing reachable is left.
        pose: the same as a pose, for programs.
        distance_m: way there over the floor seen so far, from the last frame's camera.
        gain: what the view promises, in things and places made certain; what the travel costs
            is not in it.
        parts: the gain by reason: ``area``, ``tentative``, ``twins``, ``unclear``.
        reason: the same for people, one phrase.
        unseen_share: share of the area that no frame observed, 0..1, as in ``Instances``.
    """

    camera: str = "cam0"
    frame: int = -1
    frames_merged: int = 0
    done: bool = False
    view: Viewpoint | None = None
    pose: Pose | None = None
    distance_m: float = 0.0
    gain: float = 0.0
    parts: dict[str, float] = {}
    reason: str = ""
    unseen_share: float = 1.0


class PoseCorrections(Message, kw_only=True):
    """Frames were taken elsewhere than their poses said: a loop was closed.

    What the mapper keeps of these frames is placed anew. Frames that it does not know, or has
    forgotten, are ignored.

    Attributes:
        camera: whose frames.
        frames: their numbers.
        poses: by frame, the corrected absolute pose.
    """

    camera: str = "cam0"
    frames: list[int]
    poses: list[Pose]

    def __post_init__(self) -> None:
        if len(self.frames) != len(self.poses):
            raise ValueError(
                f"{len(self.frames)} frames but {len(self.poses)} poses: send one pose a frame"
            )
        if len(dict.fromkeys(pose.world for pose in self.poses)) > 1:
            raise ValueError("the poses are in different worlds: send one kind of world")


class StageTiming(msgspec.Struct, frozen=True):
    """Time of one stage since the service's start, microseconds."""

    count: int
    p50_us: float
    p99_us: float


class Health(Message, kw_only=True):
    """A service's counters, once a second and at its stop.

    Attributes:
        counters: ``received``, ``published``, ``rejected``, ``dropped``, ... since its start.
        stages: timing by stage.
        last_rejection: the latest refusal's sentence.
    """

    service: str
    version: str
    uptime_s: float
    counters: dict[str, int] = {}
    stages: dict[str, StageTiming] = {}
    last_rejection: str = ""


class Rejected(Message, kw_only=True):
    """A message that was refused: on which key, by whom, why.

    Attributes:
        key: the key it came on.
        reason: one sentence: what, where, what to do.
        frame: the frame it was about, -1 where unknown.
        size_bytes: size of the payload.
    """

    service: str
    key: str
    reason: str
    frame: int = -1
    size_bytes: int = 0


class ServiceStatus(msgspec.Struct, frozen=True):
    """What ``doro status`` knows of a service."""

    service: str
    alive: bool
    health: Health | None = None
