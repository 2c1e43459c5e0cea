"""The console's JSON lines and small parts, in process."""

from __future__ import annotations

import io
import json

import pytest

from doro_console.lines import decide_line, load_nlu, parse_record, run_lines
from doro_console.processes import _quoted
from doro_console.zenoh_codec import decode
from doro_nlu.core import Nlu
from doro_schemas import codec
from doro_schemas.errors import Refused
from tools.examples import examples


@pytest.fixture(scope="module")
def nlu() -> Nlu:
    return load_nlu(())


def test_parse_lines(nlu: Nlu) -> None:
    source = io.StringIO(
        '{"id": 1, "text": "bring me the red cup"}\n\nnonsense\n[1]\n{"id": 4}\n'
        '{"id": "e", "text": ""}\n'
    )
    target = io.StringIO()
    count = run_lines(source, target, lambda one: parse_record(nlu, one, caption=False))
    answers = [json.loads(line) for line in target.getvalue().splitlines()]
    assert count == len(answers) == 5
    assert answers[0]["id"] == 1
    assert answers[0]["graph"] == {"name": "cup", "attributes": {"color": "red"}, "relations": []}
    assert answers[1] == {"id": None, "error": "line 3 is no JSON object"}
    assert answers[2] == {"id": None, "error": "line 4 is no JSON object"}
    no_text = {"graph": None, "reason": "the record has no text", "reason_kind": "refused"}
    assert answers[3] == {"id": 4, **no_text}
    assert answers[4]["graph"] is None
    assert answers[4]["reason"]


CUPS = [
    {"id": "a", "graph": {"name": "cup", "attributes": {"color": "red"}, "relations": []}},
    {"id": "b", "graph": {"name": "cup", "attributes": {"color": "blue"}, "relations": []}},
]


@pytest.mark.parametrize(
    ("record", "state", "matches"),
    [
        ({"instruction": "bring me the red cup"}, "CONFIRM", ["a"]),
        ({"instruction": "bring me the cup"}, "INFORM-AMBIGUITY", ["a", "b"]),
        ({"graph": {"name": "cup", "attributes": {"color": "blue"}}}, "CONFIRM", ["b"]),
        ({"instruction": "find the vase"}, "INFORM-MISSING", []),
    ],
)
def test_decide_lines(nlu: Nlu, record: dict[str, object], state: str, matches: list[str]) -> None:
    instances = CUPS if state != "INFORM-MISSING" else []
    answer = decide_line(
        nlu, {"id": 7, "instances": instances, **record}, paper_literal=False, seed=0
    )
    assert answer["id"] == 7
    assert (answer["state"], answer["matches"]) == (state, matches)
    assert answer["text"]


def test_an_instruction_that_is_not_understood_is_an_error_line(nlu: Nlu) -> None:
    record = {"id": 1, "instruction": "hello there", "instances": CUPS}
    assert set(decide_line(nlu, record, paper_literal=False, seed=0)) == {"id", "error"}


def test_zenoh_cli_prints_plain_and_segmented_messages() -> None:
    for message in examples():
        shown = json.loads(decode("key", codec.encode(message)))
        assert shown["stamp_ns"] == message.stamp_ns
    with pytest.raises(ValueError, match="no message of the wire"):
        decode("key", b"plain text")


def test_arguments_for_supervisord_are_quoted() -> None:
    assert _quoted('a "b" c') == '"a \\"b\\" c"'
    with pytest.raises(Refused, match="line break"):
        _quoted("a\nb")
