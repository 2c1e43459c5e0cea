"""Two readings of one instruction: asked about only where they come to different things."""

from __future__ import annotations

import msgspec
import pytest

from doro_console.lines import answer_line, decide_line, load_nlu
from doro_dialogue.ask_reading import compose_read
from doro_dialogue.decision import decide
from doro_dialogue.readings import decide_readings
from doro_nlu.core import Nlu
from doro_schemas.messages import Target
from tests.unit.test_dialogue_scenes import candidates, graph
from tests.unit.test_dialogue_turns import Room, only

CONFIRM, AMBIGUITY, MISMATCH = "CONFIRM", "INFORM-AMBIGUITY", "INFORM-MISMATCH"
SINK = "bring me the cup on the table near the sink"
TABLE_NEAR, CUP_NEAR = "red cup on[table near[sink]]", "blue cup on[table] near[sink]"
SINK_QUESTION = "Is the cup near the sink, or is the table near the sink?"


@pytest.fixture(scope="module")
def nlu() -> Nlu:
    return load_nlu(())


# what it shows | readings | seen | state | reason | matches | first wording
SCENES = [
    ("each reading means another", ["cup on[table near[sink]]", "cup on[table] near[sink]"],
     [TABLE_NEAR, CUP_NEAR], AMBIGUITY, "readings", [1, 2], SINK_QUESTION),
    ("the other way round the thing wanted still comes first",
     ["cup on[table] near[sink]", "cup on[table near[sink]]"],
     [TABLE_NEAR, CUP_NEAR], AMBIGUITY, "readings", [1, 2], SINK_QUESTION),
    ("both mean the same one", ["cup on[table near[sink]]", "cup on[table] near[sink]"],
     ["red cup on[table near[sink]] near[sink]", "blue cup on[desk]"], CONFIRM, "unique_match", [1],
     "Okay, I will take the cup on top of the table near the sink."),
    ("both mean the same two", ["cup on[table near[sink]]", "cup on[table] near[sink]"],
     ["red cup on[table near[sink]] near[sink]", "blue cup on[table near[sink]] near[sink]"],
     AMBIGUITY, "several_match", [1, 2],
     "I found one red cup, and one blue cup; which one do you mean?"),
    ("nothing of the class", ["cup on[table near[sink]]", "cup on[table] near[sink]"], ["bowl"],
     "INFORM-MISSING", "missing", [], "I could not find a cup on top of the table near the sink."),
    ("one reading fits and nothing speaks against the other",
     ["cup on[table near[sink]]", "cup on[table] near[sink]"], ["cup on[table] near[sink]"],
     CONFIRM, "unique_match", [1],
     "Okay, I will take the cup on top of the table and near the sink."),
    ("one reading fits, the other is contradicted",
     ["cup near[table on[rug]]", "cup near[table] on[rug]"], ["cup near[table on[rug]] on[desk]"],
     AMBIGUITY, "readings", [1],
     "Is the cup on top of the rug, or is the table on top of the rug?"),
    ("one reading fits one, the other two",
     ["cup on[table near[sink]]", "cup on[table] near[sink]"],
     [TABLE_NEAR, "red cup on[table near[sink]] near[sink]"], AMBIGUITY, "readings", [1, 2],
     SINK_QUESTION),
    ("neither fits: no question about it",
     ["cup on[table near[sink]]", "cup on[table] near[sink]"], ["cup on[desk]"], MISMATCH,
     "mismatch", [], "I found one cup, but it is on top of the desk. Should I take it?"),
    ("whose color it is", ["lamp near[white table]", "white lamp near[table]"],
     ["black lamp near[white table]", "white lamp near[black table]"], AMBIGUITY, "readings",
     [1, 2], "Is the lamp white, or is the table white?"),
    ("things of one name", ["cup near[cup near[sink]]", "cup near[cup] near[sink]"],
     ["cup near[cup near[sink]]", "cup near[cup] near[sink]"], AMBIGUITY, "readings", [1, 2],
     "Is the cup that you want near the sink, or is the other cup near the sink?"),
    ("told apart by their colors", ["red cup near[blue cup near[sink]]",
     "red cup near[blue cup] near[sink]"],
     ["red cup near[blue cup near[sink]]", "red cup near[blue cup] near[sink]"], AMBIGUITY,
     "readings", [1, 2], "Is the red cup near the sink, or is the blue cup near the sink?"),
    ("a pair", ["scissors on[table near[sink]]", "scissors on[table] near[sink]"],
     ["scissors on[table near[sink]]", "scissors on[table] near[sink]"], AMBIGUITY, "readings",
     [1, 2], "Are the scissors near the sink, or is the table near the sink?"),
    ("three may hold it",
     ["lamp near[chair on[desk near[door]]]", "lamp near[chair near[door on[desk]]]",
      "lamp near[chair on[desk]] near[door]"],
     ["lamp near[chair on[desk near[door]]]", "lamp near[chair on[desk]] near[door]"], AMBIGUITY,
     "readings", [1, 2], "Is the lamp near the door, or is the desk near the door?"),
    ("two open attachments are asked one at a time",
     ["lamp near[chair on[desk near[window]]]", "lamp near[chair on[desk]] near[window]",
      "lamp near[chair] on[desk near[window]]", "lamp near[chair] on[desk] near[window]"],
     ["lamp near[chair on[desk near[window]]]", "lamp near[chair] on[desk] near[window]"],
     AMBIGUITY, "readings", [1, 2],
     "Is the lamp on top of the desk, or is the chair on top of the desk?"),
]  # fmt: skip


@pytest.mark.parametrize("scene", SCENES, ids=[scene[0] for scene in SCENES])
def test_scene(scene):
    _, readings, seen, state, reason, matches, text = scene
    read = decide_readings([graph(one) for one in readings], candidates(seen), decide)
    assert (read.decision.state, read.decision.reason) == (state, reason)
    assert read.decision.matches == [f"x-{number}" for number in matches]
    assert compose_read(read).wordings[0] == text
    assert (read.split is not None) == (reason == "readings")


def test_a_single_reading_is_decided_as_ever():
    seen = candidates(["red cup", "blue cup"])
    assert decide_readings([graph("red cup")], seen, decide).decision == decide(
        graph("red cup"), seen
    )


def test_the_clauses_are_the_readings_with_what_each_would_single_out():
    read = decide_readings(
        [graph("cup on[table near[sink]]"), graph("cup on[table] near[sink]")],
        candidates([TABLE_NEAR, CUP_NEAR]),
        decide,
    )
    question = compose_read(read)
    assert [(part.instance_ids, part.text) for part in question.parts] == [
        (["x-2"], "the cup is near the sink"),
        (["x-1"], "the table is near the sink"),
    ]
    assert question.wordings[1:] == [
        f"Just to be sure: {SINK_QUESTION[0].lower()}{SINK_QUESTION[1:]}",
        "What is near the sink, the cup or the table?",
    ]


def record(**fields):
    seen = [(f"x-{i + 1}", graph(one)) for i, one in enumerate([TABLE_NEAR, CUP_NEAR])]
    instances = [{"id": name, "graph": msgspec.to_builtins(one)} for name, one in seen]
    return {"id": 1, "instruction": SINK, "instances": instances, **fields}


ANSWERS = [
    ("the cup", "x-2"),
    ("the cup is", "x-2"),
    ("the cup is near the sink", "x-2"),
    ("the one near the sink", "x-2"),
    ("I mean the cup", "x-2"),
    ("the table", "x-1"),
    ("it's the table", "x-1"),
    ("the table near the sink", "x-1"),
    ("teh tabel", "x-1"),
    ("not the cup", "x-1"),
    ("not the table", "x-2"),
    ("the table, not the cup", "x-1"),
    ("the first", "x-2"),
    ("the second one", "x-1"),
    ("the latter", "x-1"),
    # a description of the thing itself
    ("the red one", "x-1"),
    ("the blue cup", "x-2"),
    # nothing that decides it
    ("yes", None),
    ("no", None),
    ("what?", None),
    ("the cup on the table near the sink", None),
    ("the third", None),
    ("both", None),
    ("neither", None),
    ("I don't know", None),
    ("it doesn't matter", None),
    ("asdf qwer", None),
]


@pytest.mark.parametrize(("answer", "target"), ANSWERS)
def test_an_answer_chooses_the_reading(nlu, answer, target):
    asked = decide_line(nlu, record(), paper_literal=False, seed=0)
    assert asked["reason"] == "readings"
    got = answer_line(nlu, record(query=asked["text"], answer=answer), seed=0)
    assert (got["action"], got["target"]) == ("resolved" if target else "ask_again", target)


@pytest.mark.parametrize("answer", ["both", "neither", "I don't know", "either"])
def test_where_it_does_not_matter_the_things_are_asked_about(nlu, answer):
    got = answer_line(nlu, record(query=SINK_QUESTION, answer=answer), seed=0)
    assert "one red cup, and one blue cup" in got["text"]


def test_over_messages_the_chosen_reading_is_decided_and_may_need_another_question(nlu):
    room = Room(nlu, world=[graph(one) for one in (TABLE_NEAR, CUP_NEAR, f"green {CUP_NEAR[5:]}")])
    parsed = nlu.parse_text(SINK)
    (query,) = room.say(parsed.graph, SINK, readings=parsed.readings)
    assert (query.state, query.reason, query.revision) == (AMBIGUITY, "readings", 0)
    assert [clause.instance_ids for clause in query.clauses] == [["cup-2", "cup-3"], ["cup-1"]]
    assert query.clauses[1].cells == [[0, 0, 0]]
    (again,) = room.answer("yes")
    assert (again.reason, again.revision, again.replaces) == ("readings", 1, 0)
    (which,) = room.answer("the cup")
    assert (which.reason, which.matches) == ("several_match", ["cup-2", "cup-3"])
    said, target = room.answer("the green one")
    assert (said.ended, target.instance_id) == ("resolved", "cup-3")


def test_over_messages_a_reading_that_singles_one_out_gives_the_target(nlu):
    room = Room(nlu, world=[graph(TABLE_NEAR), graph(CUP_NEAR)])
    parsed = nlu.parse_text(SINK)
    room.say(parsed.graph, SINK, readings=parsed.readings)
    said, target = room.answer("the table is")
    assert (said.state, said.ended) == (CONFIRM, "resolved")
    assert (target.instance_id, target.graph) == ("cup-1", graph(TABLE_NEAR))


def test_the_question_for_a_reading_counts_as_a_turn(nlu):
    room = Room(nlu, world=[graph(TABLE_NEAR), graph(CUP_NEAR)], max_turns=2)
    parsed = nlu.parse_text(SINK)
    room.say(parsed.graph, SINK, readings=parsed.readings)
    room.answer("yes")
    (given_up,) = room.answer("no")
    assert (given_up.reason, given_up.ended) == ("turn_limit", "turn_limit")


def test_both_readings_stay_open_when_the_map_changes(nlu):
    room = Room(nlu, world=[graph(TABLE_NEAR), graph(CUP_NEAR)])
    parsed = nlu.parse_text(SINK)
    room.say(parsed.graph, SINK, readings=parsed.readings)
    room.world.pop()
    query, target = room.look_again()
    assert (query.state, query.revision, query.replaces) == (CONFIRM, 1, 0)
    assert target.instance_id == "cup-1"
    assert only(room.answer("yes"), Target)[0].instance_id == "cup-1"
