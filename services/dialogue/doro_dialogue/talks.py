"""The state of a dialogue: what was said, decided and asked, and how it ended."""

from __future__ import annotations

from typing import Literal

import msgspec

from doro_dialogue.acts import Heard
from doro_schemas.graph import ObjectGraph
from doro_schemas.messages import Answer, Exploration, Instances, InstructionGraph, Query


class Talk(msgspec.Struct, kw_only=True):
    """One instruction and how far its dialogue is.

    Attributes:
        instruction: what was said and understood.
        readings: the graphs that it may mean, the preferred one first; never empty.
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
        targeted: the latest query was a confirmation that gave its target.
        ended: how the dialogue ended; empty while it is open.
        waiting_since_ns: the first tick after the latest query; 0 before it.
        belief, stable: what the latest belief decided, and how many in a row did.
    """

    instruction: InstructionGraph
    readings: list[ObjectGraph]
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
    targeted: bool = False
    ended: str = ""
    waiting_since_ns: int = 0
    belief: str = ""
    stable: int = 0

    @property
    def graph(self) -> ObjectGraph:
        """The preferred reading."""
        return self.readings[0]

    @property
    def asks(self) -> bool:
        """A question is open that a person may answer."""
        withdrawn = self.query is not None and self.query.reason == WITHDRAWN
        return self.query is not None and not self.ended and not withdrawn

    def wait_for_map(self, reply: Instances, last: int, settle_asks: int) -> bool:
        """Tell whether to ask again since the map still lacks the last frame.

        Bounded: a frame that was lost on the way must not silence the dialogue.
        """
        settled = self.query is not None and not self.query.early
        if settled or max(reply.last_frame, reply.frames_merged - 1) >= last:
            return False
        grew = reply.frames_merged > self.frames_merged
        self.frames_merged = reply.frames_merged
        self.short_replies = 0 if grew else self.short_replies + 1
        return self.short_replies < settle_asks

    def follow(self, query: Query, stamp_ns: int, *, ended: str = "") -> Query:
        """Return a query as the next one of this dialogue: numbered, naming what it replaces."""
        before = self.query
        return msgspec.structs.replace(
            query,
            stamp_ns=stamp_ns,
            revision=0 if before is None else before.revision + 1,
            replaces=-1 if before is None else before.revision,
            ended=ended,
        )


WITHDRAWN = "withdrawn"


class Reading(msgspec.Struct, kw_only=True):
    """An answer whose words are at the parser."""

    talk: Talk
    answer: Answer
    heard: Heard
    graphs: dict[str, ObjectGraph | None] = {}


class State(msgspec.Struct, kw_only=True):
    """All that a restart must not lose; requests on their way are put again.

    Attributes:
        episode, phase: the exploration, and how far it is.
        finished: the word of its end.
        taken_up: instructions that have got their number in the episode.
        deltas: changes of the map in the episode.
        spoken: queries published so far.
        frames: frames in the map that was decided on last.
        talks: the dialogues, in order.
        answers: those at the parser, each with the place of its dialogue in ``talks``.
        latest: by message type, what tells its latest message from another: a late joiner
            gets it once more.
    """

    episode: str = ""
    phase: Literal["none", "started", "finished"] = "none"
    finished: Exploration = msgspec.field(default_factory=lambda: Exploration(state="finished"))
    taken_up: int = 0
    deltas: int = 0
    spoken: int = 0
    frames: int = 0
    talks: list[Talk] = []
    answers: list[tuple[int, Answer]] = []
    latest: dict[str, str] = {}

    def begin(self, episode: str) -> None:
        """Start an episode: what was decided is over, what waits goes with it."""
        self.episode, self.phase = episode, "started"
        self.taken_up = self.deltas = self.frames = 0
        self.talks = [
            Talk(
                instruction=talk.instruction,
                readings=talk.readings,
                number=-1 if talk.number else 0,
            )
            for talk in self.talks
            if talk.query is None or (talk.searching and not talk.ended)
        ]
        self.take_up()

    def take_up(self) -> None:
        """Number the instructions that belong to the current episode, in order."""
        if self.phase == "none":
            return
        for talk in self.talks:
            # One that an earlier episode left undecided (-1) goes with the current one.
            named = talk.instruction.episode
            if talk.number < 0 or (talk.number == 0 and named in ("", self.episode)):
                self.taken_up += 1
                talk.number = self.taken_up

    def open_talks(self) -> list[Talk]:
        """Return the dialogues of the episode that may still be decided or answered."""
        return [
            talk for talk in self.talks if talk.number > 0 and not talk.ended and not talk.searching
        ]
