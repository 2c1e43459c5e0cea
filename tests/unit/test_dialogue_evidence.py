"""Every clause of every query points to what supports it."""

from __future__ import annotations

import random

import pytest

from doro_console.lines import load_nlu
from doro_nlu.core import Nlu
from doro_schemas.graph import ObjectGraph
from doro_schemas.messages import Clause, Evidence, Query
from tests.unit.test_dialogue_properties import random_graph
from tests.unit.test_dialogue_turns import Room

RED = ObjectGraph("cup", {"color": "red"})


@pytest.fixture(scope="module")
def nlu() -> Nlu:
    return load_nlu(())


class Watched(Room):
    """A map with five views of every instance, each of its own frames."""

    def map(self, name: str):
        reply = super().map(name)
        for one in reply.instances:
            first = 100 * one.cells[0][0]
            one.evidence.extend(
                Evidence(camera="cam0", frame=first + k, box_px=[0, 0, 9, 9]) for k in range(5)
            )
        return reply


def check(clause: Clause) -> None:
    """At least one view of each instance, the strongest ones, and all cells."""
    numbers = [int(name.rsplit("-", 1)[1]) - 1 for name in clause.instance_ids]
    assert numbers
    assert {view.frame // 100 for view in clause.evidence} == set(numbers)
    assert min(view.frame % 100 for view in clause.evidence) == 0
    assert len(clause.evidence) == max(3, len(numbers))
    assert clause.cells == [[number, number, 0] for number in numbers]
    assert clause.text


def test_every_clause_of_a_question_names_frames_boxes_and_cells(nlu):
    clauses = 0
    for seed in range(120):
        rng = random.Random(seed)
        room = Watched(nlu, world=[random_graph(rng) for _ in range(rng.randrange(1, 10))])
        query, *_ = room.say(random_graph(rng))
        assert isinstance(query, Query)
        assert query.clauses
        for clause in [*query.clauses, *query.also]:
            check(clause)
            clauses += 1
    assert clauses > 250


def test_what_a_confirmation_could_not_tell_has_its_evidence_too(nlu):
    room = Watched(nlu, world=[RED, ObjectGraph("cup"), ObjectGraph("cup", {"color": "blue"})])
    (query,) = room.say(RED)
    assert query.text.endswith("I could not tell whether another cup is red.")
    assert [clause.instance_ids for clause in query.clauses] == [["cup-1"]]
    assert [clause.instance_ids for clause in query.also] == [["cup-2"]]
    (said, _) = room.answer("yes")
    assert said.also == []


def test_could_not_find_says_what_it_rests_on(nlu):
    (query,) = Watched(nlu, world=[]).say(RED)
    assert (query.state, query.clauses) == ("INFORM-MISSING", [])
    assert (query.frames_merged, query.map_digest, query.unseen_share) == (9, "d", 0.0)


def test_the_answers_clauses_have_theirs(nlu):
    room = Watched(nlu)
    room.say()
    (narrower,) = room.answer("not the red one")
    said, _ = room.answer("the green one")
    for clause in [*narrower.clauses, *said.clauses]:
        check(clause)
