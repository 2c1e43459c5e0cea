"""Bytes on the wire never change within a version; schemas and tables follow the code."""

from __future__ import annotations

import json
from pathlib import Path

import msgpack
import numpy as np
import pytest

from doro_schemas import codec, topics
from doro_schemas.errors import Refused
from doro_schemas.jsonschemas import schema_json
from doro_schemas.messages.base import Message
from tools.examples import examples
from tools.generate import READMES, with_table

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = {codec.schema_name(type(message)): message for message in examples()}


def test_every_message_type_has_an_example() -> None:
    assert {type(message).__name__ for message in examples()} == set(topics.TYPES)


@pytest.mark.parametrize("name", sorted(EXAMPLES))
def test_bytes_equal_the_golden_ones(name: str) -> None:
    golden = (ROOT / "schemas" / "golden" / f"{name}.bin").read_bytes()
    assert codec.encode(EXAMPLES[name]) == golden


@pytest.mark.parametrize("name", sorted(EXAMPLES))
def test_golden_bytes_decode_to_the_example(name: str) -> None:
    golden = (ROOT / "schemas" / "golden" / f"{name}.bin").read_bytes()
    message = codec.decode(golden, codec.encoding_of(type(EXAMPLES[name])))
    assert _fields(message) == _fields(EXAMPLES[name])


@pytest.mark.parametrize("name", sorted(EXAMPLES))
def test_unknown_fields_are_skipped(name: str) -> None:
    kind = type(EXAMPLES[name])
    if kind.SEGMENTS:
        return
    fields = msgpack.unpackb(codec.encode(EXAMPLES[name]))
    fields["from_the_future"] = {"x": [1, 2]}
    message = codec.decode(msgpack.packb(fields), codec.encoding_of(kind))
    assert _fields(message) == _fields(EXAMPLES[name])


@pytest.mark.parametrize("name", sorted(EXAMPLES))
def test_every_cut_of_the_bytes_is_refused(name: str) -> None:
    kind = type(EXAMPLES[name])
    golden = codec.encode(EXAMPLES[name])
    for length in range(0, len(golden) - 16, max(1, len(golden) // 60)):
        with pytest.raises(Refused) as caught:
            codec.decode(golden[:length], codec.encoding_of(kind))
        assert "\n" not in caught.value.reason


@pytest.mark.parametrize("name", sorted(EXAMPLES))
def test_json_schemas_are_committed(name: str) -> None:
    text = (ROOT / "schemas" / "json" / f"{name}.json").read_text(encoding="utf-8")
    assert text == schema_json(name)
    assert json.loads(text)["x-encoding"] == codec.encoding_of(type(EXAMPLES[name]))


@pytest.mark.parametrize("readme", READMES)
def test_topic_table_of_the_readme_is_the_code(readme: str) -> None:
    text = (ROOT / readme).read_text(encoding="utf-8")
    assert topics.markdown_table() in text
    assert with_table(text) == text


def _fields(message: Message) -> dict[str, object]:
    return {
        name: (value.dtype.str, value.tolist()) if isinstance(value, np.ndarray) else value
        for name, value in ((name, getattr(message, name)) for name in message.__struct_fields__)
    }
