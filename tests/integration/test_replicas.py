"""Two nlu processes on one router: every instruction gives one graph, and one may die."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from doro_schemas.messages import (
    CaptionedBox,
    FrameCaptions,
    FrameGraphs,
    Health,
    Instruction,
    InstructionGraph,
    ParseReply,
    ParseRequest,
    Rejected,
)
from doro_schemas.topics import TOPICS
from tests.integration.chain import Chain

LEADER, STANDBY = "nlu", "nlu-2"
WAIT_S = 30.0


class Ear:
    """What the two publish."""

    def __init__(self, chain: Chain) -> None:
        self.chain = chain
        self.graphs: list[InstructionGraph] = []
        self.frames: list[FrameGraphs] = []
        self.health: list[Health] = []
        self.tokens: list[tuple[str, bool]] = []
        self.alive: list[bool] = []
        for name, target in (
            ("instruction_graph", self.graphs),
            ("graphs", self.frames),
            ("health", self.health),
        ):
            chain.bus.subscribe(TOPICS[name], target.append, late=False)  # type: ignore[attr-defined]
        chain.bus.watch_alive(lambda _service, alive: self.alive.append(alive))
        self._watch = chain.bus.session.liveliness().declare_subscriber(
            TOPICS["replica"].pattern, self._token, history=True
        )

    def _token(self, sample: Any) -> None:
        self.tokens.append((str(sample.key_expr), "PUT" in str(sample.kind)))

    def younger(self) -> list[Health]:
        """Return the health of the process that started second."""
        oldest = self.health[0]
        return [
            one
            for one in self.health
            if one.uptime_s < (one.stamp_ns - oldest.stamp_ns) / 1e9 + oldest.uptime_s - 0.2
        ]

    def wait(self, done: Any) -> None:
        assert self.chain.wait(done, WAIT_S), (self.tokens, self.graphs, self.health[-2:])


@pytest.fixture(scope="module")
def ear() -> Iterator[Ear]:
    with Chain(("nlu",)) as chain:
        ear = Ear(chain)
        ear.wait(lambda: ear.health)
        first = chain.processes[LEADER]
        chain.start(LEADER)
        chain.processes[STANDBY], chain.processes[LEADER] = chain.processes[LEADER], first
        ear.wait(ear.younger)
        yield ear


def test_both_answer_the_parser_and_one_publishes(ear: Ear) -> None:
    for number in range(5):
        ear.chain.bus.publish(Instruction(text=f"bring the red cup {number}", stamp_ns=number + 1))
        reply = ear.chain.bus.ask(ParseRequest(text="find the bed"))
        assert isinstance(reply, ParseReply)
        assert reply.graph is not None
    box = CaptionedBox([1.0, 1.0, 9.0, 9.0], 0.5, "a cup")
    frame = FrameCaptions(frame=0, height_px=30, width_px=40, detections=[box])
    ear.chain.bus.publish(frame)
    # The second one has seen them all, and kept still.
    ear.wait(lambda: any(one.counters.get("standby.captions") == 1 for one in ear.younger()))
    last = ear.younger()[-1]
    assert last.counters["standby.instruction"] == 5
    assert "published.instruction_graph" not in last.counters
    ear.wait(lambda: len(ear.graphs) >= 5 and ear.frames)
    assert [graph.stamp_ns for graph in ear.graphs] == [1, 2, 3, 4, 5]
    assert len(ear.frames) == 1


def test_invalid_utf8_is_refused_and_the_next_instruction_works(ear: Ear) -> None:
    ear.graphs.clear()
    before = len(ear.chain.rejected)
    for payload in (b"bring \xff\xfe cup", b"\xed\xa0\x80", b"cup \xc3"):
        ear.chain.bus.put_raw(TOPICS["instruction"], TOPICS["instruction"].key, payload, "")
        ear.chain.bus.publish(Instruction(text="bring the cup", stamp_ns=77))
    ear.wait(lambda: len(ear.graphs) >= 3)
    assert [graph.stamp_ns for graph in ear.graphs] == [77, 77, 77]
    ear.wait(lambda: len(ear.chain.rejected) >= before + 3)
    ear.wait(lambda: any(one.counters.get("standby.instruction") == 11 for one in ear.younger()))
    refused: list[Rejected] = ear.chain.rejected[before:]
    assert len(refused) == 3
    assert all("plain text must be UTF-8" in one.reason for one in refused)


def test_when_the_leader_is_killed_the_other_takes_over(ear: Ear) -> None:
    ear.graphs.clear()
    process = ear.chain.processes.pop(LEADER)
    process.kill()
    process.wait(10)
    ear.wait(lambda: [kept for _, kept in ear.tokens].count(False) == 1)
    ear.chain.bus.publish(Instruction(text="bring the green cup", stamp_ns=9))
    ear.wait(lambda: ear.graphs)
    assert [graph.stamp_ns for graph in ear.graphs] == [9]
    assert isinstance(ear.chain.bus.ask(ParseRequest(text="find the bed")), ParseReply)
    assert ear.alive == [True], "the service was alive all the time"
