"""Answering with the words of a clause resolves to its instance, for generated scenes."""

from __future__ import annotations

import random

import pytest

from doro_console.lines import load_nlu
from doro_dialogue.answer_lines import answer_record
from doro_dialogue.decision import decide
from doro_dialogue.facts import Candidate
from doro_dialogue.question import compose
from doro_nlu.core import Nlu
from doro_schemas.graph import ObjectGraph, Relation


@pytest.fixture(scope="module")
def nlu() -> Nlu:
    return load_nlu(())


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
