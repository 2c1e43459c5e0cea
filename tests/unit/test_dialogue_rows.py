"""Twins by side in a view that shows them, and crowds by kind."""

from __future__ import annotations

import pytest

from doro_console.lines import answer_line, decide_line, load_nlu
from doro_dialogue.decision import decide
from doro_dialogue.facts import Candidate
from doro_dialogue.question import compose
from doro_dialogue.rows import row_of
from doro_nlu.core import Nlu
from doro_schemas.messages import Evidence, Target
from doro_schemas.messages.talk import SeenFrom
from tests.unit.test_dialogue_scenes import graph
from tests.unit.test_dialogue_turns import Room, only

LEFT, MIDDLE, RIGHT = [10.0, 100, 50, 150], [55.0, 98, 95, 150], [100.0, 100, 140, 150]
FAR_RIGHT, ABOVE = [150.0, 100, 190, 150], [12.0, 20, 52, 70]


@pytest.fixture(scope="module")
def nlu() -> Nlu:
    return load_nlu(())


def view(box, frame=3, camera="cam0"):
    return Evidence(camera=camera, frame=frame, box_px=box)


def seen(*boxes, text="white mug on[shelf]"):
    return [
        Candidate(f"x-{i + 1}", graph(text), () if box is None else (view(box),))
        for i, box in enumerate(boxes)
    ]


# what it shows | boxes | text | ids of the clauses
ROWS = [
    ("left and right", [LEFT, RIGHT], "one on the left and one on the right as I saw them",
     ["x-1", "x-2"]),
    ("in the order of the view, not of the ids", [RIGHT, LEFT],
     "one on the left and one on the right as I saw them", ["x-2", "x-1"]),
    ("three", [LEFT, RIGHT, MIDDLE],
     "one on the left, one in the middle and one on the right as I saw them",
     ["x-1", "x-3", "x-2"]),
    ("four are counted", [LEFT, RIGHT, MIDDLE, FAR_RIGHT],
     "side by side, counted from the left as I saw them", ["x-1", "x-3", "x-2", "x-4"]),
]  # fmt: skip


@pytest.mark.parametrize("row", ROWS, ids=[row[0] for row in ROWS])
def test_twins_are_told_apart_by_side(row):
    _, boxes, words, ids = row
    question = compose(decide(graph("white mug"), seen(*boxes)))
    assert words in question.wordings[0]
    assert question.wordings[0].endswith("which one do you mean?")
    assert [part.instance_ids for part in question.parts] == [[one] for one in ids]
    assert question.seen_from == SeenFrom("cam0", 3)


@pytest.mark.parametrize(
    "boxes", [[LEFT, None], [None, None], [LEFT, ABOVE], [LEFT, [20.0, 100, 60, 150]], [LEFT] * 2]
)
def test_without_a_view_that_shows_them_side_by_side_they_are_counted(boxes):
    question = compose(decide(graph("white mug"), seen(*boxes)))
    assert question.wordings[0] == (
        "I found two identical white mugs on top of the shelf; is either of them fine?"
    )
    assert question.seen_from is None


def test_views_of_other_frames_and_cameras_do_not_count():
    a = Candidate("a", graph("mug"), (view(LEFT, 1), view(LEFT, 2)))
    assert row_of([a, Candidate("b", graph("mug"), (view(RIGHT, 3),))]) is None
    assert row_of([a, Candidate("b", graph("mug"), (view(RIGHT, 1, "cam1"),))]) is None
    row = row_of([a, Candidate("b", graph("mug"), (view(RIGHT, 3), view(RIGHT, 2)))])
    assert row.seen_from == SeenFrom("cam0", 2)


def test_beside_another_the_twins_keep_their_sides():
    boxes = [LEFT, RIGHT]
    other = Candidate("x-3", graph("blue mug"), (view(FAR_RIGHT),))
    text = compose(decide(graph("mug"), [*seen(*boxes), other])).wordings[0]
    assert text == (
        "I found two identical white mugs, one on the left and one on the right as I saw them,"
        " and one blue mug; which one do you mean?"
    )


def test_two_pairs_of_twins_have_no_left_one():
    blue = [Candidate(f"y-{i}", graph("blue mug"), (view(b),)) for i, b in enumerate((LEFT, RIGHT))]
    question = compose(decide(graph("mug"), [*seen(LEFT, RIGHT), *blue]))
    assert question.seen_from is None
    assert "left" not in question.wordings[0]


def as_record(candidates, instruction):
    instances = [
        {
            "id": one.id,
            "graph": {
                "name": one.graph.name,
                "attributes": one.graph.attributes,
                "relations": [
                    {"type": r.type, "target": {"name": r.target.name}} for r in one.graph.relations
                ],
            },
            "evidence": [
                {"camera": e.camera, "frame": e.frame, "box_px": e.box_px} for e in one.views
            ],
        }
        for one in candidates
    ]
    return {"id": 1, "instruction": instruction, "instances": instances}


TWINS = seen(RIGHT, LEFT)
MIXED = [
    *seen(LEFT, RIGHT, text="white mug"),
    Candidate("x-3", graph("blue mug"), (view(FAR_RIGHT),)),
]
FOUR = seen(LEFT, RIGHT, MIDDLE, FAR_RIGHT)
APART = [
    Candidate("x-1", graph("red mug"), (view(RIGHT),)),
    Candidate("x-2", graph("blue mug"), (view(LEFT),)),
]
ANSWERS = [
    (TWINS, "the left one", "x-2"),
    (TWINS, "left", "x-2"),
    (TWINS, "right", "x-1"),
    (TWINS, "the right one, please", "x-1"),
    (TWINS, "the one on the right", "x-1"),
    (TWINS, "the left mug", "x-2"),
    (TWINS, "the first", "x-2"),
    (TWINS, "the second one", "x-1"),
    (TWINS, "not the left one", "x-1"),
    (TWINS, "either", "x-2"),
    (TWINS, "the one on your left", "x-2"),
    # of whom it is the left nobody knows
    (TWINS, "the one on my left", None),
    (TWINS, "the middle one", None),
    (TWINS, "the white one", None),
    (TWINS, "yes", None),
    (MIXED, "the left one", "x-1"),
    (MIXED, "the white one on the right", "x-2"),
    (MIXED, "the right white mug", "x-2"),
    (MIXED, "the blue one", "x-3"),
    (MIXED, "the right blue one", None),
    (MIXED, "the third", "x-3"),
    (FOUR, "the second from the left", "x-3"),
    (FOUR, "second from the right", "x-2"),
    (FOUR, "the last from the left", "x-4"),
    (FOUR, "the leftmost one", "x-1"),
    (FOUR, "the third", "x-2"),
    (FOUR, "the sixth from the left", None),
    (FOUR, "the middle one", None),
    (APART, "the left one", None),
]


@pytest.mark.parametrize(("candidates", "answer", "target"), ANSWERS)
def test_an_answer_by_side(nlu, candidates, answer, target):
    record = as_record(candidates, "bring me the mug")
    asked = decide_line(nlu, record, paper_literal=False, seed=0)["text"]
    got = answer_line(nlu, {**record, "query": asked, "answer": answer}, seed=0)
    assert (got["action"], got["target"]) == ("resolved" if target else "ask_again", target)


def test_a_side_that_the_question_did_not_name_is_answered_from_left_to_right(nlu):
    record = {**as_record(APART, "bring me the mug"), "query": "", "answer": "the left one"}
    got = answer_line(nlu, record, seed=0)
    assert got["text"].startswith(
        "From left to right, as I saw them, I found one blue mug, and one red mug;"
    )
    again = {**record, "query": got["text"], "answer": "the left one"}
    assert answer_line(nlu, again, seed=0)["target"] == "x-2"


def test_the_target_is_named_with_its_side(nlu):
    record = {**as_record(TWINS, "bring me the mug"), "query": "", "answer": "the left one"}
    assert answer_line(nlu, record, seed=0)["text"].endswith(
        "I will take the white mug on top of the shelf, the one on the left."
    )


class TwinRoom(Room):
    """A map that saw the cups in one frame, the second one left of the first."""

    def map(self, name: str):
        reply = super().map(name)
        for one, box in zip(reply.instances, (RIGHT, LEFT), strict=True):
            one.evidence.extend([view([0, 0, 9, 9], 40 + len(one.instance_id)), view(box)])
        return reply


def test_over_messages_the_query_names_the_view_and_shows_it_first(nlu):
    room = TwinRoom(nlu, world=[graph("red cup"), graph("red cup")])
    (query,) = room.say()
    assert query.seen_from == SeenFrom("cam0", 3)
    assert [clause.instance_ids for clause in query.clauses] == [["cup-2"], ["cup-1"]]
    assert [clause.text for clause in query.clauses] == [
        "one red cup, on the left",
        "one red cup, on the right",
    ]
    assert [clause.evidence[0].frame for clause in query.clauses] == [3, 3]
    assert only(room.answer("the left one"), Target)[0].instance_id == "cup-2"


# --- crowds --------------------------------------------------------------------------------

# what it shows | said | seen | first wording
CROWDS = [
    ("by color", "cup", ["red cup on[table]"] * 2 + ["red cup on[shelf]", "blue cup on[table]",
     "blue cup on[shelf]", "blue cup near[sink]", "white cup at[sink]"],
     "I found seven cups: three blue, three red, and one white; what color is the one you mean?"),
    ("by place, where the color was said", "red cup",
     ["red cup on[table]", "red plastic cup on[table]", "red glass cup on[table]",
      "red cup on[shelf]", "red plastic cup on[shelf]", "red glass cup on[shelf]",
      "red cup on[desk]"],
     "I found seven red cups: three on top of the shelf, three on top of the table, and one on"
     " top of the desk; where is the one you mean?"),
    ("what was not observed is more", "cup",
     ["red cup on[table]", "red cup on[shelf]", "red cup on[desk]", "blue cup on[table]",
      "blue cup on[shelf]", "cup on[table]", "cup at[sink]"],
     "I found seven cups: three on top of the table, two on top of the shelf, one on top of the"
     " desk, and one more; where is the one you mean?"),
    ("by kind", "lamp",
     ["desk_lamp on[desk]", "desk_lamp on[shelf]", "desk_lamp near[bed]", "desk_lamp near[sofa]",
      "floor_lamp near[sofa]", "floor_lamp near[bed]", "floor_lamp near[door]"],
     "I found seven lamps: four desk lamps, and three floor lamps; which one do you mean?"),
    ("all different", "cup",
     ["red cup", "blue cup", "green cup", "white cup", "black cup", "yellow cup", "pink cup",
      "gray cup", "brown cup"],
     "I found nine cups: one black, one blue, one brown, one gray, one green, one pink, one red,"
     " and two more; what color is the one you mean?"),
    ("a dozen twins are counted", "cup", ["red cup on[table]"] * 12,
     "I found twelve identical red cups on top of the table; is any of them fine?"),
    ("none as said", "purple cup",
     ["red cup on[table]", "red cup on[shelf]", "red cup on[desk]", "blue cup on[table]",
      "blue cup on[shelf]", "blue cup on[desk]", "blue cup at[sink]"],
     "I found seven cups: two on top of the desk, two on top of the shelf, two on top of the"
     " table, and one more, but no purple cup; where is the one you mean?"),
]  # fmt: skip


@pytest.mark.parametrize("crowd", CROWDS, ids=[crowd[0] for crowd in CROWDS])
def test_more_than_a_person_can_keep_in_mind_are_told_by_kind(crowd):
    _, said, texts, wording = crowd
    candidates = [Candidate(f"x-{i + 1}", graph(text)) for i, text in enumerate(texts)]
    question = compose(decide(graph(said), candidates))
    assert question.wordings[0] == wording
    named = [name for part in question.parts for name in part.instance_ids]
    assert sorted(named) == sorted(one.id for one in candidates)
    assert all(len(wording) < 200 for wording in question.wordings)


def test_a_crowd_is_narrowed_until_one_is_left(nlu):
    room = Room(nlu, world=[graph(text) for text in CROWDS[0][2]])
    (query,) = room.say()
    assert [len(clause.instance_ids) for clause in query.clauses] == [3, 3, 1]
    assert all(clause.cells for clause in query.clauses)
    (narrower,) = room.answer("a blue one")
    assert len(narrower.clauses) == 3
    assert only(room.answer("the one near the sink"), Target)[0].instance_id == "cup-6"


def test_up_to_five_are_named_one_by_one():
    texts = ["red cup", "blue cup", "green cup", "white cup", "black cup"]
    candidates = [Candidate(f"x-{i + 1}", graph(text)) for i, text in enumerate(texts)]
    question = compose(decide(graph("cup"), candidates))
    assert [part.text for part in question.parts] == [f"one {text}" for text in texts]
