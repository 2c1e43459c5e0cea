"""Says an instruction on the bus and waits for what comes back."""

from __future__ import annotations

import time
import uuid

from doro_schemas.bus import Bus
from doro_schemas.errors import Refused
from doro_schemas.messages import (
    Answer,
    Instruction,
    InstructionGraph,
    Query,
    Rejected,
    Target,
)
from doro_schemas.messages.base import Message
from doro_schemas.topics import TOPICS

CONFIRM_TIMEOUT_S = 5.0


class Conversation:
    """Keeps what was understood and asked since it was opened.

    Others may talk on the same bus: only what answers this ``person`` is kept.
    """

    def __init__(self, bus: Bus) -> None:
        self._bus = bus
        self.person = f"{bus.name}-{uuid.uuid4().hex[:8]}"
        self.parsed: list[InstructionGraph] = []
        self.queries: list[Query] = []
        self.targets: list[Target] = []
        self.rejected: list[Rejected] = []
        for name in ("instruction_graph", "query", "target", "rejected"):
            bus.subscribe(TOPICS[name], self._heard, late=False)

    def say(self, text: str) -> InstructionGraph:
        """Say an instruction; return what nlu understood of it.

        Raises:
            Refused: the text is refused, or nobody heard it.
        """
        try:
            instruction = Instruction(text=text, person=self.person, stamp_ns=time.time_ns())
        except ValueError as error:
            raise Refused(str(error)) from error
        count, refusals = len(self.parsed), len(self.rejected)
        self._bus.publish(instruction)
        self._bus.run_until(
            time.monotonic() + CONFIRM_TIMEOUT_S,
            lambda: len(self.parsed) > count or len(self.rejected) > refusals,
        )
        if len(self.rejected) > refusals:
            raise Refused(self.rejected[-1].reason)
        if len(self.parsed) == count:
            raise Refused("nobody understood the instruction: is doro-nlu running on this router?")
        return self.parsed[-1]

    def answer(self, text: str, query: Query, timeout_s: float) -> tuple[Query, list[Target]]:
        """Answer a query; return what is said to it, and the targets if it is resolved.

        Raises:
            Refused: the answer is refused, or nobody took it.
        """
        try:
            answer = Answer(
                text=text,
                dialogue_id=query.dialogue_id,
                person=self.person,
                stamp_ns=time.time_ns(),
            )
        except ValueError as error:
            raise Refused(str(error)) from error
        count, refusals = len(self.queries), len(self.rejected)
        targets = len(self._targets_in(query))
        self._bus.publish(answer)
        deadline_s = time.monotonic() + timeout_s
        self._bus.run_until(
            deadline_s,
            lambda: len(self.queries) > count or len(self.rejected) > refusals,
        )
        if len(self.rejected) > refusals:
            raise Refused(self.rejected[-1].reason)
        if len(self.queries) == count:
            raise Refused("nobody took the answer: is doro-dialogue running on this router?")
        reply = self.queries[-1]
        if reply.reason in ("answered", "unique_match"):
            # A target follows each clause's instances on its own key.
            wanted = targets + sum(len(clause.instance_ids) for clause in reply.clauses)
            self._bus.run_until(deadline_s, lambda: len(self._targets_in(query)) >= wanted)
        return reply, self._targets_in(query)[targets:]

    def targets_of(self, query: Query, timeout_s: float) -> list[Target]:
        """Return the targets of a confirmation; none where they do not come in time."""

        def found() -> list[Target]:
            return [one for one in self._targets_in(query) if one.instance_id in query.matches]

        self._bus.run_until(time.monotonic() + timeout_s, lambda: bool(found()))
        return found()

    def _targets_in(self, query: Query) -> list[Target]:
        return [one for one in self.targets if one.dialogue_id == query.dialogue_id]

    def wait_for_query(self, count: int, timeout_s: float) -> Query | None:
        """Return the latest query once there are ``count``; None if they do not come in time."""
        self._bus.run_until(time.monotonic() + timeout_s, lambda: len(self.queries) >= count)
        return self.queries[-1] if len(self.queries) >= count else None

    def _heard(self, message: Message) -> None:
        if isinstance(message, InstructionGraph):
            if message.person == self.person:
                self.parsed.append(message)
        elif isinstance(message, Query):
            if message.person == self.person:
                self.queries.append(message)
        elif isinstance(message, Target):
            self.targets.append(message)
        elif isinstance(message, Rejected):
            self.rejected.append(message)
