"""The dialogue as a state machine over messages: no clock, no bus, no randomness.

An instruction waits until the exploration of the current episode is finished; then the map
is asked for the instances of its class, and the reply becomes a Query. Later deltas ask
again, and a changed decision becomes a revised Query. While frames stream, a Belief says
how the decision stands. Every instruction is a dialogue of its own; what a person answers
is taken by :mod:`doro_dialogue.turns`.
"""

from __future__ import annotations

from typing import Literal

import msgspec

from doro_dialogue.facts import check_depth
from doro_dialogue.pending import Pending, Repeats, Requests
from doro_dialogue.settings import DialogueSettings
from doro_dialogue.speaking import SPEAKING_COUNTERS, Speaker
from doro_dialogue.talks import State, Talk
from doro_dialogue.turns import ANSWER_COUNTERS, Turns
from doro_schemas.effects import Ask, Output, Unanswered
from doro_schemas.errors import Refused
from doro_schemas.messages import (
    Answer,
    Exploration,
    GridDelta,
    Instances,
    InstructionGraph,
    ParseReply,
    ParseRequest,
    Query,
)
from doro_schemas.messages.base import Message

MAX_DIALOGUES = 200
UNNAMED_EPISODE = "episode"
COUNTERS = (
    *("instructions", "not_understood", "deltas", "other_episode", "repeated"),
    *("asks", "unanswered", "unexpected_replies", "maps_lost"),
    *(*SPEAKING_COUNTERS, *ANSWER_COUNTERS),
)


class Dialogue:
    """The core of the dialogue service."""

    def __init__(self, settings: DialogueSettings) -> None:
        self._settings = settings
        self._state = State()
        self._requests = Requests()
        self._repeats = Repeats()
        self.counters: dict[str, int] = dict.fromkeys(COUNTERS, 0)
        self._speaker = Speaker(settings, self.counters)
        self._turns = Turns(settings, self.counters, self._speaker)

    def snapshot(self) -> bytes:
        """Return all that :meth:`restore` needs; msgpack, see :class:`State`."""
        places = {id(talk): i for i, talk in enumerate(self._state.talks)}
        for talk in self._state.talks:
            if talk.ended:
                # Nothing will be held against them any more.
                talk.reply = talk.decided = None
        self._state.answers = [(places[id(talk)], one) for talk, one in self._turns.waiting()]
        self._state.spoken, self._state.latest = self._speaker.spoken, self._repeats.latest
        return msgspec.msgpack.encode(self._state)

    def restore(self, kept: bytes) -> list[Output]:
        """Go on where a snapshot was taken; put the requests that were on their way again.

        Raises:
            Refused: the bytes are no snapshot of this version; nothing has changed.
        """
        try:
            state = msgspec.msgpack.decode(kept, type=State)
        except msgspec.DecodeError as error:
            raise Refused(f"the dialogues that were kept do not fit: {error}") from error
        self._state = state
        self._speaker.spoken, self._repeats = state.spoken, Repeats(state.latest)
        self._requests.clear()
        for talk in state.talks:
            talk.stale = talk.stale or (talk.asked > 0 and talk.query is not None)
            talk.asked = 0
        outputs: list[Output] = []
        for place, answer in state.answers:
            outputs += self._turns.take(state.talks[place], answer)
        return [*outputs, *self._decide_open(state.finished.stamp_ns)]

    def tick(self, now_ns: int) -> list[Output]:
        """End the dialogues whose question nobody answers.

        Args:
            now_ns: time by the clock of the shell, Unix nanoseconds.
        """
        return [
            output
            for talk in self._state.open_talks()
            if self._speaker.is_overdue(talk, now_ns)
            for output in self._speaker.time_out(talk, now_ns)
        ]

    def instruction_graph(self, message: InstructionGraph) -> list[Output]:
        """Open a dialogue; after the end of the exploration the map is asked at once.

        Raises:
            Refused: the graph nests too deep, or too many dialogues are open.
        """
        if self._is_repeated(message, message.text):
            return []
        if message.graph is None:
            # nlu has told the operator why; there is nothing to decide.
            self.counters["not_understood"] += 1
            return []
        readings = [message.graph, *message.readings]
        for graph in readings:
            check_depth(graph, f"the instruction '{message.text}'")
        if len(self._state.talks) >= MAX_DIALOGUES:
            raise Refused(
                f"{MAX_DIALOGUES} instructions are open already and '{message.text}' is not taken:"
                " start a new episode",
                episode=message.episode,
            )
        self.counters["instructions"] += 1
        self._state.talks.append(Talk(instruction=message, readings=readings))
        self._state.take_up()
        return self._decide_open(message.stamp_ns)

    def exploration(self, message: Exploration) -> list[Output]:
        """Begin an episode, or ask the map for the decision of every waiting instruction."""
        if self._is_repeated(message, message.state):
            return []
        other = message.episode not in ("", self._state.episode)
        if message.state == "started" or other or self._state.phase == "none":
            self._begin(message.episode)
        if message.state == "started":
            return []
        self._state.phase, self._state.finished = "finished", message
        for talk in self._state.talks:
            talk.short_replies = 0
            talk.stale = talk.query is not None
        return self._decide_open(message.stamp_ns)

    def grid_delta(self, message: GridDelta) -> list[Output]:
        """Follow the map: a Belief now and then while exploring, a new look after its end.

        A map that was emptied begins the episode as ``started`` does: the two travel on
        different keys, so either may come first.
        """
        if self._is_repeated(message, f"{message.seq} {message.frame} {message.reset}"):
            return []
        if message.reset and (
            self._state.phase != "started" or message.episode != self._state.episode
        ):
            self._begin(message.episode)
        if message.episode not in ("", self._state.episode) or self._state.phase == "none":
            self.counters["other_episode"] += 1
            return []
        if message.reset:
            return []
        self.counters["deltas"] += 1
        self._state.deltas += 1
        if self._state.phase == "finished":
            for talk in self._state.talks:
                talk.stale = True
            return self._decide_open(message.stamp_ns)
        if self._state.deltas % self._settings.belief_every_frames:
            return []
        return [self._ask(talk, "belief", message.stamp_ns) for talk in self._state.open_talks()]

    def instances(self, message: Instances) -> list[Output]:
        """Take the map's reply: decide the dialogue that asked first for this class.

        Raises:
            Refused: an instance graph nests too deep, or two instances have one id.
        """
        pending = self._requests.take(message.name)
        if pending is None:
            self.counters["unexpected_replies"] += 1
            return []
        try:
            if pending.purpose == "belief":
                names, early = self._names(pending.talk), self._state.phase == "started"
                return self._speaker.believe(
                    pending.talk, message, pending.stamp_ns, names=names, early=early
                )
            return self._decide(pending, message)
        except Refused as refused:
            # Requests that the shell has not put yet are lost with the refusal.
            self._requests.forget()
            raise Refused(refused.reason, episode=self._state.episode) from refused

    def answer(self, message: Answer) -> list[Output]:
        """Take what a person answers; its words go to the parser where they describe.

        Raises:
            Refused: no such dialogue, or it is finished, or nothing was asked.
        """
        talk = self._turns.find(
            message, [t for t in self._state.talks if t.number > 0], self._id_of
        )
        return self._after(talk, message.stamp_ns, self._turns.take(talk, message))

    def parse_reply(self, message: ParseReply) -> list[Output]:
        """Take the parser's graph of an answer's words; with the last one it is understood."""
        reading = self._turns.read(message)
        if reading is None:
            return []
        talk, stamp_ns = reading.talk, reading.answer.stamp_ns
        return self._after(talk, stamp_ns, self._turns.conclude(reading))

    def _after(self, talk: Talk, stamp_ns: int, outputs: list[Output]) -> list[Output]:
        """Remember what was said last; ask the map where another object is wanted."""
        for output in outputs:
            if isinstance(output, Query):
                self._speaker.speak(talk, output)
        if talk.replaced and talk.stale and talk.asked == 0:
            return [*outputs, self._ask(talk, "decide", stamp_ns)]
        return outputs

    def unanswered(self, message: Unanswered) -> list[Output]:
        """Keep the dialogues waiting; the next delta, exploration or instruction asks again.

        Raises:
            Refused: always, for the operator.
        """
        self.counters["unanswered"] += 1
        if isinstance(message.request, ParseRequest):
            self._turns.forget(message)
        waiting = sum(talk.query is None for talk in self._state.open_talks())
        self._requests.forget()
        raise Refused(
            f"{message.reason.rstrip('.')}; {waiting} instruction(s) wait for the map"
            " and it is asked again with the next frame, exploration or instruction",
            episode=self._state.episode,
        )

    def _begin(self, episode: str) -> None:
        self._state.begin(episode)
        self._requests.clear()
        self._turns.clear()

    def _decide_open(self, stamp_ns: int) -> list[Output]:
        """After the exploration ask for every dialogue that is undecided or stale.

        Those whose request is on its way are left.
        """
        if self._state.phase != "finished":
            return []
        return [
            self._ask(talk, "decide", stamp_ns)
            for talk in self._state.open_talks()
            if talk.asked == 0 and (talk.query is None or talk.stale)
        ]

    def _ask(self, talk: Talk, purpose: Literal["decide", "belief"], stamp_ns: int) -> Ask:
        self.counters["asks"] += 1
        return self._requests.ask(talk, purpose, stamp_ns, self._state.episode)

    def _decide(self, pending: Pending, reply: Instances) -> list[Output]:
        """Publish the first query, or a revised one if the decision changed."""
        talk, stamp_ns = pending.talk, pending.stamp_ns
        talk.asked -= 1
        if reply.frames_merged < self._state.frames:
            return self._lose_map(talk, reply)
        self._state.frames = reply.frames_merged
        if talk.wait_for_map(reply, self._state.finished.frames - 1, self._settings.settle_asks):
            return [self._ask(talk, "decide", stamp_ns)]
        again: list[Output] = [self._ask(talk, "decide", stamp_ns)] if talk.stale else []
        if talk.query is None:
            # The moment it is about is the end of the exploration, in every replay the same.
            stamp_ns = self._state.finished.stamp_ns
        said = self._speaker.conclude(
            talk, reply, stamp_ns, names=self._names(talk), last=not again
        )
        return [*said, *again]

    def _lose_map(self, talk: Talk, reply: Instances) -> list[Output]:
        """The mapper was started again: its empty map is no reason to take anything back.

        Raises:
            Refused: for the operator, where a question is open; else all simply begins anew.
        """
        state = self._state
        frames, state.frames, state.phase = state.frames, 0, "none"
        talk.stale = False
        self.counters["maps_lost"] += 1
        if not any(one.asks for one in state.talks):
            return []
        raise Refused(
            f"the map has {reply.frames_merged} frames and had {frames}: the mapper was started"
            " anew; what was asked stands, new instructions wait for the next exploration",
            episode=state.episode,
        )

    def _is_repeated(self, message: Message, what: str) -> bool:
        repeated = self._repeats.has(message, what)
        self.counters["repeated"] += repeated
        return repeated

    def _names(self, talk: Talk) -> dict[str, str]:
        return {"dialogue_id": self._id_of(talk), "episode": self._state.episode}

    def _id_of(self, talk: Talk) -> str:
        return f"{self._state.episode or UNNAMED_EPISODE}/{talk.number}"
