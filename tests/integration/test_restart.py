"""The dialogue is killed between question and answer, and nothing is lost."""

from __future__ import annotations

from doro_schemas import codec
from doro_schemas.messages import Answer, Query, Target
from doro_schemas.messages.base import Message
from doro_schemas.topics import TOPICS
from tests.integration.chain import READY_S, Chain


def kill(chain: Chain) -> None:
    """SIGKILL: no handler runs, nothing is flushed."""
    process = chain.processes["dialogue"]
    process.kill()
    process.wait(10)
    assert chain.wait(lambda: "dialogue" not in chain.presence.alive, 10.0)


def kill_and_start(chain: Chain) -> None:
    kill(chain)
    chain.start("dialogue")
    chain.presence.wait_for(["dialogue"], READY_S)


def hear_targets(chain: Chain) -> list[Target]:
    targets: list[Target] = []

    def heard(message: Message) -> None:
        assert isinstance(message, Target)
        targets.append(message)

    chain.bus.subscribe(TOPICS["target"], heard, late=False)
    return targets


def wait_for(chain: Chain, dialogue_id: str, reason: str) -> Query:
    """Wait for a query of a dialogue with a reason."""

    def found() -> list[Query]:
        return [q for q in chain.queries if (q.dialogue_id, q.reason) == (dialogue_id, reason)]

    assert chain.wait(found, 10.0), chain.queries
    return found()[0]


def test_a_kill_between_question_and_answer_loses_nothing() -> None:
    with Chain() as chain:
        targets = hear_targets(chain)
        chain.say("bring me the red cup")
        chain.play()
        query = chain.query(1)
        assert query.state == "INFORM-AMBIGUITY"

        # Two people: the second says something else, before the first has answered.
        chain.say("bring me the white toaster")
        other = chain.query(2)
        assert other.dialogue_id != query.dialogue_id
        assert other.state == "INFORM-MISMATCH"

        kill_and_start(chain)
        second = query.clauses[1]
        words = "the one" + second.text.removeprefix("one red cup")
        chain.bus.publish(Answer(text=words, dialogue_id=query.dialogue_id, stamp_ns=2))
        assert chain.wait(lambda: targets, 10.0), chain.rejected
        assert [targets[0].instance_id] == second.instance_ids
        assert targets[0].dialogue_id == query.dialogue_id
        answered = wait_for(chain, query.dialogue_id, "answered")
        assert (answered.ended, answered.replaces) == ("resolved", query.revision)
        # The instruction came once more to the late joiner and opened no new dialogue; what the
        # kill may have cut off is said again, in the very same bytes.
        assert len({codec.encode(one) for one in chain.queries}) == 3

        # Killed again: the finished one stays finished, the other person's stays open.
        kill_and_start(chain)
        chain.bus.publish(Answer(text="the first", dialogue_id=query.dialogue_id, stamp_ns=3))
        assert "is finished (resolved)" in chain.rejection(1).reason
        chain.bus.publish(Answer(text="the first", dialogue_id="sample/77", stamp_ns=4))
        assert "there is no dialogue 'sample/77'" in chain.rejection(2).reason
        chain.bus.publish(Answer(text="yes", dialogue_id=other.dialogue_id, stamp_ns=5))
        meant = {query.dialogue_id, other.dialogue_id}
        assert chain.wait(lambda: {one.dialogue_id for one in targets} == meant, 10.0)

        # A new instruction is answered from the map that stands.
        chain.say("bring me the blue cup")
        assert chain.wait(lambda: chain.queries[-1].instruction == "bring me the blue cup", 10.0)


def test_a_damaged_state_is_kept_aside_and_the_service_starts_afresh() -> None:
    with Chain() as chain:
        chain.say("bring me the red cup")
        chain.play()
        query = chain.query(1)
        (state,) = chain.state_dir.glob("*.state")
        kill(chain)
        damaged = state.read_bytes()[:200]
        state.write_bytes(damaged)
        chain.start("dialogue")
        assert "starting afresh" in chain.rejection(1).reason
        chain.presence.wait_for(["dialogue"], READY_S)
        (aside,) = chain.state_dir.glob("*.damaged")
        assert aside.read_bytes() == damaged
        # What the bus still holds, the instruction and the end of the exploration, is enough.
        assert codec.encode(chain.query(2)) == codec.encode(query)
        targets = hear_targets(chain)
        chain.bus.publish(Answer(text="the first", dialogue_id=query.dialogue_id, stamp_ns=2))
        assert chain.wait(lambda: targets, 10.0), chain.rejected


def test_a_question_that_nobody_answers_ends_with_a_message() -> None:
    with Chain(settings=["dialogue.timeout_s=2"]) as chain:
        chain.say("bring me the red cup")
        chain.play()
        query = chain.query(1)
        ended = chain.query(2)
        assert isinstance(ended, Query)
        assert (ended.dialogue_id, ended.revision) == (query.dialogue_id, 1)
        assert (ended.reason, ended.ended, ended.replaces) == ("timed_out", "timed_out", 0)
        chain.bus.publish(Answer(text="the first", dialogue_id=query.dialogue_id, stamp_ns=2))
        assert "is finished (timed out)" in chain.rejection(1).reason
