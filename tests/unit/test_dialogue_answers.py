"""What an answer comes to: a specification as tables of scene, answer, and what is meant.

The answers are parsed by nlu, as in ``doro answer``.
"""

from __future__ import annotations

import pytest

from doro_console.lines import answer_line, load_nlu
from doro_dialogue.acts import hear
from doro_nlu.core import Nlu
from tests.unit.answer_scenes import SCENES

AGAIN, MISSING, CANCELLED, ELSEWHERE = "ask_again", "missing", "cancelled", "search_again"


@pytest.fixture(scope="module")
def nlu() -> Nlu:
    return load_nlu(())


CASES = [
    # attributes
    ("three", "the red one", "red"),
    ("three", "red", "red"),
    ("three", "The RED one, please!", "red"),
    ("three", "I want the green one", "green"),
    ("three", "bring me the blue one", "blue"),
    ("three", "the blue cup", "blue"),
    ("three", "it's the green one", "green"),
    ("five", "the metal one", "lamp"),
    ("five", "the glass one", AGAIN),
    ("kinds", "the desk lamp", "desk"),
    ("kinds", "the floor one", "floor"),
    # relations, and both
    ("three", "the one near the lamp", "blue"),
    ("three", "the one next to the lamp", "blue"),
    ("three", "near the lamp", "blue"),
    ("three", "the one on the table", "red"),
    ("three", "on the shelf", "green"),
    ("three", "the table one", "red"),
    ("five", "the one in the sink", "sink"),
    ("five", "the plastic one on the table", "table"),
    ("five", "the glass one on the table", "glass"),
    ("five", "the one on the table", AGAIN),
    ("five", "the one near the black lamp", "lamp"),
    ("three", "the red one near the lamp", AGAIN),
    # a bare color names the object, not its landmark
    ("landmarks", "the black one", "red"),
    ("landmarks", "the white one", MISSING),
    ("landmarks", "the one on the white table", "black"),
    # ordinals follow the order of the question
    ("three", "the first", "red"),
    ("three", "second one", "blue"),
    ("three", "the last one", "green"),
    ("three", "number two", "blue"),
    ("three", "3", "green"),
    ("three", "the first one you mentioned", "red"),
    ("three", "the fourth one", AGAIN),
    ("three", "the second one, the blue one", "blue"),
    ("three", "the second one, the red one", AGAIN),
    ("three", "the second red one", AGAIN),
    ("two", "the latter", "blue"),
    ("two", "the former", "red"),
    ("row", "the first one", "green"),
    ("twins", "the second one", AGAIN),
    # left, middle and right only where the question gave that order
    ("row", "the left one", "green"),
    ("row", "the one in the middle", "red"),
    ("row", "the rightmost one", "blue"),
    ("three", "the left one", AGAIN),
    ("three", "the middle one", AGAIN),
    ("two", "the one on the right", AGAIN),
    # yes says nothing to a which-question, and takes an offer
    ("three", "yes", AGAIN),
    ("three", "no", AGAIN),
    ("three", "ok", AGAIN),
    ("three", "yes, the red one", "red"),
    ("mismatch", "yes", "blue"),
    ("mismatch", "sure, take it", "blue"),
    ("mismatch", "that one is fine", AGAIN),
    ("mismatch", "no", MISSING),
    ("mismatch", "no, the red one", MISSING),
    ("confirm", "yes", "red"),
    ("confirm", "no", AGAIN),
    ("missing", "yes", AGAIN),
    ("only twins", "yes", "a"),
    ("only twins", "no", AGAIN),
    # the other one: only where one is meant by it
    ("confirm", "no, the other one", "blue"),
    ("confirm", "the other one", "blue"),
    ("two", "the other one", AGAIN),
    ("two", "not the red one, the other one", "blue"),
    # either, both, none
    ("two", "either", "red"),
    ("two", "either one is fine", "red"),
    ("three", "any of them", "red"),
    ("three", "I don't care", "red"),
    ("five", "any plastic one", "sink"),
    ("two", "both", ["red", "blue"]),
    ("three", "both", AGAIN),
    ("three", "all of them", ["red", "blue", "green"]),
    ("three", "all three", ["red", "blue", "green"]),
    ("three", "the red one and the blue one", ["red", "blue"]),
    ("three", "the red one or the blue one", AGAIN),
    ("three", "all but the red one", ["blue", "green"]),
    ("five", "the plastic ones", ["sink", "table"]),
    ("three", "the red and the blue one", ["red", "blue"]),
    ("three", "the red and blue ones", ["red", "blue"]),
    ("three", "the first two", AGAIN),
    ("three", "none of them", MISSING),
    ("two", "neither", MISSING),
    ("not offered", "neither", AGAIN),
    # cancel
    ("three", "no thanks", CANCELLED),
    ("three", "never mind", CANCELLED),
    ("three", "stop", CANCELLED),
    ("three", "oh, forget it", CANCELLED),
    ("mismatch", "no, never mind", CANCELLED),
    ("three", "never mind, the blue one", "blue"),
    ("two", "never mind the red one", "blue"),
    # another class replaces the object
    ("three", "I meant the bowl", "bowl"),
    ("three", "no, the bowl", "bowl"),
    ("three", "bring me the white bowl instead", "bowl"),
    ("missing", "then the bowl", "bowl"),
    ("three", "the toaster", MISSING),
    ("three", "I meant the red bowl", AGAIN),
    ("three", "the lamp", AGAIN),
    # a word taken back, among all of the class
    ("confirm", "no, the blue one", "blue"),
    ("confirm", "no, the one near the lamp", "blue"),
    ("confirm", "the blue one", AGAIN),
    ("not offered", "the blue one", AGAIN),
    ("not offered", "I meant the blue one", "blue"),
    # not X: only when one is left
    ("two", "not the red one", "blue"),
    ("three", "not the red one", AGAIN),
    ("three", "not the red one and not the blue one", "green"),
    ("three", "neither the red nor the blue one", "green"),
    ("three", "the red one, not the blue one", "red"),
    ("two", "anything but the red one", "blue"),
    ("two", "the one that is not on the table", "blue"),
    ("two", "not the purple one", AGAIN),
    ("two", "not the first one", "blue"),
    ("twins", "not the blue one", AGAIN),
    # a property that nobody observed
    ("three", "the big one", AGAIN),
    ("three", "the biggest one", AGAIN),
    ("three", "mine", AGAIN),
    ("three", "the one you saw last", AGAIN),
    ("three", "my red cup", "red"),
    ("three", "bring the red", "red"),
    ("three", "my sister's", AGAIN),
    ("three", "the one I used yesterday", AGAIN),
    ("three", "the one farthest from the lamp", AGAIN),
    ("three", "the one in the kitchen", AGAIN),
    ("unknown", "the green one", AGAIN),
    ("unknown", "the red one", "red"),
    ("shades", "the light blue one", AGAIN),
    # known to be false of all
    ("three", "the purple one", MISSING),
    ("two", "the wooden one", AGAIN),
    ("five", "the wooden one", MISSING),
    ("missing", "then the blue cup", MISSING),
    # shades and twins
    ("shades", "the blue one", "blue"),
    ("shades", "the dark blue one", "dark"),
    ("twins", "the blue one", "blue"),
    ("twins", "the red one", AGAIN),
    ("twins", "any red one", "a"),
    ("twins", "the red ones", ["a", "b"]),
    # another place to look
    ("three", "look in the kitchen", ELSEWHERE),
    ("missing", "try the living room", ELSEWHERE),
    ("missing", "it's in the bedroom", ELSEWHERE),
    ("missing", "it should be on the table", ELSEWHERE),
    ("three", "no, it's in the kitchen", ELSEWHERE),
    ("three", "keep looking", ELSEWHERE),
    ("three", "can you check the kitchen?", ELSEWHERE),
    ("three", "look on the table", AGAIN),
    # slips of the keyboard, never another word
    ("three", "teh bleu one", "blue"),
    ("three", "the red cpu", "red"),
    ("three", "grene", "green"),
    ("three", "the secnod one", "blue"),
    ("three", "the old one", AGAIN),
    ("two", "the bed one", AGAIN),
    # as people talk
    ("three", "blue plz", "blue"),
    ("three", "red red red", "red"),
    ("three", "wait, the blue one", "blue"),
    ("three", "I think it is the red one, on the table", "red"),
    ("three", "whichever is closer", AGAIN),
    ("three", "whatever", "red"),
    ("three", "what?", AGAIN),
    ("three", "say that again", AGAIN),
    ("three", "thanks", AGAIN),
    ("three", "actually forget it", CANCELLED),
    ("five", "any of the plastic ones", "sink"),
    ("five", "either of the plastic ones", "sink"),
    ("mismatch", "fine by me", "blue"),
    ("mismatch", "sure, why not", "blue"),
    ("mismatch", "no way", MISSING),
    ("mismatch", "that's the wrong one", MISSING),
    ("confirm", "thanks", "red"),
    ("confirm", "perfect, thank you", "red"),
    ("confirm", "is it clean?", AGAIN),
    ("shades", "the dark one", "dark"),
    ("shades", "the light one", AGAIN),
    ("kinds", "the desk lamp, please", "desk"),
    # the very words of a clause
    ("three", "one green cup", "green"),
    ("landmarks", "one black cup on top of the desk", "red"),
    # nothing that can be understood
    ("three", "I don't know", AGAIN),
    ("three", "what do you see?", AGAIN),
    ("three", "asdf qwer", AGAIN),
    ("three", "the cup", AGAIN),
    ("three", "the red one, " * 40, AGAIN),
]


def record(scene: str, answer: str) -> dict:
    said, seen, query = SCENES[scene]
    instances = [{"id": name, "graph": graph} for name, graph in seen.items()]
    return {"id": 1, "graph": said, "instances": instances, "query": query, "answer": answer}


@pytest.mark.parametrize(("scene", "answer", "expected"), CASES)
def test_an_answer_comes_to(nlu, scene, answer, expected):
    got = answer_line(nlu, record(scene, answer), seed=0)
    if isinstance(expected, list):
        assert (got["action"], got["target"], got["targets"]) == (
            "resolved_multiple",
            None,
            expected,
        )
    elif expected in (AGAIN, MISSING, CANCELLED, ELSEWHERE):
        assert (got["action"], got["target"], got["targets"]) == (expected, None, [])
    else:
        assert (got["action"], got["target"], got["targets"]) == ("resolved", expected, [expected])
    assert got["text"]


TEXTS = [
    (
        "five",
        "the glass one",
        "I found one red glass cup on top of the table, and one red glass cup on top of the shelf",
    ),
    ("three", "not the red one", "I found one blue cup, and one green cup;"),
    ("three", "the purple one", "I could not find a purple cup."),
    ("three", "the red one", "the red cup on top of the table."),
    ("three", "yes", "I could not tell from that. I found one red cup, one blue cup,"),
    (
        "unknown",
        "the green one",
        "I could not tell whether it is green.",
    ),
    ("not offered", "the blue one", "I found one blue cup on top of the shelf. Should I take it?"),
    ("three", "never mind", "Okay, I will leave it."),
    ("three", "what?", "I found one red cup, one blue cup, and one green cup; which"),
    ("only twins", "the red one", "That is true of both. I found two identical red cups"),
    ("confirm", "is it clean?", "I could not tell from that. Do you mean the red cup on top"),
    ("mismatch", "no", "Then I have not found it. Should I look for something else?"),
    ("missing", "hm", "I could not tell from that. Tell me what to look for, or where."),
    ("missing", "keep looking", "Okay, I will look again."),
    ("missing", "look in the kitchen", "Okay, I will look there."),
    ("five", "the metal one", "I will take the metal cup near the black lamp."),
    ("two", "both", "Okay, I will take one red cup and one blue cup."),
]


@pytest.mark.parametrize(("scene", "answer", "words"), TEXTS)
def test_what_is_said_to_an_answer(nlu, scene, answer, words):
    assert words in answer_line(nlu, record(scene, answer), seed=0)["text"]


def test_a_query_with_clauses_gives_the_order(nlu):
    _, seen, _ = SCENES["two"]
    clauses = [
        {"instance_ids": [one], "text": "one cup", "graph": seen[one]} for one in ("blue", "red")
    ]
    query = {"text": "which?", "state": "INFORM-AMBIGUITY", "clauses": clauses}
    got = answer_line(nlu, {**record("two", "the first"), "query": query}, seed=0)
    assert got["target"] == "blue"
    clauses[0]["instance_ids"] = ["gone"]
    got = answer_line(nlu, {**record("two", "the first"), "query": query}, seed=0)
    assert "'gone', which is not among the instances" in got["error"]


def test_a_text_that_names_nobody_gives_no_order(nlu):
    asked = {**record("two", "the first one"), "query": "There are two cups. Which one?"}
    assert answer_line(nlu, asked, seed=0)["action"] == AGAIN
    described = {**asked, "answer": "the red one"}
    assert answer_line(nlu, described, seed=0)["target"] == "red"


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"graph": None}, "has no graph"),
        ({"answer": " "}, "the answer is empty"),
        ({"answer": 3}, "does not fit"),
        ({"instances": [{"id": "x"}]}, "does not fit"),
    ],
)
def test_a_record_that_does_not_fit_gets_a_sentence(nlu, change, words):
    assert words in answer_line(nlu, {**record("two", "red"), **change}, seed=0)["error"]


def test_a_description_is_read_with_the_class_name_in_place_of_one():
    assert hear("the red one near the lamp", "cup").texts == ["the red cup near the lamp"]
    assert hear("red", "cup").texts == ["the red cup"]
    assert hear("on the table", "cup").texts == ["the cup on the table"]
    assert hear("the first", "cup").texts == []
