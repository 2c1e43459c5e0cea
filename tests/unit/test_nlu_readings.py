"""Readings, inverse relations, targets and negation, on marked sentences without a model."""

import pytest
from nlu_sentences import show
from test_nlu_parser import parse_marked

from doro_nlu.readings import MAX_READINGS
from doro_schemas import codec
from doro_schemas.graph import ObjectGraph, Relation
from doro_schemas.messages import ParseReply

CHAIN = (
    "the {O cup} {P on} the {R tray} {N near} the {R box} {A in} the {R crate} {N by} the {R door}"
)

INVERSE = [
    ("the {O bowl} with an {R apple} {A in} it", "bowl(is-at^ apple)"),
    ("the {O box} with a {R cup}", "box(is-at^ cup)"),
    ("the {O bowl} containing a {C red} {R apple}", "bowl(is-at^ apple{color=red})"),
    ("the {O tray} with the {R cup} and the {R saucer} {P on} it",
     "tray(is-on^ cup)(is-on^ saucer)"),
    ("the {O plate} which has a {R fork} {P on} it", "plate(is-on^ fork)"),
    ("the {O table} that the {R lamp} is on", "table(is-on^ lamp)"),
    ("the {O shelf} {P on} which there is a {R radio}", "shelf(is-on^ radio)"),
    ("the {O desk} that the {R chair} is {N next to}", "desk(is-near chair)"),
    ("the {O mug} with a {R spoon} {A in} it {A from} the {R counter}",
     "mug(is-at^ spoon)(is-at counter top)"),
    ("the {O cup} {A from} the {R table} with the {R lamp} {P on} it",
     "cup(is-at table(is-on^ lamp))"),
    ("the {O cup} {P on} the {R counter} with the {R knife} {A in} it",
     "cup(is-on counter top)(is-at^ knife)"),
    ("pick the {O cup} up with the {R spoon} {A in} it", "cup(is-at^ spoon)"),
    ("cut the {O bread} with the {R knife}", "bread"),
    ("turn on the {O lamp} while holding the {R box}", "lamp"),
    ("the {O tray} that has a {O sponge} {P on} it", "tray(is-on^ sponge)"),
    ("the {O table} that the {O lamp} is {P on}", "table(is-on^ lamp)"),
]  # fmt: skip

TARGETS = [
    ("the {O cup} {N next to} the {R knife} and the {O fork}", "cup(is-near knife)(is-near fork)"),
    ("the {O cup} {P on} the {R table} and the {O plate}", "!two_targets"),
    ("the {O cup} {N near} the {R sink} and the {O plate} {P on} the {R table}", "!two_targets"),
    ("bring the {O cup} and bring the plate", "!two_targets"),
    ("bring the {O cup} , then get me the blue plate", "!two_targets"),
    ("take the {O cup} and take a left", "cup"),
    ("take the {O cup} and bring it", "cup"),
    ("take the {O cup} and give the cup to me", "cup"),
    ("take the {O knife} , then turn around and slice the apple", "knife"),
    ("I don't want the {O tea} , bring the {O pot}", "pot"),
    ("not the {C red} {O cup} , the {C blue} {O bowl}", "bowl{color=blue}"),
    ("the {O cup} that isn't {C red}", "cup"),
    ("the {C red} {O cup} or the {C blue} one", "!two_targets"),
    ("the {C purple} or the {C pink} {O balloon}", "!two_targets"),
    ("a {C purple} or {C pink} {O balloon}", "!two_targets"),
    ("a {C red} and {C white} {O cup}", "cup{color=red and white}"),
    ("the {O jar full of coins} {N beside} the {R piano}", "jar(is-near piano)"),
    ("any {O cup} but the {C red} one", "cup"),
    ("the {O mug instead} of the {R cup}", "mug"),
    ("a {O cup} rather than a {M glass}", "cup"),
    ("instead of the {O cup} bring the {C blue} {O mug}", "mug{color=blue}"),
    ("any {O cup} except the {C red} one", "cup"),
    ("the {O cup} {P on} the {R desk} and the {C red} one", "cup{color=red}(is-on desk)"),
    ("my {O mug} is {A in} the {R office can} you get it", "mug(is-at office)"),
    ("bring the {O picture of} my dog", "picture"),
    ("the {O cup} , not the {C red} one but the {C blue} one", "cup{color=blue}"),
    ("the {O book} is {P on} the {R sofa} , it's {C blue}", "book{color=blue}(is-on sofa)"),
]  # fmt: skip


def shown(marked: str) -> str:
    result = parse_marked(marked)
    return f"!{result.second.kind}" if result.second else show(result.graph)


@pytest.mark.parametrize(("marked", "graph"), INVERSE + TARGETS)
def test_graph(marked: str, graph: str) -> None:
    assert shown(marked) == graph


@pytest.mark.parametrize(("relations", "graphs"), [(0, 1), (1, 1), (2, 2), (3, 5), (4, 14)])
def test_a_chain_has_every_attachment_that_does_not_cross(relations: int, graphs: int) -> None:
    marked = "{".join(CHAIN.split("{")[: 2 + 2 * relations])
    result = parse_marked(marked)
    found = [result.graph, *(one.graph for one in result.readings)]
    assert len({repr(graph) for graph in found}) == len(found) == graphs
    shares = [one.share for one in result.readings]
    assert shares == sorted(shares, reverse=True)
    assert all(0.0 < share < 1.0 for share in shares)
    assert result == parse_marked(marked)


def test_longer_chains_are_bounded() -> None:
    result = parse_marked(CHAIN + " {N near} the {R sink} {P on} the {R floor}" * 20)
    assert len(result.readings) == MAX_READINGS


@pytest.mark.parametrize(
    ("marked", "first", "others"),
    [
        ("the {O cup} {P on} the {R desk} that is {C red}",
         "cup(is-on desk{color=red})", ["cup{color=red}(is-on desk)"]),
        ("the {O cup} {P on} the {R desk} , {C red} and {M plastic}",
         "cup{color=red,material=plastic}(is-on desk)",
         ["cup(is-on desk{color=red,material=plastic})"]),
        ("the {O cup} {P on} the {R desk} , the {C red} one", "cup{color=red}(is-on desk)", []),
        ("the {O cup} with a {R lid} {N near} the {R sink}",
         "cup(is-at^ lid)(is-near sink)", ["cup(is-at^ lid(is-near sink))"]),
        ("the {O vase} with {R flowers} {A from} the {R shelf}",
         "vase(is-at^ flower)(is-at shelf)", ["vase(is-at^ flower(is-at shelf))"]),
    ],
)  # fmt: skip
def test_what_could_hang_elsewhere_is_a_reading(marked: str, first: str, others: list[str]) -> None:
    result = parse_marked(marked)
    assert show(result.graph) == first
    assert [show(one.graph) for one in result.readings] == others


def test_fields_added_later_travel_and_are_left_out_at_their_defaults() -> None:
    cup = ObjectGraph("cup", {}, [Relation("is-at", ObjectGraph("spoon"), inverse=True)])
    full = ParseReply(
        text="x", graph=cup, probabilities=[0.5], readings=[cup], reading_confidences=[0.25],
        reason_kind="",
    )  # fmt: skip
    encoding = codec.encoding_of(ParseReply)
    assert codec.decode(codec.encode(full), encoding) == full
    plain = codec.encode(ParseReply(text="x"))
    assert b"probabilities" not in plain
    assert b"reason_kind" not in plain
    assert codec.decode(plain, encoding) == ParseReply(text="x")
