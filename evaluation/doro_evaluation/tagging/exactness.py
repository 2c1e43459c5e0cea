"""Graph exactness: is the whole graph of an instruction right? On hand-written instructions.

``data/instructions.jsonl`` holds a hundred instructions as people say them, with the graph, or the
kind of reason, that the annotation guide and the design ask for. They were written before any
tagger or parser had seen them (79 and 78 right then); the parser was mended with them since, no
expectation was changed. ``data/instructions-fresh.jsonl`` holds 26 that were written afterwards.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Protocol

import msgspec

from doro_schemas.errors import Refused
from doro_schemas.graph import ObjectGraph
from doro_schemas.messages import ParseReply

INSTRUCTIONS = Path(__file__).parents[1] / "data" / "instructions.jsonl"
FRESH = INSTRUCTIONS.with_name("instructions-fresh.jsonl")
"""26 more, written when the parser was done."""


class Parser(Protocol):
    """What reads a text; the core of nlu does."""

    def parse_text(self, text: str, *, caption: bool = False) -> ParseReply:
        """Return the graph of a text, or the reason why there is none."""
        ...


class Row(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """An instruction with what is expected: ``graph``, or without one ``reason_kind``."""

    id: str
    text: str
    graph: ObjectGraph | None = None
    reason_kind: str = ""


class Failure(msgspec.Struct, frozen=True):
    """An instruction that was read in another way; both sides as JSON, or ``not: <kind>``."""

    id: str
    text: str
    expected: str
    got: str


def read_rows(path: Path = INSTRUCTIONS) -> list[Row]:
    """Return the rows of a JSON-lines file.

    Raises:
        Refused: a line that is no row; the sentence names it.
    """
    rows = []
    for number, line in enumerate(path.read_bytes().splitlines(), 1):
        try:
            rows.append(msgspec.json.decode(line, type=Row))
        except msgspec.DecodeError as error:
            raise Refused(f"{path.name}, line {number}: {error}") from error
    return rows


def graph_exactness(nlu: Parser, rows: Iterable[Row]) -> tuple[int, list[Failure]]:
    """Return how many rows are wholly right, and the others.

    A graph is right when names, attributes, relations and landmarks are equal, whatever the order
    of relations; a refusal when its kind is equal.
    """
    right = 0
    failures: list[Failure] = []
    for row in rows:
        reply = nlu.parse_text(row.text)
        expected = _shown(row.graph, row.reason_kind)
        got = _shown(reply.graph, reply.reason_kind)
        if expected == got:
            right += 1
        else:
            failures.append(Failure(row.id, row.text, expected, got))
    return right, failures


def _shown(graph: ObjectGraph | None, kind: str) -> str:
    return f"not: {kind}" if graph is None else json.dumps(_ordered(graph), sort_keys=True)


def _ordered(graph: ObjectGraph) -> dict[str, object]:
    """Return a graph as plain data in which the order of relations does not count."""
    relations: Sequence[dict[str, object]] = [
        {"type": one.type, "inverse": one.inverse, "target": _ordered(one.target)}
        for one in graph.relations
    ]
    ordered = sorted(relations, key=lambda one: json.dumps(one, sort_keys=True))
    return {"name": graph.name, "attributes": graph.attributes, "relations": ordered}
