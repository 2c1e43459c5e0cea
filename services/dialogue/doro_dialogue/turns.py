"""The turns after the first question: answers in; a target or a narrower question out."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import msgspec

from doro_dialogue.acts import hear
from doro_dialogue.ask_reading import Chosen, choose
from doro_dialogue.facts import name_of
from doro_dialogue.reply import Manner, Said, ask_about, ask_reading_again, reply_to
from doro_dialogue.resolve import Outcome, resolve
from doro_dialogue.scene import Scene, observed_words
from doro_dialogue.settings import DialogueSettings
from doro_dialogue.speaking import Speaker
from doro_dialogue.talk import candidates_of, clauses_of, decide_on, query_of, targets_of
from doro_dialogue.talks import Reading, Talk
from doro_schemas.effects import Ask, Output, Unanswered
from doro_schemas.errors import Refused
from doro_schemas.messages import Answer, Clause, Instances, ParseReply, ParseRequest, Query
from doro_schemas.messages.base import MAX_TEXT_CHARS

ANSWER_COUNTERS = ("answers", "asked_again", "cancelled", "turn_limits")
GIVES_UP = "I still do not know what you mean, so I leave it. Please say it anew."


class Turns:
    """Takes the answers of all dialogues."""

    def __init__(
        self, settings: DialogueSettings, counters: dict[str, int], speaker: Speaker
    ) -> None:
        self._settings = settings
        self._counters = counters
        self._speaker = speaker
        self._readings: list[Reading] = []

    def find(
        self, message: Answer, talks: Sequence[Talk], name_of_talk: Callable[[Talk], str]
    ) -> Talk:
        """Return the dialogue that an answer belongs to: its own, or the one that spoke last.

        Raises:
            Refused: no such dialogue, or it is finished, or nothing was asked.
        """
        if not message.dialogue_id:
            person = message.person
            asked = [one for one in talks if one.asks and person in ("", one.instruction.person)]
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
            why = f"the dialogue '{wanted}' is finished ({_how(talk)}): give a new instruction"
        elif talk.query is None:
            why = f"the dialogue '{wanted}' has asked nothing yet: wait for its query"
        elif not talk.asks:
            why = f"the question of '{wanted}' was withdrawn: wait for its next query"
        else:
            return talk
        raise Refused(why, episode=message.episode)

    def take(self, talk: Talk, message: Answer) -> list[Output]:
        """Hear an answer; what describes goes to the parser first.

        Raises:
            Refused: it is too long to be parsed.
        """
        self._counters["answers"] += 1
        if (chosen := self._chosen(talk, message.text)) is not None:
            return self._read_as(talk, message, chosen)
        heard = hear(message.text, name_of(talk.graph.name), _words(talk))
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

    def waiting(self) -> list[tuple[Talk, Answer]]:
        """Return the answers whose words are at the parser."""
        return [(one.talk, one.answer) for one in self._readings]

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

    def conclude(self, reading: Reading) -> list[Output]:
        """Resolve an answer whose words are read."""
        talk = reading.talk
        if talk.ended or talk.query is None:
            raise Refused(
                f"'{reading.answer.text[:80]}' came after its dialogue was finished"
                f" ({_how(talk)}): give a new instruction"
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
            talk.readings, talk.decided = [outcome.replaced], None
            talk.replaced = talk.stale = True
            return []
        return [self._say(reading, scene, outcome)]

    def _chosen(self, talk: Talk, text: str) -> Chosen | None:
        """Return what an answer to the question for a reading chooses, if that was asked."""
        if talk.query is None or talk.query.reason != "readings" or talk.reply is None:
            return None
        split = decide_on(talk.readings, talk.reply, self._settings).split
        return choose(split, text, _words(talk)) if split is not None else None

    def _read_as(self, talk: Talk, message: Answer, chosen: Chosen) -> list[Output]:
        """Decide by the readings that are left; nothing has to be asked of map or parser."""
        assert talk.reply is not None
        reading = Reading(talk=talk, answer=message, heard=hear("", ""))
        talk.turns += 1
        read = decide_on(talk.readings, talk.reply, self._settings)
        if chosen.how == "again" and read.split is not None:
            said = ask_reading_again(read.split, self._manner(talk))
            return [self._limited(reading, said)]
        if chosen.how == "any":
            scene = _scene(talk)
            talk.readings = talk.readings[:1]
            return [self._limited(reading, ask_about(scene, scene.ids, self._manner(talk)))]
        talk.readings = chosen.readings
        return self._redecided(reading)

    def _redecided(self, reading: Reading) -> list[Output]:
        """Say what the chosen reading comes to: named now, so that a CONFIRM is the target."""
        talk = reading.talk
        before, reply = _query(talk), talk.reply
        assert reply is not None
        read = decide_on(talk.readings, reply, self._settings)
        names = {"dialogue_id": before.dialogue_id, "episode": before.episode}
        query = query_of(read, talk.instruction, reply, self._settings, **names)
        if query.state == "CONFIRM":
            self._speaker.end(talk, "resolved")
        query = talk.follow(query, _stamp(reading), ended=talk.ended)
        talk.decided = query
        return [query, *(targets_of(query, query.matches, reply) if talk.ended else [])]

    def _resolved(self, reading: Reading, scene: Scene, outcome: Outcome) -> list[Output]:
        said = reply_to(scene, outcome, self._manner(reading.talk))
        self._speaker.end(reading.talk, "resolved")
        query = self._query_of(reading, said)
        reply = reading.talk.reply
        return [query, *(targets_of(query, outcome.targets, reply) if reply else [])]

    def _say(self, reading: Reading, scene: Scene, outcome: Outcome) -> Query:
        talk = reading.talk
        said = reply_to(scene, outcome, self._manner(talk))
        if outcome.action == "cancelled":
            self._speaker.end(talk, "cancelled")
            self._counters["cancelled"] += 1
        elif outcome.action == "search_again":
            talk.searching = True
        else:
            return self._limited(reading, said)
        return self._query_of(reading, said)

    def _limited(self, reading: Reading, said: Said) -> Query:
        """Ask again, unless it was asked often enough."""
        if reading.talk.turns >= self._settings.max_turns:
            self._speaker.end(reading.talk, "turn_limit")
            self._counters["turn_limits"] += 1
            said = Said(GIVES_UP, [], said.state, "turn_limit")
        else:
            self._counters["asked_again"] += 1
        return self._query_of(reading, said)

    def _query_of(self, reading: Reading, said: Said) -> Query:
        talk = reading.talk
        instances = talk.reply.instances if talk.reply is not None else []
        query = msgspec.structs.replace(
            _query(talk),
            state=said.state,
            reason=said.reason,
            text=said.text,
            clauses=clauses_of(said.parts, instances, said.seen_from),
            seen_from=said.seen_from,
            also=[],
        )
        return talk.follow(query, _stamp(reading), ended=talk.ended)

    def _manner(self, talk: Talk) -> Manner:
        query = _query(talk)
        key = f"{query.dialogue_id}:{talk.turns}"
        return Manner(self._settings.seed, key, talk.instruction.task, query.unseen_share)


def _query(talk: Talk) -> Query:
    assert talk.query is not None
    return talk.query


def _words(talk: Talk) -> frozenset[str]:
    """Return the words of all that was observed."""
    instances = talk.reply.instances if talk.reply is not None else []
    return frozenset(observed_words([one.graph for one in instances]))


def _stamp(reading: Reading) -> int:
    """Return the answer's stamp; plain text has none and takes the question's."""
    return reading.answer.stamp_ns or _query(reading.talk).stamp_ns


def _scene(talk: Talk) -> Scene:
    """Return what an answer is held against.

    After the question for a reading those are offered that any reading singles out; they
    were not named, and so have no order.
    """
    query = _query(talk)
    reply = talk.reply or Instances(name=talk.graph.name, frames_merged=0, last_frame=-1)
    known = candidates_of(reply)
    groups = list(query.clauses)
    if query.reason == "readings":
        graphs = {one.id: one.graph for one in known}
        groups = [Clause([name], "", graphs[name]) for name in query.matches]
    return Scene(
        said=talk.graph,
        state=query.state,
        text=query.text,
        groups=groups,
        candidates=known,
        ordered=query.reason != "readings",
    )


def _how(talk: Talk) -> str:
    return talk.ended.replace("_", " ")
