"""What waits for the service's one thread: bounded where samples may be dropped."""

from __future__ import annotations

import queue
from collections import deque
from collections.abc import Callable
from typing import Any


class Lane:
    """Waiting items of one subscription.

    Args:
        limit: droppable items that may wait; the oldest goes first. 0 = no limit.
        dropped: called for every item that is dropped.
    """

    def __init__(self, limit: int, handle: Callable[[Any], None], dropped: Callable[[], None]):
        self.handle = handle
        self._limit = limit
        self._dropped = dropped
        self._items: deque[Any] = deque()

    def push(self, item: Any, *, droppable: bool) -> bool:
        """Add an item; return False where an older one left, so that no token is needed."""
        fresh = True
        if droppable and self._limit and len(self._items) >= self._limit:
            self._items.popleft()
            self._dropped()
            fresh = False
        self._items.append(item)
        return fresh

    def pop(self) -> Any:
        return self._items.popleft()


class Inbox:
    """Hands items from Zenoh's threads to the one thread of the service, in order of arrival."""

    def __init__(self) -> None:
        self._tokens: queue.SimpleQueue[Lane | None] = queue.SimpleQueue()

    def put(self, lane: Lane, item: Any, *, droppable: bool = False) -> None:
        """Queue an item (any thread)."""
        if lane.push(item, droppable=droppable):
            self._tokens.put(lane)

    def stop(self) -> None:
        """Let :meth:`take` return None (any thread, signal handlers included)."""
        self._tokens.put(None)

    def take(self, timeout_s: float | None = None) -> tuple[Lane, Any] | None:
        """Return the next item; None for a stop.

        Raises:
            queue.Empty: nothing came in time.
        """
        lane = self._tokens.get(timeout=timeout_s)
        return None if lane is None else (lane, lane.pop())
