"""The hundred hand-written instructions: the file is sound, and the shipped taggers read it."""

import pytest

from doro_evaluation.tagging.exactness import FRESH, Row, graph_exactness, read_rows
from doro_nlu.core import Nlu
from doro_nlu.reasons import KINDS
from doro_nlu.settings import NluSettings
from doro_schemas.errors import Refused
from doro_schemas.graph import ObjectGraph, Relation, walk
from doro_schemas.vocabulary import canonical_name, canonical_value

ROWS = read_rows()
LEAST = 90
"""Of 100; 93 were measured with both taggers when this was written."""

LEAST_FRESH = 18


def test_a_hundred_different_rows_in_canonical_words() -> None:
    assert len(ROWS) == len({row.text for row in ROWS}) == len({row.id for row in ROWS}) == 100
    for row in ROWS:
        assert (row.graph is None) == bool(row.reason_kind), row.id
        if row.graph is None:
            assert row.reason_kind in KINDS
            continue
        for node in walk(row.graph):
            assert canonical_name(node.name) == node.name
            assert {canonical_value(value) for value in node.attributes.values()} == set(
                node.attributes.values()
            )


@pytest.mark.parametrize("tagger", ["bilstm", "default"])
def test_most_whole_graphs_are_right(tagger: str) -> None:
    right, failures = graph_exactness(Nlu(NluSettings(tagger=tagger)), ROWS)
    assert right + len(failures) == len(ROWS)
    assert right >= LEAST, failures


def test_the_fresh_ones_are_sound_and_new() -> None:
    fresh = read_rows(FRESH)
    assert len({row.text for row in (*fresh, *ROWS)}) == len(fresh) + len(ROWS) == 126
    right, failures = graph_exactness(Nlu(NluSettings()), fresh)
    assert right >= LEAST_FRESH, failures


def test_the_order_of_relations_does_not_count_but_their_direction_does() -> None:
    nlu = Nlu(NluSettings())
    near, on = Relation("is-near", ObjectGraph("lamp")), Relation("is-on", ObjectGraph("table"))
    text = "the cup on the table and near the lamp"
    assert graph_exactness(nlu, [Row("a", text, ObjectGraph("cup", {}, [near, on]))])[0] == 1
    inverse = Relation("is-on", ObjectGraph("table"), inverse=True)
    right, failures = graph_exactness(
        nlu, [Row("b", text, ObjectGraph("cup", {}, [near, inverse]))]
    )
    assert (right, [one.id for one in failures]) == (0, ["b"])


def test_a_line_that_is_no_row_is_named(tmp_path) -> None:
    path = tmp_path / "rows.jsonl"
    path.write_text('{"id": "1", "text": "a"}\n{"id": 2}\n', encoding="utf-8")
    with pytest.raises(Refused, match=r"rows\.jsonl, line 2"):
        read_rows(path)
