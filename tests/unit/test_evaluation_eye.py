"""The cases that were read by eye, and how they are drawn."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path

from doro_evaluation.queries.eye import described, drawn
from doro_evaluation.queries.judge import Verdict
from doro_evaluation.queries.pairs import Pair
from doro_evaluation.queries.systems import QueryOutcome
from doro_schemas.graph import ObjectGraph, Relation

EYE = Path(__file__).parents[2] / "evaluation" / "eye"
STATES = ("CONFIRM", "INFORM-AMBIGUITY", "INFORM-MISMATCH", "INFORM-MISSING")


def test_fifty_cases_are_listed_and_agree_as_told() -> None:
    cases = [json.loads(line) for line in (EYE / "cases.jsonl").read_text().splitlines()]
    assert [one["number"] for one in cases] == list(range(1, 51))
    same = sum(one["right"] == one["eye"] for one in cases)
    text = (EYE / "README.md").read_text()
    assert f"agree in {same} of {len(cases)}" in text
    assert same >= 47
    assert text.count("\n| ") == len(cases) + 1
    wrong = Counter(one["eye"] for one in cases)
    assert min(wrong[True], wrong[False]) >= 15
    assert all(one["instruction"] and one["said"] for one in cases)


def outcome(number: int, true: str, right: bool, system: str = "ours") -> QueryOutcome:
    pair = Pair(f"p/{number}", "default-FloorPlan1", "name", "true", "x", "", ObjectGraph("cup"))
    verdict = Verdict("" if right else "state", "CONFIRM", true, "Okay.", ["Okay."])
    return QueryOutcome(pair, system, "multi-view", verdict)


def test_cases_are_drawn_evenly_and_the_same_for_the_same_seed() -> None:
    many = [outcome(k, STATES[k % 4], right=k % 9 > 0) for k in range(400)]
    many.append(outcome(999, "CONFIRM", right=True, system="grid"))
    chosen = drawn(many, seed=7, count=16)
    strata = Counter((one.verdict.true, one.verdict.right) for one in chosen)
    assert set(strata.values()) == {2}
    assert chosen == drawn(list(reversed(many)), seed=7, count=16)
    assert chosen != drawn(many, seed=8, count=16)
    assert all(one.system == "ours" for one in chosen)


def test_a_graph_in_one_line() -> None:
    near = Relation("is-near", ObjectGraph("sink", {"color": "gray"}))
    assert described(ObjectGraph("cup", {"color": "red"}, [near])) == "red cup; is-near gray sink"
