"""``doro decide``'s records, and the paper's formulas beside the corrected decision."""

from __future__ import annotations

import json

import pytest

from doro_dialogue.decide_lines import decide_record

RED, BLUE = {"color": "red"}, {"color": "blue"}


def record(*seen, said=RED, **fields):
    instances = [
        {"id": f"c{i + 1}", "graph": {"name": "cup", "attributes": own}}
        for i, own in enumerate(seen)
    ]
    return {
        "id": "r1",
        "graph": {"name": "cup", "attributes": said},
        "instances": instances,
    } | fields


def test_a_record_comes_back_as_plain_json():
    result = decide_record(record(RED, BLUE))
    assert json.loads(json.dumps(result)) == result
    assert sorted(result) == ["id", "matches", "reason", "state", "text"]
    assert (result["id"], result["state"]) == ("r1", "CONFIRM")
    assert (result["matches"], result["reason"]) == (["c1"], "unique_match")
    assert result["text"].endswith("I will take the red cup.")


def test_every_wording_on_request():
    result = decide_record(record(RED, BLUE, said={}), wordings=True)
    assert result["text"] in result["wordings"]
    assert len(set(result["wordings"])) == len(result["wordings"]) == 4
    assert all(one.startswith("I found one red cup, and one blue") for one in result["wordings"])


def test_readings_come_with_the_record():
    near = [{"type": "is-near", "target": {"name": "sink"}}]
    on = {"type": "is-on", "target": {"name": "table"}}
    nested = {"type": "is-on", "target": {"name": "table", "relations": near}}
    graphs = [{"name": "cup", "relations": one} for one in ([nested], [on, *near])]
    both = {
        "id": "r",
        "graph": graphs[0],
        "readings": graphs[1:],
        "instances": [{"id": i, "graph": one} for i, one in enumerate(graphs)],
    }
    result = decide_record(both)
    assert (result["state"], result["reason"]) == ("INFORM-AMBIGUITY", "readings")
    assert result["matches"] == [0, 1]
    assert "the cup near the sink, or is the table near the sink?" in result["text"]
    assert decide_record(both, paper_literal=True)["reason"] == "mismatch"


def test_numbers_as_ids_come_back_as_numbers():
    one = {"id": 7, "graph": {"name": "cup"}}
    result = decide_record({"id": 3, "graph": {"name": "cup"}, "instances": [one]})
    assert (result["id"], result["matches"]) == (3, [7])


def test_the_seed_changes_the_words_and_nothing_else():
    results = [decide_record(record(RED, RED, BLUE), seed=seed) for seed in range(30)]
    assert len({result["text"] for result in results}) > 1
    assert {(result["state"], result["reason"]) for result in results} == {
        ("INFORM-AMBIGUITY", "several_match")
    }


# seen | ours: state, reason, matches | the paper's formulas: state, reason, matches
DIFFERENCES = [
    ("none", [], ("INFORM-MISSING", "missing", []), ("INFORM-MISSING", "missing", [])),
    ("one right", [RED], ("CONFIRM", "unique_match", ["c1"]), ("CONFIRM", "unique_match", ["c1"])),
    ("one wrong", [BLUE], ("INFORM-MISMATCH", "mismatch", []), ("INFORM-MISMATCH", "mismatch", [])),
    ("two identical", [RED, RED], ("INFORM-AMBIGUITY", "several_match", ["c1", "c2"]),
     ("CONFIRM", "several_match", ["c1", "c2"])),
    ("one right, one wrong", [RED, BLUE], ("CONFIRM", "unique_match", ["c1"]),
     ("INFORM-MISMATCH", "mismatch", ["c1"])),
    ("one right, two wrong", [RED, BLUE, {"color": "green"}],
     ("CONFIRM", "unique_match", ["c1"]), ("INFORM-AMBIGUITY", "no_match", ["c1"])),
    ("two right, one wrong", [RED, RED, BLUE],
     ("INFORM-AMBIGUITY", "several_match", ["c1", "c2"]),
     ("INFORM-MISMATCH", "mismatch", ["c1", "c2"])),
    ("two wrong", [BLUE, BLUE], ("INFORM-AMBIGUITY", "no_match", []),
     ("INFORM-AMBIGUITY", "no_match", [])),
    ("not observed", [{}], ("INFORM-MISMATCH", "unknown", []), ("INFORM-MISMATCH", "mismatch", [])),
    ("a shade of it", [{"color": "dark red"}], ("CONFIRM", "unique_match", ["c1"]),
     ("INFORM-MISMATCH", "mismatch", [])),
]  # fmt: skip


@pytest.mark.parametrize("case", DIFFERENCES, ids=[case[0] for case in DIFFERENCES])
def test_ours_and_the_papers_formulas(case):
    _, seen, ours, literal = case
    for expected, flag in ((ours, False), (literal, True)):
        result = decide_record(record(*seen), paper_literal=flag)
        assert (result["state"], result["reason"], result["matches"]) == expected


def test_the_papers_templates():
    table = [{"type": "is-on", "target": {"name": "table"}}]
    near = [{"type": "is-near", "target": {"name": "sink"}}]
    seen = record(BLUE, {"color": "green", "material": "glass"})
    for one, relations in zip(seen["instances"], (table, near), strict=True):
        one["graph"]["relations"] = relations
    text = decide_record(seen, paper_literal=True)["text"]
    assert text.startswith(
        "I found one blue cup on top of the table, and one green glass cup near the sink; which"
    )
    missing = decide_record(record(), paper_literal=True)
    assert missing["text"] == "I could not find that."


@pytest.mark.parametrize(
    ("bad", "says"),
    [
        (record(graph=None), "no graph"),
        ({"id": "r1"}, "no graph"),
        (record(instances="many"), "Expected `array`, got `str`"),
        ({"id": "r1", "graph": {"name": "cup"}}, "missing required field `instances`"),
        (record(graph={"name": ""}), "an object graph needs a name"),
        (record(graph={"name": "cup", "attributes": {"color": 3}}), "Expected `str`, got `int`"),
        (record(instances=[{"id": "a", "graph": {"name": "cup"}}] * 2), "give each its own"),
        ("no record", "does not fit"),
        ([], "does not fit"),
    ],
)
def test_a_bad_record_gives_one_sentence(bad, says):
    result = decide_record(bad)
    assert sorted(result) == ["error", "id"]
    assert result["id"] == (bad["id"] if isinstance(bad, dict) else None)
    assert says in result["error"]
    assert "\n" not in result["error"]


def test_a_graph_without_end_gives_one_sentence():
    deep = {"name": "cup"}
    for _ in range(400):
        deep = {"name": "cup", "relations": [{"type": "is-on", "target": deep}]}
    assert "nests" in decide_record(record(graph=deep))["error"]
