"""What a core may ask of its shell besides publishing messages."""

from __future__ import annotations

import msgspec

from doro_schemas.messages.base import Message


class Ask(msgspec.Struct, frozen=True):
    """Put ``request`` to the queryable that takes its type; the reply comes back as a message.

    The shell hands the reply to the core's handler of the reply's type, or, where nobody
    answered in time, to its handler of :class:`Unanswered`.
    """

    request: Message


class Unanswered(Message, kw_only=True):
    """Nobody answered ``request``; ``reason`` says in one sentence what to do."""

    request: Message
    reason: str


Output = Message | Ask
"""What a core's handler returns a list of."""
