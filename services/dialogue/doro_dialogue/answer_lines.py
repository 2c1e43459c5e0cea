"""``doro answer``: one record in, one record out, by the code that the service runs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import msgspec

from doro_dialogue.acts import hear
from doro_dialogue.decision import Decision, decide
from doro_dialogue.facts import Candidate, name_of
from doro_dialogue.question import compose
from doro_dialogue.records import SceneRecord, answer_or_error
from doro_dialogue.reply import Manner, decide_anew, reply_to
from doro_dialogue.resolve import resolve
from doro_dialogue.scene import Scene, read_question
from doro_schemas.errors import Refused
from doro_schemas.graph import ObjectGraph
from doro_schemas.messages.talk import Clause, State

EXAMPLE = (
    '{"id": "1", "graph": {"name": "cup"}, "instances": [{"id": "a", "graph": {...}}],'
    ' "query": "I found ...; which one do you mean?", "answer": "the red one"}'
)
Parse = Callable[[str], ObjectGraph | None]


class _Asked(msgspec.Struct):
    """A Query, as it travels."""

    text: str
    clauses: list[Clause] = []
    state: State | None = None


class _Record(SceneRecord, kw_only=True):
    answer: str
    query: str | _Asked = ""


def answer_record(record: dict[str, Any], parse: Parse, *, seed: int = 0) -> dict[str, Any]:
    """Understand one answer.

    Args:
        record: ``{"id", "graph", "instances", "query", "answer"}``; ``query`` is the text
            that was asked, or a Query; ``task`` and ``unseen_share`` may be given.
        parse: nlu's parser: the graph of a text, or None.
        seed: chooses the wording, together with the record's id.

    Returns:
        ``{"id", "action", "target", "targets", "text"}``, or ``{"id", "error"}`` with one
        sentence where the record does not fit. Nothing is raised.
    """

    def work(parsed: _Record) -> dict[str, Any]:
        if not parsed.answer.strip():
            raise Refused("the answer is empty: give what the person said")
        return _answer(parsed, parse, seed)

    return answer_or_error(record, _Record, EXAMPLE, work)


def _answer(record: _Record, parse: Parse, seed: int) -> dict[str, Any]:
    ids, candidates = record.own_ids(), record.candidates()
    scene = _scene(record, decide(record.graph, candidates), candidates)
    heard = hear(record.answer, name_of(record.graph.name))
    outcome = resolve(scene, heard, {text: parse(text) for text in heard.texts})
    manner = Manner(seed, str(record.id), record.task, record.unseen_share)
    if outcome.replaced is not None:
        outcome, said = decide_anew(outcome.replaced, candidates, manner)
    else:
        said = reply_to(scene, outcome, manner)
    targets = [ids[one] for one in outcome.targets]
    return {
        "id": record.id,
        "action": outcome.action,
        "target": targets[0] if len(targets) == 1 else None,
        "targets": targets,
        "text": said.text,
    }


def _scene(record: _Record, decision: Decision, candidates: list[Candidate]) -> Scene:
    """Return the question as it was put: by its clauses, or as its text names them."""
    question = compose(decision, task=record.task, unseen_share=record.unseen_share)
    own = [Clause(part.instance_ids, part.text, part.graph) for part in question.parts]
    asked = record.query
    state = decision.state
    if isinstance(asked, _Asked) and asked.clauses:
        known = {one.id for one in candidates}
        for clause in asked.clauses:
            if lost := [one for one in clause.instance_ids if one not in known]:
                raise Refused(f"the query names '{lost[0]}', which is not among the instances")
        return Scene(record.graph, asked.state or state, asked.text, asked.clauses, candidates)
    text = asked if isinstance(asked, str) else asked.text
    of_class = [one.candidate for one in decision.judged]
    groups, ordered = read_question(text, own, of_class) if text else (own, not text)
    if groups != own and len(groups) == 1:
        state = "INFORM-MISMATCH"
    elif len(groups) > 1:
        state = "INFORM-AMBIGUITY"
    return Scene(record.graph, state, text or question.wordings[0], groups, candidates, ordered)
