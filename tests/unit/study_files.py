"""A small study made by hand: two scenes, two systems, and answers to it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from doro_evaluation.study.files import Asked, Check, Item, KnownInstance, Study, Unit, with_digest
from doro_schemas.graph import ObjectGraph, Relation
from doro_schemas.messages.talk import Clause

CUP = ObjectGraph("cup")
RED = ObjectGraph("cup", {"color": "red"})
BLUE = ObjectGraph("cup", {"color": "blue"})
ON_TABLE = ObjectGraph("cup", {"color": "red"}, [Relation("is-on", ObjectGraph("table"))])
QUESTION = "I found one red cup, and one blue cup; which one do you mean?"
OFFER = "I found one cup, but it is blue. Should I take it?"


def asked(text: str, clauses: list[Clause], state: Any, intended: list[str]) -> Asked:
    known = [KnownInstance("cup-1", ON_TABLE), KnownInstance("cup-2", BLUE)]
    known = known if len(clauses) != 1 else known[1:]
    return Asked(text, state, clauses, known, intended)


def small_study(design: Any = "one") -> Study:
    both = [Clause(["cup-1"], "one red cup", RED), Clause(["cup-2"], "one blue cup", BLUE)]
    only = [Clause(["cup-2"], "one cup, but it is blue", BLUE)]
    which = asked(QUESTION, both, "INFORM-AMBIGUITY", ["cup-2"])
    curt = asked("Okay.", both, "CONFIRM", ["cup-2"])
    offer = asked(OFFER, only, "INFORM-MISMATCH", ["cup-2"])
    return with_digest(
        Study(
            id="small",
            seed=0,
            design=design,
            systems=["ours", "curt"],
            items=[
                Item(
                    id="s01",
                    recording="room",
                    instruction="bring me the cup",
                    task="bring",
                    graph=CUP,
                    state="INFORM-AMBIGUITY",
                    marks={"A": "one", "B": "two"},
                    wanted=["B"],
                    units=[
                        Unit("s01q1", QUESTION, {"ours": which}),
                        Unit("s01q2", "Okay.", {"curt": curt}),
                    ],
                ),
                Item(
                    id="s02",
                    recording="room",
                    instruction="bring me the red cup",
                    task="bring",
                    graph=RED,
                    state="INFORM-MISMATCH",
                    marks={"A": "two"},
                    wanted=["A"],
                    units=[Unit("s02q1", OFFER, {"ours": offer, "curt": offer})],
                ),
            ],
            checks=[Check("c1", 2, 4)],
        )
    )


def rating(unit: str, informative: int, natural: int, reply: str = "") -> dict[str, Any]:
    return {
        "item": unit[:3],
        "unit": unit,
        "position": 0,
        "informative": informative,
        "natural": natural,
        "reply": reply,
        "cannot_tell": not reply,
        "seconds": 3.5,
    }


def answers(
    study: Study, participant: str, ratings: list[dict[str, Any]], **changes: Any
) -> dict[str, Any]:
    return {
        "schema": "doro.study.answers",
        "version": 1,
        "study": {"id": study.id, "digest": study.digest},
        "participant": participant,
        "consent": True,
        "started": "2026-01-01T00:00:00.000Z",
        "finished": "2026-01-01T00:05:00.000Z",
        "answers": ratings,
        "checks": [{"id": "c1", "informative": 2, "natural": 4}],
        **changes,
    }


def write(folder: Path, name: str, content: Any) -> Path:
    path = folder / name
    path.write_text(json.dumps(content), encoding="utf-8")
    return path
