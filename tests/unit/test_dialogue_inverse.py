"""Inverse relations: matched where the map has them, unknown where it has not, put into words."""

import msgspec
import pytest

from doro_dialogue.decide_lines import decide_record
from doro_dialogue.facts import carried_by
from doro_dialogue.matching import match
from doro_dialogue.surface import counted, definite, predicate
from doro_mapper.carried import with_carried
from doro_schemas.graph import ObjectGraph, Relation
from doro_schemas.messages import Instance

SPONGE = ObjectGraph("sponge", {"color": "yellow"})
TRAY_WITH_SPONGE = ObjectGraph("tray", {}, [Relation("is-on", ObjectGraph("sponge"), True)])
ON_IT = Relation("is-on", SPONGE, inverse=True)
TABLE = Relation("is-on", ObjectGraph("table"))


def seen(*relations: Relation) -> ObjectGraph:
    return ObjectGraph("tray", {}, list(relations))


@pytest.mark.parametrize(
    ("said", "relations", "verdict"),
    [
        (TRAY_WITH_SPONGE, [TABLE, Relation("is-on", SPONGE, True)], "holds"),
        (TRAY_WITH_SPONGE, [TABLE], "unknown"),
        (TRAY_WITH_SPONGE, [Relation("is-on", ObjectGraph("spoon"), True)], "unknown"),
        # The tray on the sponge is not the tray with the sponge on it, nor the other way round.
        (TRAY_WITH_SPONGE, [Relation("is-on", SPONGE)], "unknown"),
        (seen(Relation("is-on", ObjectGraph("sponge"))), [ON_IT], "unknown"),
        # "with a cup" is satisfied by a cup on it and by a cup in it; "on it" by on alone.
        (seen(Relation("is-at", ObjectGraph("sponge"), True)), [ON_IT], "holds"),
        (TRAY_WITH_SPONGE, [Relation("is-at", SPONGE, True)], "unknown"),
        (seen(Relation("is-on", ObjectGraph("sponge", {"color": "red"}), True)),
         [Relation("is-on", SPONGE, True)], "unknown"),
    ],
)  # fmt: skip
def test_verdicts(said: ObjectGraph, relations: list[Relation], verdict: str) -> None:
    assert match(said, seen(*relations)).verdict == verdict


def test_words() -> None:
    assert definite(TRAY_WITH_SPONGE) == "the tray with the sponge on it"
    held = ObjectGraph("box", {}, [Relation("is-at", ObjectGraph("cup", {"color": "red"}), True)])
    assert counted(held) == "one box with the red cup"
    assert predicate(TRAY_WITH_SPONGE.relations) == "the one with the sponge on it"


def test_a_decision_picks_the_tray_that_has_it() -> None:
    record = {
        "id": 1,
        "graph": msgspec.to_builtins(TRAY_WITH_SPONGE),
        "instances": [
            {"id": "a", "graph": msgspec.to_builtins(seen(TABLE))},
            {"id": "b", "graph": msgspec.to_builtins(seen(TABLE, Relation("is-on", SPONGE, True)))},
        ],
    }
    decided = decide_record(record, paper_literal=False, seed=0)
    assert (decided["state"], decided["matches"]) == ("CONFIRM", ["b"])
    del record["instances"][1]
    decided = decide_record(record, paper_literal=False, seed=0)
    assert (decided["state"], decided["matches"]) == ("INFORM-MISMATCH", [])


def test_only_what_was_said_is_asked_of_the_map() -> None:
    more = ObjectGraph("tray", {}, [TABLE, Relation("is-at", ObjectGraph("cup"), True)])
    assert carried_by(TRAY_WITH_SPONGE, more, TRAY_WITH_SPONGE) == ["sponge", "cup"]
    assert carried_by(seen(TABLE)) == []


def instance(name: str, position_m: list[float], extent_m: list[float]) -> Instance:
    graph = ObjectGraph(name, {"color": "red"} if name == "cup" else {})
    return Instance(f"{name}-1", graph, position_m, extent_m)


def test_the_map_tells_what_lies_on_a_thing_when_it_is_asked() -> None:
    table = instance("table", [0.0, 0.4, 0.0], [1.0, 0.8, 1.0])
    cup = instance("cup", [0.2, 0.85, 0.2], [0.1, 0.1, 0.1])
    bowl = instance("bowl", [3.0, 0.85, 0.2], [0.1, 0.1, 0.1])
    everything = [table, cup, bowl]
    assert with_carried([table], everything, [], "unity") == [table]
    (found,) = with_carried([table], everything, ["cup", "bowl"], "unity")
    assert found.graph.relations == [Relation("is-on", cup.graph, inverse=True)]
    # In a ROS world the third axis is up: there the cup hangs beside the table's middle.
    assert with_carried([table], everything, ["cup"], "ros") == [table]
    (same,) = with_carried([cup], everything, ["table"], "unity")
    assert same.graph.relations == []
