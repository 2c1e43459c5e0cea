"""How a topic's delivery becomes Zenoh publishers and subscribers."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import zenoh
import zenoh.ext

from doro_schemas.topics import POLICIES, Topic

HEARTBEAT_S = 0.5
_CONGESTION = {
    "block": zenoh.CongestionControl.BLOCK,
    "block_first": zenoh.CongestionControl.BLOCK_FIRST,
    "drop": zenoh.CongestionControl.DROP,
}
Publisher = zenoh.Publisher | zenoh.ext.AdvancedPublisher


@lru_cache(maxsize=256)
def zenoh_encoding(text: str) -> zenoh.Encoding:
    """Return Zenoh's form of an encoding's text."""
    return zenoh.Encoding(text)


def declare_publisher(session: zenoh.Session, topic: Topic, key: str, *, block: bool) -> Publisher:
    """Declare a publisher by the topic's policy.

    Args:
        block: wait for room instead of dropping, whatever the policy says (replays).
    """
    policy = POLICIES[topic.delivery]
    options: dict[str, Any] = {
        "congestion_control": _CONGESTION["block" if block else policy.congestion],
        "priority": getattr(zenoh.Priority, policy.priority),
        "express": policy.express,
    }
    if not policy.cache:
        return session.declare_publisher(key, **options)
    return zenoh.ext.declare_advanced_publisher(
        session,
        key,
        **options,
        cache=zenoh.ext.CacheConfig(max_samples=policy.cache),
        publisher_detection=True,
        sample_miss_detection=zenoh.ext.MissDetectionConfig(
            heartbeat=HEARTBEAT_S, sporadic_heartbeat=None
        ),
    )


def declare_subscriber(
    session: zenoh.Session,
    topic: Topic,
    arrived: Callable[[zenoh.Sample], None],
    *,
    late: int,
    missed: Callable[[int], None],
) -> list[Any]:
    """Declare a subscriber by the topic's policy; return what must be kept and undeclared.

    A subscriber that is to take nothing from the past is a plain one: an advanced one without
    history counts all that the publisher ever sent as missed at the first heartbeat, and
    fetches the whole cache.

    Args:
        arrived: called on Zenoh's thread; must only hand the sample on.
        late: past samples to take, where the policy keeps any.
        missed: called with the number of samples that were lost for good.
    """
    if not POLICIES[topic.delivery].cache or late == 0:
        return [session.declare_subscriber(topic.pattern, arrived)]
    history = zenoh.ext.HistoryConfig(detect_late_publishers=True, max_samples=late)
    subscriber = zenoh.ext.declare_advanced_subscriber(
        session,
        topic.pattern,
        arrived,
        history=history,
        recovery=zenoh.ext.RecoveryConfig(heartbeat=True, periodic_queries=None),
        subscriber_detection=True,
    )
    return [subscriber, subscriber.sample_miss_listener(lambda miss: missed(miss.nb))]
