"""The topic table: the only place where keys exist.

A row says which messages travel on a key, who sends and who receives them, and by which
delivery policy (:data:`POLICIES`, applied in :mod:`doro_schemas.bus`). Keys are relative;
the session's ``namespace`` prefixes them, one per robot.
"""

from __future__ import annotations

from enum import Enum
from typing import Literal

import msgspec

from doro_schemas import messages as m
from doro_schemas.messages.base import Message

Kind = Literal["pubsub", "queryable", "liveliness"]


class Delivery(Enum):
    """How a topic's samples travel."""

    CONFIRMED = "every, confirmed"
    EVERY = "every"
    FRAME = "latest live, every on replay"
    LATEST = "latest"
    QUERY = "query"
    TOKEN = "token"


class Policy(msgspec.Struct, frozen=True):
    """What a delivery means in Zenoh's terms.

    Attributes:
        congestion: ``block``, ``block_first`` or ``drop`` when the link is saturated.
        priority: Zenoh priority by name.
        express: sent at once, not batched.
        cache: samples that the publisher keeps for late joiners and for recovery; 0 = plain.
        queue: samples that a slow subscriber keeps; the oldest droppable one goes first.
            0 = all are kept.
    """

    congestion: Literal["block", "block_first", "drop"]
    priority: str
    express: bool = False
    cache: int = 0
    queue: int = 0


POLICIES: dict[Delivery, Policy] = {
    Delivery.CONFIRMED: Policy("block", "INTERACTIVE_HIGH", express=True),
    Delivery.EVERY: Policy("block", "DATA", cache=2000),
    Delivery.FRAME: Policy("block_first", "DATA_LOW", queue=4),
    Delivery.LATEST: Policy("drop", "DATA", express=True, queue=1),
}
"""Frames of a replay are put with ``block`` instead: they must not be lost."""


class Topic(msgspec.Struct, frozen=True):
    """One row of the table.

    Attributes:
        name: short name, for programs ("instruction").
        key: key expression; ``{camera}``, ``{service}`` and ``{replica}`` are filled in.
        messages: types that travel on it; for a queryable, (request, reply).
        kind, delivery: how it travels.
        sender, receiver: who, for people.
        plain_text: payloads without a schema are taken as UTF-8 text.
        late: past samples that a late joiner gets.
        reserved: the key is fixed, but nothing in this version serves it yet.
    """

    name: str
    key: str
    messages: tuple[type[Message], ...]
    delivery: Delivery
    sender: str
    receiver: str
    kind: Kind = "pubsub"
    plain_text: bool = False
    late: int = 0
    reserved: bool = False

    @property
    def pattern(self) -> str:
        """The key expression that matches the topic for every camera and service."""
        return self.key_for(camera="*", service="*", replica="*")

    def key_for(self, *, camera: str = "", service: str = "", replica: str = "") -> str:
        """Return the concrete key."""
        if "{" not in self.key:
            return self.key
        key = self.key.replace("{camera}", camera).replace("{service}", service)
        return key.replace("{replica}", replica)


TABLE: tuple[Topic, ...] = (
    Topic("instruction", "doro/instruction", (m.Instruction,), Delivery.CONFIRMED,
          "person", "nlu", plain_text=True),
    Topic("instruction_graph", "doro/instruction/graph", (m.InstructionGraph,), Delivery.EVERY,
          "nlu", "mapper, dialogue", late=1),
    Topic("color", "doro/frames/{camera}/color", (m.ColorFrame,), Delivery.FRAME,
          "robot or feeder", "perception"),
    Topic("depth", "doro/frames/{camera}/depth", (m.DepthFrame,), Delivery.FRAME,
          "robot or feeder", "mapper"),
    Topic("sim_detections", "doro/sim/detections", (m.SimDetections,), Delivery.EVERY,
          "feeder", "oracle perception"),
    Topic("captions", "doro/captions", (m.FrameCaptions,), Delivery.EVERY,
          "perception", "nlu", late=16),
    Topic("graphs", "doro/graphs", (m.FrameGraphs,), Delivery.EVERY,
          "nlu", "mapper", late=16),
    Topic("grid_delta", "doro/grid/delta", (m.GridDelta,), Delivery.EVERY,
          "mapper", "dialogue, feeder, viewers", late=1),
    Topic("grid", "doro/grid", (m.GridRequest, m.GridSnapshot), Delivery.QUERY,
          "anyone", "mapper", kind="queryable"),
    Topic("instances", "doro/instances", (m.InstancesRequest, m.Instances), Delivery.QUERY,
          "anyone", "mapper", kind="queryable"),
    Topic("exploration", "doro/exploration", (m.Exploration,), Delivery.EVERY,
          "robot or feeder", "mapper, dialogue", late=1),
    Topic("poses", "doro/poses", (m.PoseCorrections,), Delivery.EVERY,
          "robot", "mapper"),
    Topic("goal", "doro/exploration/goal", (m.ExplorationGoal,), Delivery.LATEST,
          "mapper", "robot or feeder"),
    Topic("belief", "doro/belief", (m.Belief,), Delivery.LATEST,
          "dialogue", "viewers"),
    Topic("query", "doro/query", (m.Query,), Delivery.EVERY,
          "dialogue", "person", late=1),
    Topic("answer", "doro/answer", (m.Answer,), Delivery.CONFIRMED,
          "person", "dialogue", plain_text=True),
    Topic("target", "doro/target", (m.Target,), Delivery.EVERY,
          "dialogue", "robot"),
    Topic("parse", "doro/nlu/parse", (m.ParseRequest, m.ParseReply), Delivery.QUERY,
          "anyone", "nlu", kind="queryable", plain_text=True),
    Topic("alive", "doro/{service}/alive", (), Delivery.TOKEN,
          "every service", "operator", kind="liveliness"),
    Topic("replica", "doro/{service}/replica/{replica}", (), Delivery.TOKEN,
          "a service with replicas", "its replicas", kind="liveliness"),
    Topic("health", "doro/{service}/health", (m.Health,), Delivery.LATEST,
          "every service", "operator"),
    Topic("rejected", "doro/rejected", (m.Rejected,), Delivery.EVERY,
          "every service", "operator"),
)  # fmt: skip

EVERYTHING = "doro/**"
"""Matches every key of the table, for access control and recorders."""
TOPICS: dict[str, Topic] = {topic.name: topic for topic in TABLE}
_BY_TYPE: dict[type[Message], Topic] = {kind: topic for topic in TABLE for kind in topic.messages}
TYPES: dict[str, type[Message]] = {kind.__name__: kind for kind in _BY_TYPE}


def topic_of(kind: type[Message]) -> Topic:
    """Return the topic on which messages of a type travel."""
    return _BY_TYPE[kind]


def markdown_table() -> str:
    """Return the table as Markdown, for the READMEs (a test keeps them equal)."""
    rows = ["| key | message | from -> to | delivery |", "|---|---|---|---|"]
    for topic in TABLE:
        names = " -> ".join(kind.__name__ for kind in topic.messages) or "-"
        text = "plain UTF-8 or " if topic.plain_text else ""
        note = " (reserved)" if topic.reserved else ""
        rows.append(
            f"| `{topic.key}` | {text}{names} | {topic.sender} -> {topic.receiver} |"
            f" {topic.delivery.value}{note} |"
        )
    return "\n".join(rows)
