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

from doro_dialogue.facts import carried_by, check_depth, name_of
from doro_dialogue.settings import DialogueSettings
from doro_dialogue.talk import belief_of, decide_on, query_of, same_decision, targets_of
from doro_dialogue.talks import Pending, Talk
from doro_dialogue.turns import ANSWER_COUNTERS, Turns
from doro_schemas.effects import Ask, Output, Unanswered
from doro_schemas.errors import Refused
from doro_schemas.messages import (
    Answer,
    Exploration,
    GridDelta,
    Instances,
    InstancesRequest,
    InstructionGraph,
    ParseReply,
    ParseRequest,
    Query,
)

MAX_DIALOGUES = 200
UNNAMED_EPISODE = "episode"
COUNTERS = (
    *("instructions", "not_understood", "deltas", "other_episode"),
    *ANSWER_COUNTERS,
    *("asks", "unanswered", "unexpected_replies", "beliefs", "queries", "revisions"),
)


class Dialogue:
    """The core of the dialogue service."""

    def __init__(self, settings: DialogueSettings) -> None:
        self._settings = settings
        self._talks: list[Talk] = []
        self._pending: list[Pending] = []
        self._episode = ""
        self._phase: Literal["none", "started", "finished"] = "none"
        self._finished = Exploration(state="finished")
        self._taken_up = 0
        self._deltas = 0
        self._spoken = 0
        self.counters: dict[str, int] = dict.fromkeys(COUNTERS, 0)
        self._turns = Turns(settings, self.counters)

    def instruction_graph(self, message: InstructionGraph) -> list[Output]:
        """Open a dialogue; after the end of the exploration the map is asked at once.

        Raises:
            Refused: the graph nests too deep, or too many dialogues are open.
        """
        if message.graph is None:
            # nlu has told the operator why; there is nothing to decide.
            self.counters["not_understood"] += 1
            return []
        check_depth(message.graph, f"the instruction '{message.text}'")
        if len(self._talks) >= MAX_DIALOGUES:
            raise Refused(
                f"{MAX_DIALOGUES} instructions are open already and '{message.text}' is not taken:"
                " start a new episode",
                episode=message.episode,
            )
        self.counters["instructions"] += 1
        self._talks.append(Talk(instruction=message, graph=message.graph))
        self._take_up()
        return self._decide_open(message.stamp_ns) if self._phase == "finished" else []

    def exploration(self, message: Exploration) -> list[Output]:
        """Begin an episode, or ask the map for the decision of every waiting instruction."""
        other = message.episode not in ("", self._episode)
        if message.state == "started" or other or self._phase == "none":
            self._begin(message.episode)
        if message.state == "started":
            return []
        self._phase, self._finished = "finished", message
        for talk in self._talks:
            talk.short_replies = 0
            talk.stale = talk.query is not None
        return self._decide_open(message.stamp_ns)

    def grid_delta(self, message: GridDelta) -> list[Output]:
        """Follow the map: a Belief now and then while exploring, a new look after its end.

        A map that was emptied begins the episode as ``started`` does: the two travel on
        different keys, so either may come first.
        """
        if message.reset and (self._phase != "started" or message.episode != self._episode):
            self._begin(message.episode)
        if message.episode not in ("", self._episode) or self._phase == "none":
            self.counters["other_episode"] += 1
            return []
        if message.reset:
            return []
        self.counters["deltas"] += 1
        self._deltas += 1
        if self._phase == "finished":
            for talk in self._talks:
                talk.stale = True
            return self._decide_open(message.stamp_ns)
        if self._deltas % self._settings.belief_every_frames:
            return []
        return [self._ask(talk, "belief", message.stamp_ns) for talk in self._of_episode()]

    def instances(self, message: Instances) -> list[Output]:
        """Take the map's reply: decide the dialogue that asked first for this class.

        Raises:
            Refused: an instance graph nests too deep, or two instances have one id.
        """
        pending = self._take_pending(message.name)
        if pending is None:
            self.counters["unexpected_replies"] += 1
            return []
        try:
            if pending.purpose == "belief":
                return self._believe(pending, message)
            return self._decide(pending, message)
        except Refused as refused:
            # Requests that the shell has not put yet are lost with the refusal.
            self._forget_pending()
            raise Refused(refused.reason, episode=self._episode) from refused

    def answer(self, message: Answer) -> list[Output]:
        """Take what a person answers; its words go to the parser where they describe.

        Raises:
            Refused: no such dialogue, or it is finished, or nothing was asked.
        """
        talk = self._turns.find(message, [t for t in self._talks if t.number > 0], self._id_of)
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
                self._speak(talk, output)
        if talk.replaced and talk.stale and talk.asked == 0:
            return [*outputs, self._ask(talk, "decide", stamp_ns)]
        return outputs

    def _speak(self, talk: Talk, query: Query) -> None:
        self._spoken += 1
        talk.query, talk.spoken = query, self._spoken

    def unanswered(self, message: Unanswered) -> list[Output]:
        """Keep the dialogues waiting; the next delta, exploration or instruction asks again.

        Raises:
            Refused: always, for the operator.
        """
        self.counters["unanswered"] += 1
        if isinstance(message.request, ParseRequest):
            self._turns.forget(message)
        waiting = sum(talk.query is None for talk in self._of_episode())
        self._forget_pending()
        raise Refused(
            f"{message.reason.rstrip('.')}; {waiting} instruction(s) wait for the map"
            " and it is asked again with the next frame, exploration or instruction",
            episode=self._episode,
        )

    def _begin(self, episode: str) -> None:
        """Start an episode: what was decided is over, what waits goes with it."""
        self._episode, self._phase = episode, "started"
        self._taken_up = self._deltas = 0
        self._pending.clear()
        self._talks = [
            Talk(instruction=talk.instruction, graph=talk.graph, number=-1 if talk.number else 0)
            for talk in self._talks
            if talk.query is None or (talk.searching and not talk.ended)
        ]
        self._turns.clear()
        self._take_up()

    def _take_up(self) -> None:
        """Number the instructions that belong to the current episode, in order."""
        if self._phase == "none":
            return
        for talk in self._talks:
            # One that an earlier episode left undecided (-1) goes with the current one.
            named = talk.instruction.episode
            if talk.number < 0 or (talk.number == 0 and named in ("", self._episode)):
                self._taken_up += 1
                talk.number = self._taken_up

    def _of_episode(self) -> list[Talk]:
        return [
            talk
            for talk in self._talks
            if talk.number > 0 and not talk.ended and not talk.searching
        ]

    def _decide_open(self, stamp_ns: int) -> list[Output]:
        """Ask for every dialogue that is undecided or stale and has no request on its way."""
        return [
            self._ask(talk, "decide", stamp_ns)
            for talk in self._of_episode()
            if talk.asked == 0 and (talk.query is None or talk.stale)
        ]

    def _ask(self, talk: Talk, purpose: Literal["decide", "belief"], stamp_ns: int) -> Ask:
        self.counters["asks"] += 1
        if purpose == "decide":
            talk.asked += 1
            talk.stale = False
        self._pending.append(Pending(talk=talk, purpose=purpose, stamp_ns=stamp_ns))
        return Ask(
            InstancesRequest(
                name=talk.graph.name,
                carried=carried_by(talk.graph, *talk.instruction.readings),
                episode=self._episode,
                stamp_ns=stamp_ns,
            )
        )

    def _take_pending(self, name: str) -> Pending | None:
        """Return the oldest request for a class; replies come in the order of requests."""
        for i, pending in enumerate(self._pending):
            if name_of(pending.talk.graph.name) == name_of(name):
                return self._pending.pop(i)
        return None

    def _forget_pending(self) -> None:
        for pending in self._pending:
            if pending.purpose == "decide":
                pending.talk.asked = 0
                pending.talk.stale = True
        self._pending.clear()

    def _believe(self, pending: Pending, reply: Instances) -> list[Output]:
        decision = decide_on(pending.talk.graph, reply, self._settings)
        self.counters["beliefs"] += 1
        belief = belief_of(decision, reply, self._id_of(pending.talk), self._episode)
        return [msgspec.structs.replace(belief, stamp_ns=pending.stamp_ns)]

    def _decide(self, pending: Pending, reply: Instances) -> list[Output]:
        """Publish the first query, or a revised one if the decision changed."""
        talk, stamp_ns = pending.talk, pending.stamp_ns
        talk.asked -= 1
        again: list[Output] = []
        if talk.wait_for_map(reply, self._finished.frames - 1, self._settings.settle_asks):
            return [self._ask(talk, "decide", stamp_ns)]
        if talk.stale:
            again = [self._ask(talk, "decide", stamp_ns)]
        decision = decide_on(talk.graph, reply, self._settings)
        name = self._id_of(talk)
        query = query_of(
            decision,
            talk.instruction,
            reply,
            self._settings,
            dialogue_id=name,
            episode=self._episode,
        )
        before = talk.query
        talk.reply = reply
        if before is None:
            # The moment it is about is the end of the exploration, in every replay the same.
            stamp_ns = self._finished.stamp_ns
            self.counters["queries"] += 1
        elif talk.decided is not None and same_decision(talk.decided, query):
            return again
        else:
            self.counters["revisions"] += 1
        revision = 0 if before is None else before.revision + 1
        query = msgspec.structs.replace(query, stamp_ns=stamp_ns, revision=revision)
        talk.decided = query
        self._speak(talk, query)
        replaced, talk.replaced = talk.replaced, False
        if replaced and query.state == "CONFIRM" and not again:
            # The person has just named it: nothing is left to ask.
            self._turns.end(talk, "resolved")
            return [query, *targets_of(query, query.matches, reply)]
        return [query, *again]

    def _id_of(self, talk: Talk) -> str:
        return f"{self._episode or UNNAMED_EPISODE}/{talk.number}"
