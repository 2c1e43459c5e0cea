"""Texts read and judged: what is true of the truth is right, and what is not is found."""

from __future__ import annotations

import pytest

from doro_evaluation.baseline.judging import judge_text
from doro_evaluation.baseline.reading import read_query
from doro_evaluation.queries.judge import Truth, Verdict
from doro_nlu.core import Nlu
from doro_nlu.settings import NluSettings
from doro_schemas.graph import ObjectGraph, Relation
from doro_sim_feeder.rooms.truth import TrueInstance, TrueRelation

SUFFIX = "; which one do you mean?"


def _thing(
    name: str, color: str, relation: tuple[str, str] | None, at_m: float, kind: str = "Cup"
) -> TrueInstance:
    relations = [] if relation is None else [TrueRelation(relation[0], "l", relation[1], {})]
    return TrueInstance(
        number=1,
        object_id=name,
        object_type=kind,
        attributes={"color": color},
        center_m=[at_m, 0.0, 0.0],
        size_m=[0.1, 0.1, 0.1],
        receptacle="",
        relations=relations,
        views=1,
    )


RED, BLUE = (
    _thing("a", "red", ("is-on", "DiningTable"), 0.0),
    _thing("b", "blue", ("is-near", "Sink"), 9.0),
)
TWIN = _thing("c", "red", ("is-on", "DiningTable"), 20.0)


@pytest.fixture(scope="module")
def nlu() -> Nlu:
    return Nlu(NluSettings())


def judged(nlu: Nlu, text: str, things: list[TrueInstance], **said: str) -> Verdict:
    truth = Truth.of(things, {thing.object_id for thing in things})
    graph = ObjectGraph("cup", dict(said))
    return judge_text(
        truth, graph, "bring", text, lambda phrase: nlu.parse_text(phrase, caption=True).graph
    )


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        (f"I found one red cup, and one blue cup{SUFFIX}", ""),
        (f"I found one blue cup near the sink, and one cup on top of the dining table{SUFFIX}", ""),
        (f"I found one red cup, and one green cup{SUFFIX}", "attributes"),
        (f"I found one red cup, and one red cup{SUFFIX}", "attributes"),
        (f"I found one red cup near the sink, and one blue cup{SUFFIX}", "attributes"),
        (f"I found one cup, and one cup{SUFFIX}", "attributes"),
        (f"I found two cups{SUFFIX}", "attributes"),
        (f"I found one red cup, and one blue bowl{SUFFIX}", "attributes"),
        (f"I found one red cup, one blue cup, and one cup{SUFFIX}", "instances"),
        ("Okay, I will take the red cup.", "state"),
        ("I could not find a cup.", "state"),
        ("the the the", "state"),
        ("", "state"),
    ],
)
def test_an_ambiguity_names_all_and_only_what_is_true(nlu: Nlu, text: str, fault: str) -> None:
    assert judged(nlu, text, [RED, BLUE]).fault == fault


def test_all_wordings_of_the_truth_are_right(nlu: Nlu) -> None:
    for things in ([], [RED], [BLUE], [RED, BLUE], [RED, TWIN], [RED, BLUE, TWIN]):
        for said in ({}, {"color": "red"}, {"color": "green"}):
            wordings = judged(nlu, "", things, **said).references
            assert wordings
            for wording in wordings:
                verdict = judged(nlu, wording, things, **said)
                assert (verdict.fault, verdict.said) == ("", verdict.true), wording


def test_twins_are_counted(nlu: Nlu) -> None:
    text = f"I found two identical red cups on top of the dining table, and one blue cup{SUFFIX}"
    assert judged(nlu, text, [RED, TWIN, BLUE]).fault == ""
    assert judged(nlu, text.replace("two", "three"), [RED, TWIN, BLUE]).fault == "instances"
    sides = "two identical red cups, one on the left and one on the right as I saw them"
    assert judged(nlu, f"I found {sides}{SUFFIX}", [RED, TWIN]).fault == ""


def test_a_mismatch_says_what_differs(nlu: Nlu) -> None:
    said = {"color": "green"}
    right = "I found one cup, but it is red. Should I take it?"
    assert judged(nlu, right, [RED], **said).fault == ""
    assert judged(nlu, right.replace("red", "blue"), [RED], **said).fault == "attributes"
    place = "I found one cup, but it is on top of the dining table. Should I take it?"
    assert judged(nlu, place, [RED], **said).fault == "attributes"


def test_what_is_missing_is_what_was_asked_for(nlu: Nlu) -> None:
    said = {"color": "green"}
    assert judged(nlu, "I could not find a green cup.", [], **said).fault == ""
    assert judged(nlu, "I could not find a cup.", [], **said).fault == ""
    assert judged(nlu, "I could not find a red cup.", [], **said).fault == "attributes"
    assert judged(nlu, "I could not find a green bowl.", [], **said).fault == "instances"


def test_a_crowd_is_read_by_kind(nlu: Nlu) -> None:
    text = (
        "I found seven cups: three blue, two near the sink, and two more; what color is the one"
        " you mean?"
    )
    found = read_query(text, lambda phrase: nlu.parse_text(phrase, caption=True).graph)
    assert found.state == "INFORM-AMBIGUITY"
    assert [clause.count for clause in found.clauses] == [3, 2, 2]
    assert found.clauses[0].graph.attributes == {"color": "blue"}
    assert found.clauses[1].graph.relations == [Relation("is-near", ObjectGraph("sink"))]
    assert found.clauses[2].other
