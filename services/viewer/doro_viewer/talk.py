"""What of each message goes into the talk: lines of (level, text)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from doro_schemas import messages as m
from doro_schemas.effects import Unanswered
from doro_schemas.messages.base import Message
from doro_viewer.words import short_description

Line = tuple[str, str]
EVIDENCE_PER_CLAUSE = 3


def talk_lines(message: Message) -> list[Line]:
    """Return the lines of a message, none where it says nothing to a person.

    Levels are Rerun's: INFO for talk, WARN for what went wrong, DEBUG for the belief.
    """
    for kind, lines in _LINES:
        if isinstance(message, kind):
            return lines(message)
    return []


def summary(instruction: m.InstructionGraph | None, query: m.Query | None) -> str:
    """Return Markdown of what the talk stands at: what was said, understood and asked."""
    parts: list[str] = []
    said = instruction.text if instruction else query.instruction if query else ""
    parts.append(f"**Person:** {said}")
    if query is not None:
        parts.append(f"**Understood:** {short_description(query.input_graph, 8)}")
        parts.append(f"## {query.text}")
        count = f"{len(query.matches)} of {len(query.instances)} match"
        unseen = f"{query.unseen_share:.0%} of the area not seen"
        parts.append(f"{query.state} ({query.reason}); {count}; {unseen}")
    elif instruction is not None and instruction.graph is not None:
        parts.append(f"**Understood:** {short_description(instruction.graph, 8)}")
    elif instruction is not None:
        parts.append(f"**Not understood:** {instruction.reason}")
    return "\n\n".join(parts)


def _instruction(message: m.InstructionGraph) -> list[Line]:
    heard: Line = ("INFO", f"Person: {message.text}")
    if message.graph is None:
        return [heard, ("WARN", f"Not understood: {message.reason}")]
    readings = "".join(f"; or: {short_description(graph, 8)}" for graph in message.readings)
    graph = short_description(message.graph, 8)
    return [heard, ("INFO", f"Understood: {graph}{readings}")]


def _query(message: m.Query) -> list[Line]:
    revised = f", revision {message.revision}" if message.revision else ""
    lines: list[Line] = [
        ("INFO", f"Robot: {message.text}"),
        ("INFO", f"{message.state} ({message.reason}{revised})"),
    ]
    for clause in message.clauses:
        views = "; ".join(_view(view) for view in clause.evidence[:EVIDENCE_PER_CLAUSE])
        seen = views or "no view kept"
        ids = ", ".join(clause.instance_ids)
        lines.append(("INFO", f"{ids} = {clause.text}: {seen}"))
    return lines


def _view(view: m.Evidence) -> str:
    xmin, ymin, xmax, ymax = (round(value) for value in view.box_px)
    caption = f" '{view.caption}'" if view.caption else ""
    return f"{view.camera} frame {view.frame} box {xmin},{ymin}-{xmax},{ymax}{caption}"


def _belief(message: m.Belief) -> list[Line]:
    ids = ", ".join(message.matches) or "none"
    count = len(message.instances)
    text = f"So far {message.state} ({message.reason}): {count} seen, matching: {ids}"
    return [("DEBUG", text)]


def _exploration(message: m.Exploration) -> list[Line]:
    room = f" of {message.room}" if message.room else ""
    return [("INFO", f"Exploration{room} {message.state}")]


def _rejected(message: m.Rejected) -> list[Line]:
    return [("WARN", f"{message.service} refused {message.key}: {message.reason}")]


_LINES: tuple[tuple[type[Message], Callable[[Any], list[Line]]], ...] = (
    (m.InstructionGraph, _instruction),
    (m.Query, _query),
    (m.Belief, _belief),
    (m.Exploration, _exploration),
    (m.Rejected, _rejected),
    (m.Answer, lambda answer: [("INFO", f"Person: {answer.text}")]),
    (m.Target, lambda target: [("INFO", f"Target: {target.instance_id}")]),
    (Unanswered, lambda lost: [("WARN", lost.reason)]),
)
