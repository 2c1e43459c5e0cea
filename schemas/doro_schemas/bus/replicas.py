"""Several processes of one service: which of them handles what must be handled once.

Each replica holds a liveliness token whose key ends in the time it started and its session's id.
The oldest one alive leads; when its token vanishes, with a clean stop or with its connection, the
next oldest does. There is no vote and nothing to configure. What arrives between the end of one
leader and the news of it is lost, as it is when a single process restarts.
"""

from __future__ import annotations

import threading
import time
from typing import Any

import zenoh

from doro_schemas.topics import TOPICS

_JOIN_S = 2.0


class Replicas:
    """One process's place among the replicas of its service.

    Args:
        session: the open session.
        service: the service's name.
    """

    def __init__(self, session: zenoh.Session, service: str) -> None:
        topic = TOPICS["replica"]
        self._lock = threading.Lock()
        self.own = f"{time.time_ns():020d}-{session.zid()}"
        self._alive = {self.own}
        liveliness = session.liveliness()
        self._declared: list[Any] = [
            liveliness.declare_token(topic.key_for(service=service, replica=self.own))
        ]
        everyone = topic.key_for(service=service, replica="*")
        self._declared.append(liveliness.declare_subscriber(everyone, self._changed, history=True))
        # The subscriber learns of the others soon; a process that is about to take work must
        # know of them now.
        for reply in liveliness.get(everyone, timeout=_JOIN_S):
            if reply.ok is not None:
                self._changed(reply.ok)

    @property
    def leads(self) -> bool:
        """Whether this process is the one that handles what must be handled once."""
        with self._lock:
            return min(self._alive) == self.own

    def undeclare(self) -> None:
        """Withdraw: the others take over."""
        for item in reversed(self._declared):
            item.undeclare()
        self._declared.clear()

    def _changed(self, sample: zenoh.Sample) -> None:
        replica = str(sample.key_expr).rsplit("/", maxsplit=1)[-1]
        with self._lock:
            if sample.kind == zenoh.SampleKind.PUT:
                self._alive.add(replica)
            elif replica != self.own:
                self._alive.discard(replica)
