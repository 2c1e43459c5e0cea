"""Exploration, health and refusals."""

from __future__ import annotations

from typing import Literal

import msgspec

from doro_schemas.messages.base import Message


class Exploration(Message, kw_only=True):
    """The robot starts to look around, or has finished.

    Attributes:
        state: ``started`` empties the map; ``finished`` asks for the decision.
        frames: number of frames of the episode; -1 where unknown.
        room: name of the place, for people.
        covered_area_m2: area the robot has been to see; -1 where unknown.
    """

    state: Literal["started", "finished"]
    frames: int = -1
    room: str = ""
    covered_area_m2: float = -1.0


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
