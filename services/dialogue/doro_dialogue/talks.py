"""The state of a dialogue: what was said, decided and asked, and how it ended."""

from __future__ import annotations

from typing import Literal

import msgspec

from doro_dialogue.acts import Heard
from doro_schemas.graph import ObjectGraph
from doro_schemas.messages import Answer, Instances, InstructionGraph, Query


class Talk(msgspec.Struct, kw_only=True):
    """One instruction and how far its dialogue is.

    Attributes:
        instruction, graph: what was said and understood.
        number: ordinal within its episode, from 1; 0 while no episode has taken it up.
        query: the latest published, None while undecided.
        asked: requests on their way for it.
        stale: the map changed while one was on its way.
        short_replies: replies in a row that lacked the last frame and brought nothing new.
        frames_merged: frames in the map of the latest reply.
        decided: the latest query that came from the map, not from an answer.
        reply: what the map knew then.
        spoken: when the latest query was published, counted over all dialogues.
        turns: answers taken.
        searching: the person named another place; decided anew in the next episode.
        replaced: an answer put another object in place of the first.
        ended: how the dialogue ended; empty while it is open.
    """

    instruction: InstructionGraph
    graph: ObjectGraph
    number: int = 0
    query: Query | None = None
    asked: int = 0
    stale: bool = False
    short_replies: int = 0
    frames_merged: int = -1
    decided: Query | None = None
    reply: Instances | None = None
    spoken: int = 0
    turns: int = 0
    searching: bool = False
    replaced: bool = False
    ended: str = ""

    def wait_for_map(self, reply: Instances, last: int, settle_asks: int) -> bool:
        """Tell whether to ask again since the map still lacks the last frame.

        Bounded: a frame that was lost on the way must not silence the dialogue.
        """
        if self.query is not None or max(reply.last_frame, reply.frames_merged - 1) >= last:
            return False
        grew = reply.frames_merged > self.frames_merged
        self.frames_merged = reply.frames_merged
        self.short_replies = 0 if grew else self.short_replies + 1
        return self.short_replies < settle_asks


class Pending(msgspec.Struct, kw_only=True):
    """A request on its way: for which dialogue, for what, and the stamp of its cause."""

    talk: Talk
    purpose: Literal["decide", "belief"]
    stamp_ns: int


class Reading(msgspec.Struct, kw_only=True):
    """An answer whose words are at the parser."""

    talk: Talk
    answer: Answer
    heard: Heard
    graphs: dict[str, ObjectGraph | None] = {}
