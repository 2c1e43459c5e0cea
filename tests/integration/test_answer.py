"""Through the bus: instruction -> query -> answer -> target, with real processes."""

from __future__ import annotations

import io
import json
import subprocess

from doro_console.chat import run_chat
from doro_console.conversation import Conversation
from doro_schemas.bus import Bus
from doro_schemas.messages import Answer, Target
from doro_schemas.messages.base import Message
from doro_schemas.topics import TOPICS
from tests.integration.chain import BIN, Chain


def test_instruction_query_answer_target(capsys) -> None:  # type: ignore[no-untyped-def]
    with Chain() as chain:
        targets: list[Target] = []

        def heard(message: Message) -> None:
            assert isinstance(message, Target)
            targets.append(message)

        chain.bus.subscribe(TOPICS["target"], heard, late=False)
        chain.say("bring me the red cup")
        chain.play()
        query = chain.query(1)
        assert query.state == "INFORM-AMBIGUITY"
        assert [len(clause.instance_ids) for clause in query.clauses] == [1, 1]

        # Nobody can tell from "yes" (plain text, as any tool puts it): asked again.
        chain.bus.session.put(TOPICS["answer"].key, b"yes")
        again = chain.query(2)
        assert (again.dialogue_id, again.revision) == (query.dialogue_id, 1)
        assert again.reason == "ask_again"

        # The words of the second clause mean its instance.
        words = "the one" + query.clauses[1].text.removeprefix("one red cup")
        chain.bus.publish(Answer(text=words, dialogue_id=query.dialogue_id, stamp_ns=2))
        assert chain.wait(lambda: targets, 10.0)
        assert [targets[0].instance_id] == query.clauses[1].instance_ids
        assert targets[0].dialogue_id == query.dialogue_id
        assert targets[0].graph.attributes["color"] == "red"
        assert len(targets[0].position_m) == len(targets[0].extent_m) == 3
        assert chain.query(3).reason == "answered"

        # Finished is finished.
        chain.bus.publish(Answer(text="the other one", dialogue_id=query.dialogue_id, stamp_ns=3))
        assert f"'{query.dialogue_id}' is finished (resolved)" in chain.rejection(1).reason

        # The same as a conversation at the terminal.
        with Bus("chat", chain.settings) as bus:
            lines = io.StringIO("bring me the red cup\nthe big one\nthe first one\n")
            run_chat(bus, lines, 20.0)
        robot, asked, resolved, target = capsys.readouterr().out.splitlines()
        assert robot.startswith('robot:  "I found one red cup on top of the counter top')
        assert "I could not tell from that." in asked
        assert "I will take the red plastic cup on top of" in resolved
        assert target.startswith(f"target: {query.clauses[0].instance_ids[0]} at ")
        assert chain.wait(lambda: len(targets) == 2, 10.0)

        # A confirmation gives its target at once, and may still be corrected.
        with Bus("chat", chain.settings) as bus:
            lines = io.StringIO("bring me the blue cup\nno, the green one\n")
            run_chat(bus, lines, 20.0)
        robot, first, corrected, second = capsys.readouterr().out.splitlines()
        assert "I will take the blue cup" in robot
        assert "the green cup" in corrected
        assert first.startswith("target: cup-")
        assert second.startswith("target: cup-")
        assert first != second


def test_two_people_who_talk_at_once_are_two_dialogues() -> None:
    with (
        Chain() as chain,
        Bus("ann", chain.settings) as ann_bus,
        Bus("bob", chain.settings) as bob_bus,
    ):
        chain.play()
        ann, bob = Conversation(ann_bus), Conversation(bob_bus)
        ann.say("bring me the red cup")
        bob.say("bring me a cup")
        red, any_cup = ann.wait_for_query(1, 10.0), bob.wait_for_query(1, 10.0)
        assert red is not None
        assert any_cup is not None
        assert red.dialogue_id != any_cup.dialogue_id
        assert (red.instruction, any_cup.instruction) == ("bring me the red cup", "bring me a cup")
        # The same words, crossed, and each means the own question.
        said_bob, (meant_by_bob,) = bob.answer("the blue one", any_cup, 10.0)
        said_ann, (meant_by_ann,) = ann.answer("the second one", red, 10.0)
        assert meant_by_ann.dialogue_id == said_ann.dialogue_id == red.dialogue_id
        assert meant_by_bob.dialogue_id == said_bob.dialogue_id == any_cup.dialogue_id
        assert [meant_by_ann.instance_id] == red.clauses[1].instance_ids
        assert meant_by_bob.graph.attributes["color"] == "blue"
        assert (len(ann.queries), len(bob.queries)) == (2, 2)


def test_doro_answer_on_stdin() -> None:
    cups = [
        {"id": color, "graph": {"name": "cup", "attributes": {"color": color}}}
        for color in ("red", "blue")
    ]
    record = {
        "id": "1",
        "instruction": "bring me the cup",
        "instances": cups,
        "query": "I found one red cup, and one blue cup; which one do you mean?",
        "answer": "the second one",
    }
    done = subprocess.run(
        [str(BIN / "doro"), "answer"],
        input=json.dumps(record) + "\n" + json.dumps({"id": "2", "answer": "x"}) + "\n",
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )
    first, second = map(json.loads, done.stdout.splitlines())
    assert (first["action"], first["target"], first["targets"]) == ("resolved", "blue", ["blue"])
    assert first["text"].endswith("take the blue cup.")
    assert "has no graph" in second["error"]
