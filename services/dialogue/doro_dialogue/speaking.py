"""What a dialogue says of itself: beliefs, questions and their revisions, its end."""

from __future__ import annotations

import msgspec

from doro_dialogue.early import EARLY_REASONS, EARLY_STATES, is_settled, take_note, withdrawal
from doro_dialogue.settings import DialogueSettings
from doro_dialogue.talk import decide_on, query_of, same_decision, targets_of
from doro_dialogue.talks import Talk
from doro_schemas.effects import Output
from doro_schemas.messages import Instances, Query

LOOKED_FURTHER = "I have looked further. "
NOBODY = "I have not heard from you, so I leave it. Say it again if you still want it."
SPEAKING_COUNTERS = (
    *("beliefs", "queries", "revisions", "early_queries", "withdrawn"),
    *("resolved", "timed_out"),
)


class Speaker:
    """Speaks for all dialogues, and counts what is said so that the last one is known."""

    def __init__(self, settings: DialogueSettings, counters: dict[str, int]) -> None:
        self._settings = settings
        self._counters = counters
        self.spoken = 0

    def speak(self, talk: Talk, query: Query) -> None:
        """Note that a query is published."""
        self.spoken += 1
        talk.query, talk.spoken, talk.waiting_since_ns = query, self.spoken, 0
        talk.targeted = False

    def end(self, talk: Talk, how: str) -> None:
        """Finish a dialogue."""
        talk.ended = how
        self._counters["resolved"] += how == "resolved"

    def believe(
        self, talk: Talk, reply: Instances, stamp_ns: int, *, names: dict[str, str], early: bool
    ) -> list[Output]:
        """Return how the decision stands; raise or change the question early where allowed.

        Args:
            names: ``dialogue_id`` and ``episode``.
            early: the exploration still runs.
        """
        read = decide_on(talk.readings, reply, self._settings)
        self._counters["beliefs"] += 1
        belief = take_note(talk, read, reply, names["dialogue_id"], names["episode"])
        outputs: list[Output] = [msgspec.structs.replace(belief, stamp_ns=stamp_ns)]
        if not early or not is_settled(belief, self._settings):
            return outputs
        if read.decision.state in EARLY_STATES and read.decision.reason in EARLY_REASONS:
            return [*outputs, *self.conclude(talk, reply, stamp_ns, names=names, early=True)]
        if talk.asks and talk.decided is not None:
            self._counters["withdrawn"] += 1
            query = withdrawal(talk, stamp_ns)
            self.speak(talk, query)
            talk.decided = None
            outputs.append(query)
        return outputs

    def conclude(
        self,
        talk: Talk,
        reply: Instances,
        stamp_ns: int,
        *,
        names: dict[str, str],
        early: bool = False,
        last: bool = True,
    ) -> list[Output]:
        """Say what the map's instances come to, if that is news.

        Args:
            last: no newer map has been asked for; only then a target is given.
        """
        read = decide_on(talk.readings, reply, self._settings)
        query = query_of(read, talk.instruction, reply, self._settings, **names)
        before, decided, talk.reply = talk.query, talk.decided, reply
        if decided is not None and same_decision(decided, query):
            return []
        self._counters["queries" if before is None else "revisions"] += 1
        self._counters["early_queries"] += early
        if decided is not None:
            query = msgspec.structs.replace(query, text=LOOKED_FURTHER + query.text)
        replaced, talk.replaced = talk.replaced, False
        if replaced and query.state == "CONFIRM" and last:
            # The person has just named it: nothing is left to ask.
            self.end(talk, "resolved")
        query = talk.follow(query, stamp_ns, ended=talk.ended)
        talk.decided = query = msgspec.structs.replace(query, early=early)
        self.speak(talk, query)
        one = query.state == "CONFIRM" and len(query.matches) == 1
        sure = one and not query.also and not early and last
        talk.targeted = sure and self._settings.target_on_confirm and not talk.ended
        given = talk.ended or talk.targeted
        return [query, *(targets_of(query, query.matches, reply) if given else [])]

    def is_overdue(self, talk: Talk, now_ns: int) -> bool:
        """Tell whether nobody has answered for too long; a question waits from its first tick.

        A clock that was set back starts the wait anew.
        """
        limit_ns = int(self._settings.timeout_s * 1e9)
        if not limit_ns or not talk.asks:
            return False
        if not 0 < talk.waiting_since_ns <= now_ns:
            talk.waiting_since_ns = now_ns
        return now_ns - talk.waiting_since_ns >= limit_ns

    def time_out(self, talk: Talk, now_ns: int) -> list[Output]:
        """End a dialogue that nobody answers, with a message that says so.

        Nobody has to answer a confirmation that gave its target: silence is consent.
        """
        assert talk.query is not None
        if talk.targeted:
            self.end(talk, "resolved")
            return []
        self._counters["timed_out"] += 1
        self.end(talk, "timed_out")
        query = msgspec.structs.replace(
            talk.query, reason="timed_out", text=NOBODY, clauses=[], seen_from=None, also=[]
        )
        query = talk.follow(query, now_ns, ended=talk.ended)
        self.speak(talk, query)
        return [query]
