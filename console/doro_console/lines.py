"""``doro parse``, ``decide`` and ``answer``: JSON lines in and out, by the services' cores."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator
from typing import IO, Any

import msgspec

from doro_dialogue.answer_lines import answer_record
from doro_dialogue.decide_lines import decide_record
from doro_nlu.core import Nlu
from doro_nlu.from_conllu import parse_conllu
from doro_nlu.settings import NluSettings
from doro_schemas.errors import Refused
from doro_schemas.messages import ParseReply
from doro_schemas.settings import load_settings

Record = dict[str, Any]


def parse_record(nlu: Nlu, record: Record, *, caption: bool, labels: bool = False) -> Record:
    """Return ``{"id", "graph", ...}`` of one ``{"id", "text"}``; graph is None with a reason.

    Args:
        caption: the text is a caption, not an instruction.
        labels: add ``tokens``, ``labels`` and ``probabilities``.
    """
    name, text = record.get("id"), record.get("text")
    if not isinstance(text, str):
        reason = "the record has no text"
        return {"id": name, "graph": None, "reason": reason, "reason_kind": "refused"}
    try:
        parsed = nlu.parse_text(text, caption=caption)
    except Refused as refused:
        reason = refused.reason
        return {"id": name, "graph": None, "reason": reason, "reason_kind": "refused"}
    return _parsed_record(name, parsed, labels=labels)


def parse_trees(source: IO[str], *, caption: bool, labels: bool) -> Iterator[Record]:
    """Yield the record of every sentence of a CoNLL-U text; no tagger is loaded.

    Raises:
        Refused: the text is no CoNLL-U; the line is named.
    """
    try:
        text = source.read()
    except UnicodeDecodeError as error:
        raise Refused(f"CoNLL-U must be UTF-8: {error}") from error
    for sentence in parse_conllu(text, caption=caption):
        yield _parsed_record(sentence.id, sentence.reply, labels=labels)


def _parsed_record(name: object, parsed: ParseReply, *, labels: bool) -> Record:
    answer: Record = {"id": name, "graph": msgspec.to_builtins(parsed.graph)}
    if parsed.reason:
        answer["reason"], answer["reason_kind"] = parsed.reason, parsed.reason_kind
    if parsed.readings:
        answer["readings"] = msgspec.to_builtins(parsed.readings)
        answer["reading_confidences"] = [round(one, 4) for one in parsed.reading_confidences]
    answer |= {"task": parsed.task, "confidence": round(parsed.confidence, 4)}
    if labels:
        answer |= {"tokens": parsed.tokens, "labels": parsed.labels}
        answer["probabilities"] = [round(one, 4) for one in parsed.probabilities]
    return answer


def decide_line(
    nlu: Nlu, record: Record, *, paper_literal: bool, seed: int, wordings: bool = False
) -> Record:
    """Return the decision of one record; an ``instruction`` is parsed first."""
    record = _with_graph(nlu, record)
    if "graph" not in record and "error" in record:
        return record
    return decide_record(record, paper_literal=paper_literal, seed=seed, wordings=wordings)


def answer_line(nlu: Nlu, record: Record, *, seed: int) -> Record:
    """Return what an answer comes to; instruction and answer are parsed by the same nlu."""
    record = _with_graph(nlu, record)
    if "graph" not in record and "error" in record:
        return record
    return answer_record(record, lambda text: nlu.parse_text(text).graph, seed=seed)


def _with_graph(nlu: Nlu, record: Record) -> Record:
    """Return the record with the graph of its ``instruction``, or an ``error`` record."""
    if record.get("graph") is not None or "instruction" not in record:
        return record
    name = record.get("id")
    parsed = parse_record(nlu, {"id": name, "text": record["instruction"]}, caption=False)
    if parsed["graph"] is None:
        return {"id": name, "error": parsed["reason"]}
    readings = parsed.get("readings", [])
    return {**record, "graph": parsed["graph"], "readings": readings, "task": parsed["task"]}


def load_nlu(overrides: Iterable[str]) -> Nlu:
    """Return nlu's core with its model."""
    return Nlu(load_settings("nlu", NluSettings, None, list(overrides)))


def run_lines(source: IO[str], target: IO[str], answer: Callable[[Record], Record]) -> int:
    """Answer every JSON line; a line that is none gives an ``error`` line. Return the count."""
    count = 0
    for number, record in _records(source):
        result = (
            answer(record)
            if record is not None
            else {"id": None, "error": f"line {number} is no JSON object"}
        )
        line = json.dumps(result, ensure_ascii=False)
        # An id may hold half a surrogate pair ("\ud800"), which no file can take as it is.
        target.write(line.encode("utf-8", "replace").decode() + "\n")
        target.flush()
        count += 1
    return count


def _records(source: IO[str]) -> Iterator[tuple[int, Record | None]]:
    for number, line in enumerate(source, 1):
        if not line.strip():
            continue
        try:
            record = json.loads(line)
        except (ValueError, RecursionError):
            record = None
        yield number, record if isinstance(record, dict) else None
