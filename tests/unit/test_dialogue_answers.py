"""What an answer comes to: a specification as tables of scene, answer, and what is meant.

The answers are parsed by nlu, as in ``doro answer``.
"""

from __future__ import annotations

import random

import pytest

from doro_console.lines import answer_line, load_nlu
from doro_dialogue.acts import hear
from doro_dialogue.answer_lines import answer_record
from doro_dialogue.decision import decide
from doro_dialogue.facts import Candidate
from doro_dialogue.question import compose
from doro_nlu.core import Nlu
from doro_schemas.graph import ObjectGraph, Relation

AGAIN, MISSING, CANCELLED, ELSEWHERE = "ask_again", "missing", "cancelled", "search_again"


@pytest.fixture(scope="module")
def nlu() -> Nlu:
    return load_nlu(())


def thing(name="cup", color="", *, material="", on="", near="", inside=""):
    """Return a graph as JSON; a landmark may have a color ("black table")."""

    def landmark(words):
        *own, noun = words.split(" ")
        return {"name": noun, "attributes": {"color": own[0]} if own else {}, "relations": []}

    relations = [("is-on", on), ("is-at", inside), ("is-near", near)]
    attributes = {"color": color, "material": material}
    return {
        "name": name,
        "attributes": {key: value for key, value in attributes.items() if value},
        "relations": [{"type": k, "target": landmark(v)} for k, v in relations if v],
    }


SCENES = {
    # Two cups; neither was described.
    "two": (
        thing(),
        {"red": thing(color="red", on="table"), "blue": thing(color="blue", near="lamp")},
        "I found one red cup, and one blue cup; which one do you mean?",
    ),
    "three": (
        thing(),
        {
            "red": thing(color="red", on="table"),
            "blue": thing(color="blue", near="lamp"),
            "green": thing(color="green", on="shelf"),
            "bowl": thing("bowl", "white"),
        },
        "I found one red cup, one blue cup, and one green cup; which one do you mean?",
    ),
    "row": (
        thing(),
        {"red": thing(color="red"), "blue": thing(color="blue"), "green": thing(color="green")},
        "From left to right I see one green cup, one red cup, and one blue cup; which one?",
    ),
    "five": (
        thing(color="red"),
        {
            "table": thing(color="red", material="plastic", on="table"),
            "sink": thing(color="red", material="plastic", inside="sink"),
            "glass": thing(color="red", material="glass", on="table"),
            "shelf": thing(color="red", material="glass", on="shelf"),
            "lamp": thing(color="red", material="metal", near="black lamp"),
        },
        "",
    ),
    "twins": (
        thing(),
        {
            "a": thing(color="red", on="shelf"),
            "b": thing(color="red", on="shelf"),
            "blue": thing(color="blue"),
        },
        "",
    ),
    "only twins": (
        thing(),
        {"a": thing(color="red", on="shelf"), "b": thing(color="red", on="shelf")},
        "I found two identical red cups on top of the shelf; is either of them fine?",
    ),
    # Nobody saw the color of the second.
    "unknown": (
        thing(),
        {"red": thing(color="red", on="table"), "sink": thing(inside="sink")},
        "I found one cup on top of the table, and one cup in the sink; which one do you mean?",
    ),
    # "bring me the red cup": it is blue.
    "mismatch": (thing(color="red"), {"blue": thing(color="blue", on="table")}, ""),
    "confirm": (
        thing(color="red"),
        {"red": thing(color="red", on="table"), "blue": thing(color="blue", near="lamp")},
        "",
    ),
    "missing": (thing(color="red"), {"bowl": thing("bowl", "white")}, ""),
    # Two red ones were offered, and there is a blue one.
    "not offered": (
        thing(color="red"),
        {
            "table": thing(color="red", on="table"),
            "sink": thing(color="red", inside="sink"),
            "blue": thing(color="blue", on="shelf"),
        },
        "",
    ),
    "landmarks": (
        thing(),
        {"black": thing(color="red", on="white table"), "red": thing(color="black", on="desk")},
        "I found one red cup on top of the white table, and one black cup on top of the desk;"
        " which one do you mean?",
    ),
    "kinds": (
        thing("lamp"),
        {"desk": thing("desk lamp"), "floor": thing("floor lamp")},
        "I found one desk lamp, and one floor lamp; which one do you mean?",
    ),
    "shades": (
        thing(),
        {"blue": thing(color="blue"), "dark": thing(color="dark blue")},
        "I found one blue cup, and one dark blue cup; which one do you mean?",
    ),
}

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
        "I found one red cup on top of the table, and one red cup on",
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


COLORS = ["red", "blue", "green", "white"]
LANDMARKS = ["table", "sink", "shelf", "lamp"]


def random_cup(rng: random.Random) -> ObjectGraph:
    attributes = {"color": rng.choice(COLORS)} if rng.random() < 0.8 else {}
    if rng.random() < 0.4:
        attributes["material"] = rng.choice(["plastic", "glass"])
    kinds = [kind for kind in ("is-on", "is-near") if rng.random() < 0.4]
    return ObjectGraph(
        "cup", attributes, [Relation(kind, ObjectGraph(rng.choice(LANDMARKS))) for kind in kinds]
    )


def test_the_words_of_a_clause_mean_its_instance(nlu):
    """Of every clause that stands for one instance; twins are never told apart."""
    resolved = asked = 0
    for seed in range(250):
        rng = random.Random(seed)
        seen = [Candidate(f"cup-{i}", random_cup(rng)) for i in range(rng.randrange(2, 6))]
        decision = decide(ObjectGraph("cup"), seen)
        question = compose(decision)
        instances = [{"id": one.id, "graph": as_json(one.graph)} for one in seen]
        for part in question.parts:
            words = "the " + part.text.split(" ", 1)[1]
            got = answer_record(
                {
                    "id": seed,
                    "graph": {"name": "cup"},
                    "instances": instances,
                    "query": question.wordings[0],
                    "answer": words,
                },
                lambda text: nlu.parse_text(text).graph,
            )
            if words == "the other cup" and question.wordings[0].count("other") > 1:
                # Several are "one other": which, these words do not say.
                assert got["target"] is None
            elif len(part.instance_ids) == 1:
                assert got["target"] == part.instance_ids[0], (question.wordings[0], words, got)
                resolved += 1
            else:
                assert got["target"] is None
                asked += 1
    assert resolved > 700
    assert asked > 5


def as_json(graph: ObjectGraph) -> dict:
    return {
        "name": graph.name,
        "attributes": graph.attributes,
        "relations": [{"type": r.type, "target": as_json(r.target)} for r in graph.relations],
    }
