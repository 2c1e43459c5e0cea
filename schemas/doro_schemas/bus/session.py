"""A session on the bus: publish, subscribe, ask and answer by the topic table's policies."""

from __future__ import annotations

import contextlib
import queue
import signal
import threading
import time
from collections import Counter
from collections.abc import Callable
from types import TracebackType
from typing import Any, Self

import zenoh

from doro_schemas import codec
from doro_schemas.bus.config import BusSettings
from doro_schemas.bus.inbox import Inbox, Lane
from doro_schemas.bus.links import Publisher, declare_publisher, declare_subscriber, zenoh_encoding
from doro_schemas.bus.replicas import Replicas
from doro_schemas.bus.router import open_session
from doro_schemas.bus.samples import RawSample, Request, decode_request, decode_sample
from doro_schemas.bus.shared import SharedBuffers
from doro_schemas.errors import Refused
from doro_schemas.messages.base import Message
from doro_schemas.messages.control import Rejected
from doro_schemas.topics import POLICIES, TOPICS, Delivery, Topic, topic_of


class Bus:
    """One process's connection.

    Everything that arrives is handled on the thread that calls :meth:`run` or
    :meth:`run_until`, one item after the other, in order of arrival. What does not fit is
    counted, published on the topic ``rejected`` and forgotten; the bus goes on.

    Args:
        name: the service's name, in liveliness, health and rejections.
        settings: endpoint, namespace and timeouts.
    """

    def __init__(self, name: str, settings: BusSettings | None = None) -> None:
        self.name = name
        self.settings = settings or BusSettings()
        self.counters: Counter[str] = Counter()
        self.last_rejection = ""
        self._inbox = Inbox()
        self._session: zenoh.Session | None = None
        self._publishers: dict[tuple[str, bool], Publisher] = {}
        self._declared: list[Any] = []
        self._stopping = threading.Event()
        self._replicas: Replicas | None = None
        self._shared = SharedBuffers(self.settings.shared_memory_mb << 20)

    def __enter__(self) -> Self:
        self.open()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    @property
    def session(self) -> zenoh.Session:
        """The open Zenoh session."""
        if self._session is None:
            raise RuntimeError("the bus is not open")
        return self._session

    @property
    def stopping(self) -> bool:
        """Whether :meth:`stop` was called."""
        return self._stopping.is_set()

    def open(self) -> None:
        """Connect to the router; see :func:`open_session` for what it refuses."""
        self._session = open_session(self.settings, self._stopping.is_set)

    def close(self) -> None:
        """Withdraw everything and close; what was put before is flushed."""
        for item in reversed(self._declared):
            with contextlib.suppress(zenoh.ZError):
                item.undeclare()
        self._declared.clear()
        self._publishers.clear()
        if self._session is not None:
            self._session.close()  # type: ignore[no-untyped-call]
            self._session = None

    def stop(self) -> None:
        """End :meth:`run` (any thread, signal handlers included)."""
        self._stopping.set()
        self._inbox.stop()

    def stop_on_signals(self) -> None:
        """Stop cleanly on SIGTERM and SIGINT."""
        for number in (signal.SIGTERM, signal.SIGINT):
            signal.signal(number, lambda *_: self.stop())

    # -- publish and subscribe ------------------------------------------------------------

    def publish(self, message: Message, *, lossless: bool = False) -> None:
        """Send a message on its topic; with ``lossless`` a frame waits instead of being dropped."""
        topic = topic_of(type(message))
        key = topic.key_for(camera=getattr(message, "camera", ""), service=self.name)
        payload = codec.encode(message)
        self.put_raw(topic, key, payload, codec.encoding_of(type(message)), lossless=lossless)

    def put_raw(
        self, topic: Topic, key: str, payload: bytes, encoding: str, *, lossless: bool = True
    ) -> None:
        """Send bytes that are already encoded, as a recording holds them."""
        self.publisher(topic, key, lossless=lossless).put(
            self._shared.place(payload), encoding=zenoh_encoding(encoding)
        )
        self.counters[f"published.{topic.name}"] += 1

    def publisher(self, topic: Topic, key: str, *, lossless: bool = False) -> Publisher:
        """Return the publisher of a key, declared at its first use."""
        name = (key, lossless and topic.delivery is Delivery.FRAME)
        if name not in self._publishers:
            self._publishers[name] = declare_publisher(self.session, topic, key, block=name[1])
            self._declared.append(self._publishers[name])
        return self._publishers[name]

    def subscribe(
        self,
        topic: Topic,
        handler: Callable[[Message], None],
        *,
        late: bool = True,
        by_one: bool = False,
        newest: bool = False,
    ) -> None:
        """Receive a topic's validated messages.

        Args:
            handler: called on the bus's thread; may raise Refused.
            late: take the past samples that the table grants to late joiners.
            by_one: only the leading replica of the service handles them (see :class:`Replicas`);
                the others count them as ``standby``.
            newest: of samples that may be dropped only the newest waits; the table's queue else.
        """
        if by_one and self._replicas is None:
            self._replicas = Replicas(self.session, self.name)
            self._declared.append(self._replicas)

        def handle(sample: zenoh.Sample) -> None:
            if by_one and self._replicas is not None and not self._replicas.leads:
                self.counters[f"standby.{topic.name}"] += 1
                return
            payload = sample.payload.to_bytes()
            self.counters[f"received.{topic.name}"] += 1
            try:
                handler(decode_sample(topic, payload, str(sample.encoding)))
            except Refused as refused:
                self.reject(str(sample.key_expr), refused, size_bytes=len(payload))

        self._subscribe(topic, handle, topic.late if late else 0, newest)

    def subscribe_raw(self, topic: Topic, handler: Callable[[RawSample], None]) -> None:
        """Receive a topic's samples as they come, past ones not included (for a recorder)."""

        def handle(sample: zenoh.Sample) -> None:
            key, encoding = str(sample.key_expr), str(sample.encoding)
            handler(RawSample(key, sample.payload.to_bytes(), encoding))

        self._subscribe(topic, handle, 0)

    def _subscribe(
        self, topic: Topic, handle: Callable[[zenoh.Sample], None], late: int, newest: bool = False
    ) -> None:
        lane = Lane(
            1 if newest else POLICIES[topic.delivery].queue,
            handle,
            lambda: self.counters.update([f"dropped.{topic.name}"]),
        )

        def arrived(sample: zenoh.Sample) -> None:
            droppable = sample.congestion_control != zenoh.CongestionControl.BLOCK
            self._inbox.put(lane, sample, droppable=droppable)

        def missed(count: int) -> None:
            self.counters[f"missed.{topic.name}"] += count

        self._declared += declare_subscriber(self.session, topic, arrived, late=late, missed=missed)

    # -- ask and answer -------------------------------------------------------------------

    def answer(self, topic: Topic, handler: Callable[[Request], None]) -> None:
        """Serve a queryable; the handler replies, or raises Refused."""

        def handle(query: zenoh.Query) -> None:
            self.counters[f"received.{topic.name}"] += 1
            payload = b"" if query.payload is None else query.payload.to_bytes()
            try:
                handler(Request(decode_request(topic, query, payload), query))
            except Refused as refused:
                Request(Message(), query).refuse(refused.reason)
                self.reject(topic.key, refused, size_bytes=len(payload))

        lane = Lane(0, handle, _nothing)
        self._declared.append(
            self.session.declare_queryable(
                topic.key, lambda query: self._inbox.put(lane, query), complete=True
            )
        )

    def ask(self, request: Message, timeout_s: float | None = None) -> Message | None:
        """Return the first answer to a request; None where nobody answered in time.

        Raises:
            Refused: the other side refused the request, or its answer does not fit.
        """
        topic = topic_of(type(request))
        replies = self.session.get(
            topic.key,
            payload=codec.encode(request),
            encoding=codec.encoding_of(type(request)),
            timeout=timeout_s or self.settings.ask_timeout_s,
        )
        refusal = ""
        for reply in replies:
            if reply.ok is not None:
                answer, encoding = reply.ok.payload.to_bytes(), str(reply.ok.encoding)
                return codec.decode(answer, encoding, topic.messages[1:])
            if reply.err is not None:
                refusal = reply.err.payload.to_bytes().decode("utf-8", "replace")
        if refusal and refusal.lower() != "timeout":
            raise Refused(refusal)
        return None

    # -- liveliness and refusals ----------------------------------------------------------

    def declare_alive(self) -> None:
        """Announce that the service is ready; the token vanishes with the process."""
        key = TOPICS["alive"].key_for(service=self.name)
        self._declared.append(self.session.liveliness().declare_token(key))

    def watch_alive(self, handler: Callable[[str, bool], None]) -> None:
        """Call ``handler(service, is_alive)`` for every service now and at each change."""

        def changed(sample: zenoh.Sample) -> None:
            service = str(sample.key_expr).split("/")[-2]
            handler(service, sample.kind == zenoh.SampleKind.PUT)

        lane = Lane(0, changed, _nothing)
        self._declared.append(
            self.session.liveliness().declare_subscriber(
                TOPICS["alive"].pattern, lambda sample: self._inbox.put(lane, sample), history=True
            )
        )

    def reject(self, key: str, refused: Refused, *, size_bytes: int = 0) -> None:
        """Count a refusal and publish it."""
        self.counters["rejected"] += 1
        self.last_rejection = refused.reason
        self.publish(
            Rejected(
                service=self.name,
                key=key,
                reason=refused.reason,
                episode=refused.episode,
                frame=refused.frame,
                size_bytes=size_bytes,
                stamp_ns=time.time_ns(),
            )
        )

    # -- the loop -------------------------------------------------------------------------

    def run_until(self, deadline_s: float | None, done: Callable[[], bool] = lambda: False) -> bool:
        """Handle what arrives until ``done()``, :meth:`stop`, or the deadline.

        Args:
            deadline_s: on ``time.monotonic``'s clock; None waits for ever.
            done: looked at before and after every item.

        Returns:
            True where ``done()`` ended it.
        """
        while not self.stopping:
            if done():
                return True
            left_s = None if deadline_s is None else deadline_s - time.monotonic()
            if left_s is not None and left_s <= 0:
                return False
            try:
                taken = self._inbox.take(left_s)
            except queue.Empty:
                return False
            if taken is not None:
                lane, item = taken
                lane.handle(item)
        return done()

    def drain(self, limit_s: float = 5.0, *, quiet_s: float = 0.0) -> None:
        """Handle what arrives until nothing came for ``quiet_s``, also after :meth:`stop`."""
        deadline_s = time.monotonic() + limit_s
        while time.monotonic() < deadline_s:
            try:
                taken = self._inbox.take(quiet_s)
            except queue.Empty:
                return
            if taken is not None:
                lane, item = taken
                lane.handle(item)


def _nothing() -> None:
    return None
