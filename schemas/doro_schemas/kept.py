"""What a shell keeps beside the messages: the core's state over restarts, and what is due."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import msgpack

from doro_schemas import codec
from doro_schemas.effects import Output
from doro_schemas.errors import Refused
from doro_schemas.messages.base import Message
from doro_schemas.statefile import StateFile


class Kept:
    """A core's state on disk, with what it said and the bus may not have taken yet.

    The state is written with the messages that follow from it before they are published, and
    without them afterwards. So a process that is killed in between says them again: what is
    said may come twice, never not at all.
    """

    def __init__(self, file: StateFile, snapshot: Callable[[], bytes]) -> None:
        self._file = file
        self._snapshot = snapshot
        self._quiet = True

    def save(self, outputs: Sequence[Output]) -> None:
        """Write the state and the messages to be published; one refusal until it works again.

        Args:
            outputs: what is about to be published; requests are not kept, the core knows them.
        """
        said = [
            (codec.encoding_of(type(one)), codec.encode(one))
            for one in outputs
            if isinstance(one, Message)
        ]
        state = msgpack.packb([self._snapshot(), said])
        try:
            self._file.save(state)
        except Refused:
            if self._quiet:
                self._quiet = False
                raise
        else:
            self._quiet = True

    def sync(self) -> None:
        """Wait until the disk has what was saved, so that it outlives a loss of power.

        Raises:
            Refused: the disk does not take it.
        """
        self._file.sync()

    def load(self, restore: Callable[[bytes], list[Output]]) -> list[Output]:
        """Give the kept state back to the core; return what is to be said and asked first.

        Raises:
            Refused: the file is of no use; it was kept aside and the core starts afresh.
        """
        content = self._file.load()
        if content is None:
            return []
        try:
            state, said = msgpack.unpackb(content, raw=False)
            again = [codec.decode(payload, encoding) for encoding, payload in said]
            return [*again, *restore(state)]
        except (ValueError, TypeError) as error:
            raise self._file.set_aside(f"its content does not fit: {error}") from error


class Due:
    """Something to be done every so often.

    Args:
        period_s: seconds between two calls; the first comes after one period.
        now_s: time of the declaration, on the clock that :meth:`take` is given.
    """

    def __init__(
        self, period_s: float, handler: Callable[[int], list[Output]], now_s: float
    ) -> None:
        self.handler = handler
        self._period_s = period_s
        self.next_s = now_s + period_s

    def take(self, now_s: float) -> bool:
        """Tell whether it is due, once for each period; periods that were missed are skipped."""
        if now_s < self.next_s:
            return False
        missed = int((now_s - self.next_s) / self._period_s)
        self.next_s += (missed + 1) * self._period_s
        return True
