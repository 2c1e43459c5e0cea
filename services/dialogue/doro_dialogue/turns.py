"""The turns after the first question: answers in; a target or a narrower question out."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import msgspec

from doro_dialogue.acts import hear
from doro_dialogue.facts import Candidate, name_of
from doro_dialogue.reply import Manner, Said, reply_to
from doro_dialogue.resolve import Outcome, resolve
from doro_dialogue.scene import Scene
from doro_dialogue.settings import DialogueSettings
from doro_dialogue.talk import clauses_of, targets_of
from doro_dialogue.talks import Reading, Talk
from doro_schemas.effects import Ask, Output, Unanswered
from doro_schemas.errors import Refused
from doro_schemas.messages import Answer, Instances, ParseReply, ParseRequest, Query
from doro_schemas.messages.base import MAX_TEXT_CHARS

ANSWER_COUNTERS = ("answers", "resolved", "asked_again", "cancelled", "turn_limits")
GIVES_UP = "I still do not know what you mean, so I leave it. Please say it anew."


class Turns:
    """Takes the answers of all dialogues."""

    def __init__(self, settings: DialogueSettings, counters: dict[str, int]) -> None:
        self._settings = settings
        self._counters = counters
        self._readings: list[Reading] = []

    def find(
        self, message: Answer, talks: Sequence[Talk], name_of_talk: Callable[[Talk], str]
    ) -> Talk:
        """Return the dialogue that an answer belongs to: its own, or the one that spoke last.

        Raises:
            Refused: no such dialogue, or it is finished, or nothing was asked.
        """
        if not message.dialogue_id:
            asked = [one for one in talks if one.query is not None and not one.ended]
            if asked:
                return max(asked, key=lambda one: one.spoken)
            raise Refused(
                f"nothing was asked that '{message.text[:80]}' could answer:"
                " give an instruction first",
                episode=message.episode,
            )
        wanted = message.dialogue_id
        talk = next((one for one in talks if name_of_talk(one) == wanted), None)
        if talk is None:
            why = f"there is no dialogue '{wanted}': answer with the dialogue_id of a query"
        elif talk.ended:
            why = f"the dialogue '{wanted}' is finished ({talk.ended}): give a new instruction"
        elif talk.query is None:
            why = f"the dialogue '{wanted}' has asked nothing yet: wait for its query"
        else:
            return talk
        raise Refused(why, episode=message.episode)

    def take(self, talk: Talk, message: Answer) -> list[Output]:
        """Hear an answer; what describes goes to the parser first.

        Raises:
            Refused: it is too long to be parsed.
        """
        self._counters["answers"] += 1
        heard = hear(message.text, name_of(talk.graph.name))
        if any(len(text) > MAX_TEXT_CHARS for text in heard.texts):
            raise Refused(
                f"the answer has {len(message.text)} characters and is not taken:"
                " say it in a sentence",
                episode=message.episode,
            )
        reading = Reading(talk=talk, answer=message, heard=heard, graphs={})
        texts = list(dict.fromkeys(heard.texts))
        if not texts:
            return self.conclude(reading)
        self._readings.append(reading)
        stamp_ns, episode = _stamp(reading), _query(talk).episode
        return [Ask(ParseRequest(text=text, stamp_ns=stamp_ns, episode=episode)) for text in texts]

    def read(self, message: ParseReply) -> Reading | None:
        """Note the parser's graph; return the answer that has all of its graphs now."""
        for i, reading in enumerate(self._readings):
            if message.text in reading.heard.texts and message.text not in reading.graphs:
                reading.graphs[message.text] = message.graph
                done = set(reading.heard.texts) <= set(reading.graphs)
                return self._readings.pop(i) if done else None
        return None

    def forget(self, message: Unanswered) -> None:
        """Drop the answers that wait for the parser.

        Raises:
            Refused: always, for the operator.
        """
        lost = [f"'{one.answer.text[:80]}'" for one in self._readings]
        self._readings.clear()
        raise Refused(
            f"{message.reason.rstrip('.')}; the answer {', '.join(lost)} is lost, say it again",
            episode=message.episode,
        )

    def clear(self) -> None:
        """Forget the answers of an episode that is over."""
        self._readings.clear()

    def end(self, talk: Talk, how: str) -> None:
        """Finish a dialogue."""
        talk.ended = how
        self._counters["resolved"] += how == "resolved"

    def conclude(self, reading: Reading) -> list[Output]:
        """Resolve an answer whose words are read."""
        talk = reading.talk
        if talk.ended or talk.query is None:
            raise Refused(
                f"'{reading.answer.text[:80]}' came after its dialogue was finished"
                f" ({talk.ended}): give a new instruction"
            )
        scene = _scene(talk)
        outcome = resolve(scene, reading.heard, reading.graphs)
        talk.turns += 1
        if outcome.targets:
            return self._resolved(reading, scene, outcome)
        if outcome.replaced is not None and talk.turns < self._settings.max_turns:
            talk.instruction = msgspec.structs.replace(
                talk.instruction, text=reading.answer.text, graph=outcome.replaced
            )
            talk.graph, talk.decided = outcome.replaced, None
            talk.replaced = talk.stale = True
            return []
        return [self._say(reading, scene, outcome)]

    def _resolved(self, reading: Reading, scene: Scene, outcome: Outcome) -> list[Output]:
        query = self._query_of(reading, reply_to(scene, outcome, self._manner(reading.talk)))
        self.end(reading.talk, "resolved")
        reply = reading.talk.reply
        return [query, *(targets_of(query, outcome.targets, reply) if reply else [])]

    def _say(self, reading: Reading, scene: Scene, outcome: Outcome) -> Query:
        talk = reading.talk
        said = reply_to(scene, outcome, self._manner(talk))
        if outcome.action == "cancelled":
            self.end(talk, "cancelled")
            self._counters["cancelled"] += 1
        elif outcome.action == "search_again":
            talk.searching = True
        elif talk.turns >= self._settings.max_turns:
            self.end(talk, "turn limit")
            self._counters["turn_limits"] += 1
            said = Said(GIVES_UP, [], scene.state, "turn_limit")
        else:
            self._counters["asked_again"] += 1
        return self._query_of(reading, said)

    def _query_of(self, reading: Reading, said: Said) -> Query:
        before = _query(reading.talk)
        reply = reading.talk.reply
        instances = reply.instances if reply is not None else []
        return msgspec.structs.replace(
            before,
            stamp_ns=_stamp(reading),
            revision=before.revision + 1,
            state=said.state,
            reason=said.reason,
            text=said.text,
            clauses=clauses_of(said.parts, instances),
        )

    def _manner(self, talk: Talk) -> Manner:
        query = _query(talk)
        key = f"{query.dialogue_id}:{talk.turns}"
        return Manner(self._settings.seed, key, talk.instruction.task, query.unseen_share)


def _query(talk: Talk) -> Query:
    assert talk.query is not None
    return talk.query


def _stamp(reading: Reading) -> int:
    """Return the answer's stamp; plain text has none and takes the question's."""
    return reading.answer.stamp_ns or _query(reading.talk).stamp_ns


def _scene(talk: Talk) -> Scene:
    query = _query(talk)
    reply = talk.reply or Instances(name=talk.graph.name, frames_merged=0, last_frame=-1)
    return Scene(
        said=talk.graph,
        state=query.state,
        text=query.text,
        groups=list(query.clauses),
        candidates=[Candidate(one.instance_id, one.graph) for one in reply.instances],
    )
