"""The sample twenty times, in fresh and in running services, started in any order."""

from __future__ import annotations

import msgpack

from doro_schemas import codec
from tests.integration.chain import Chain

INSTRUCTION = "bring me the red cup"
ORDERS = (
    ("router", "nlu", "perception", "mapper", "dialogue"),
    ("dialogue", "mapper", "perception", "nlu", "router"),
    ("mapper", "router", "dialogue", "nlu", "perception"),
    ("perception", "dialogue", "nlu", "router", "mapper"),
)
PLAYS_PER_ORDER = 5


def test_twenty_replays_give_the_same_bytes() -> None:
    payloads: dict[bytes, str] = {}
    digests = set()
    for order in ORDERS:
        with Chain(order) as chain:
            for play in range(1, PLAYS_PER_ORDER + 1):
                if play == 1:
                    chain.say(INSTRUCTION)  # waits for the end of the exploration
                report = chain.play()
                assert report.merged == report.frames == 72
                if play > 1:
                    chain.say(INSTRUCTION)  # is answered from the map that stands
                payloads.setdefault(codec.encode(chain.query(play)), f"{order} play {play}")
                digests.add(chain.digest())
            assert chain.rejected == []
    assert len(payloads) == 1, _difference(payloads)
    assert len(digests) == 1


def _difference(payloads: dict[bytes, str]) -> str:
    """Say in which fields the queries differ, and where each was first seen."""
    fields = {where: msgpack.unpackb(payload) for payload, where in payloads.items()}
    names = next(iter(fields.values()))
    different = [
        name for name in names if len({repr(query[name]) for query in fields.values()}) > 1
    ]
    return "\n".join(
        f"{where}: {name} = {query[name]!r}"
        for where, query in fields.items()
        for name in different
    )
