"""Label sequences to graphs, without a model. Short form: ``cup{color=red}(is-on table)``."""

import pytest
from nlu_sentences import show

from doro_nlu.parser import parse
from doro_nlu.spelling import repair
from doro_nlu.tagger import Tagged
from doro_nlu.train.annotate import annotate
from doro_nlu.train.lexicon import COLORS, MATERIALS, SHADES
from doro_schemas.graph import MAX_DEPTH, walk


def parse_marked(marked: str):
    tokens, labels = annotate(marked)
    return parse(Tagged(tokens, labels, [0.9] * len(tokens)), " ".join(tokens))


TABLE = [
    ("find the {O bed}", "bed", "find"),
    ("{O cup}", "cup", ""),
    ("bring me the {C red} {O cup}", "cup{color=red}", "bring"),
    ("take the {M plastic} {O cup} {P on} the {R table}",
     "cup{material=plastic}(is-on table)", "take"),
    ("a {C red} {M plastic} {O cup}", "cup{color=red,material=plastic}", ""),
    ("a {M wooden} {C brown} {O chair}", "chair{color=brown,material=wood}", ""),
    ("the {C white} {O lamp} {N near} a {C white} {R table}",
     "lamp{color=white}(is-near table{color=white})", ""),
    ("can you bring me the {C red} {O cup} {A from} the {R dining table}",
     "cup{color=red}(is-at dining table)", "bring"),
    ("the {O cup} that is {C red}", "cup{color=red}", ""),
    ("the {O cup} that is {C red} and {M plastic} {P on} the {R table}",
     "cup{color=red,material=plastic}(is-on table)", ""),
    ("a {O cup} made of {M glass} {A in} the {R sink}", "cup{material=glass}(is-at sink)", ""),
    ("the {O cup} {P on} the {R table} that is {C white}", "cup(is-on table{color=white})", ""),
    ("{P on} the {R table} there is a {C blue} {O cup} , bring it",
     "cup{color=blue}(is-on table)", "bring"),
    ("{A in} the {R kitchen} {P on} the {C white} {R table} find a {O cup}",
     "cup(is-at kitchen)(is-on table{color=white})", "find"),
    ("the {O cup} {P on} the {R table} {N near} the {R sink}",
     "cup(is-on table(is-near sink))", ""),
    ("the {O cup} {A in} the {R kitchen} {P on} the {R table}",
     "cup(is-at kitchen)(is-on table)", ""),
    ("a {C brown} {M wooden} {O chair} {N near} the {C white} {R dining table} , {N next to} a"
     " {R box}",
     "chair{color=brown,material=wood}(is-near dining table{color=white})(is-near box)", ""),
    ("the {O cup} {P on} the {R table} which is {N near} the {R sink}",
     "cup(is-on table(is-near sink))", ""),
    ("the {O pen} {N between} the {R cup} and the {C red} {R plate}",
     "pen(is-near cup)(is-near plate{color=red})", ""),
    ("the {C white} and {C green} {O book}", "book{color=white and green}", ""),
    ("the {C dark grey} {O couch}", "sofa{color=dark gray}", ""),
    ("the {C orange colored} {O pencil}", "pencil{color=orange}", ""),
    ("pick the {C green} {O blanket} up {A from} the {R floor}",
     "blanket{color=green}(is-at floor)", "pick up"),
    ("go to the hall and get two {O Knives} {A from} the {R fridge}",
     "knife(is-at refrigerator)", "get"),
    ("the {O knife} with the {C black} handle", "knife", ""),
    ("the {O tray} with the {R sponge} {P on} it", "tray(is-on^ sponge)", ""),
    ("the {O table} that the {R television} is {P on}", "table(is-on^ television)", ""),
    ("the {O pan} with the {C red} {R lid}", "pan(is-at^ lid{color=red})", ""),
    ("{O cup} , {C red} , {M plastic}", "cup{color=red,material=plastic}", ""),
    ("the {O cup} {P on} the {R desk} , the {C red} one", "cup{color=red}(is-on desk)", ""),
    ("the {O cup} {P on} the left {R burner} of the {R stove}", "cup(is-on burner)", ""),
    ("pick up the {O remote control}", "remote control", "pick up"),
    ("close the {O laptop} {P on} the {R couch} and pick it up", "laptop(is-on sofa)", "close"),
]  # fmt: skip


@pytest.mark.parametrize(("marked", "graph", "task"), TABLE)
def test_graph(marked: str, graph: str, task: str) -> None:
    result = parse_marked(marked)
    assert show(result.graph) == graph
    assert result.task == task
    assert result.reason is None
    assert result.confidence == 0.9


@pytest.mark.parametrize(
    ("marked", "readings"),
    [
        ("the {O cup} {P on} the {R table} {N near} the {R sink}",
         ["cup(is-on table)(is-near sink)"]),
        ("a {O chair} {N near} the {R table} , {N next to} a {R box}",
         ["chair(is-near table(is-near box))"]),
        ("the {O cup} {P on} the {R table}", []),
        ("{P on} the {R table} {N near} the {R sink} is a {O cup}",
         ["cup(is-on table)(is-near sink)"]),
        ("the {O cup} {P on} the {R tray} {P on} the {R table} {A in} the {R hall}", [
            "cup(is-on tray(is-on table)(is-at hall))",
            "cup(is-on tray)(is-on table(is-at hall))",
            "cup(is-on tray(is-on table))(is-at hall)",
            "cup(is-on tray)(is-on table)(is-at hall)",
        ]),
        ("the {O cup} {P on} the {R table} {N between} the {R sink} and the {R door}",
         ["cup(is-on table)(is-near sink)(is-near door)"]),
    ],
)  # fmt: skip
def test_open_attachments_are_readings(marked: str, readings: list[str]) -> None:
    assert [show(one.graph) for one in parse_marked(marked).readings] == readings


def test_no_object_gives_a_reason() -> None:
    result = parse_marked("put it {P on} the {R table}")
    assert result.graph is None
    assert result.reason == (
        "no_object", "no object to fetch or find was named in 'put it on the table'"
    )  # fmt: skip
    assert result.confidence == 0.0


def test_confidence_is_that_of_the_weakest_label_used() -> None:
    tagged = Tagged(
        ["bring", "a", "red", "cup"], ["O", "O", "B-color", "B-object"], [0.2, 0.3, 0.6, 0.8]
    )
    assert parse(tagged, "bring a red cup").confidence == 0.6


def test_broken_bio_and_long_chains_do_not_crash() -> None:
    tagged = Tagged(["a", "b", "c"], ["I-object", "I-color", "I-is-on"], [0.5] * 3)
    assert show(parse(tagged, "a b c").graph) == "a{color=b}"
    chain = "the {O cup} " + "{P on} the {R table} " * 300
    graph = parse_marked(chain).graph
    assert graph is not None
    assert len(list(walk(graph))) == MAX_DEPTH


@pytest.mark.parametrize(
    ("value", "kind", "repaired"),
    [
        ("blakc", "color", "black"),
        ("yelow", "color", "yellow"),
        ("dark gren", "color", "dark green"),
        ("wodden", "material", "wooden"),
        ("wooen", "material", "wooen"),  # wooden or woolen
        ("zorbel", "color", "zorbel"),
        ("rad", "color", "rad"),
        ("steal", "material", "steel"),
    ],
)
def test_typos_of_values_are_repaired(value: str, kind: str, repaired: str) -> None:
    assert repair(value, kind) == repaired


def test_no_value_of_the_generator_is_taken_for_a_typo() -> None:
    for kind, values in (("color", COLORS + SHADES), ("material", MATERIALS)):
        assert [value for value in values if repair(value, kind) != value] == []
