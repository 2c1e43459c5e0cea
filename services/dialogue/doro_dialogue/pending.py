"""Requests to the map that are on their way, and messages that come once more."""

from __future__ import annotations

from typing import Literal

import msgspec

from doro_dialogue.facts import carried_by, name_of
from doro_dialogue.talks import Talk
from doro_schemas.effects import Ask
from doro_schemas.messages import InstancesRequest
from doro_schemas.messages.base import Message


class Pending(msgspec.Struct, kw_only=True):
    """A request on its way: for which dialogue, for what, and the stamp of its cause."""

    talk: Talk
    purpose: Literal["decide", "belief"]
    stamp_ns: int


class Requests:
    """The requests on their way, oldest first."""

    def __init__(self) -> None:
        self._pending: list[Pending] = []

    def ask(
        self, talk: Talk, purpose: Literal["decide", "belief"], stamp_ns: int, episode: str
    ) -> Ask:
        """Return the request for a dialogue's class, and remember it."""
        if purpose == "decide":
            talk.asked += 1
            talk.stale = False
        self._pending.append(Pending(talk=talk, purpose=purpose, stamp_ns=stamp_ns))
        return Ask(
            InstancesRequest(
                name=talk.graph.name,
                carried=carried_by(*talk.readings),
                episode=episode,
                stamp_ns=stamp_ns,
            )
        )

    def take(self, name: str) -> Pending | None:
        """Return the oldest request for a class; replies come in the order of requests."""
        for i, pending in enumerate(self._pending):
            if name_of(pending.talk.graph.name) == name_of(name):
                return self._pending.pop(i)
        return None

    def forget(self) -> None:
        """Nobody will answer them: their dialogues are to be decided anew."""
        for pending in self._pending:
            if pending.purpose == "decide":
                pending.talk.asked = 0
                pending.talk.stale = True
        self._pending.clear()

    def clear(self) -> None:
        """Their dialogues are over."""
        self._pending.clear()


class Repeats:
    """Knows what was handled before a restart and comes once more.

    A late joiner gets the latest message of a key again. Only the first of its type after a
    restart can be that, so that a person who says the same twice is heard twice.
    """

    def __init__(self, latest: dict[str, str] | None = None) -> None:
        self.latest = latest or {}
        self._expected = dict(self.latest)

    def has(self, message: Message, what: str) -> bool:
        """Note a message; tell whether it is the latest one from before the restart."""
        kind = type(message).__name__
        name = f"{message.episode}|{message.stamp_ns}|{what}"
        self.latest[kind] = name
        return self._expected.pop(kind, None) == name
