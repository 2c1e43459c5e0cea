"""``doro answer``: one record in, one record out, by the code that the service runs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import msgspec

from doro_dialogue.acts import hear
from doro_dialogue.ask_reading import Chosen, choose, compose_split
from doro_dialogue.decision import Decision, decide
from doro_dialogue.facts import Candidate, name_of
from doro_dialogue.question import compose
from doro_dialogue.readings import Split, decide_readings
from doro_dialogue.records import SceneRecord, answer_or_error
from doro_dialogue.reply import (
    Manner,
    Said,
    ask_about,
    ask_reading_again,
    decide_anew,
    reply_to,
)
from doro_dialogue.resolve import Outcome, resolve
from doro_dialogue.scene import Scene, observed_words, read_question
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
    reason: str = ""


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
    candidates = record.candidates()
    manner = Manner(seed, str(record.id), record.task, record.unseen_share)
    read = decide_readings(record.all_readings(), candidates, decide)
    asked = read.split if read.split and _asks_for_reading(record, read.split) else None
    scene = _scene(record, read.decision, candidates, reading=asked is not None)
    words = frozenset(observed_words([one.graph for one in candidates]))
    if asked is not None:
        chosen = choose(asked, record.answer, words)
        if chosen is not None:
            return _result(record, *_read_as(asked, chosen, scene, manner))
    heard = hear(record.answer, name_of(record.graph.name), words)
    outcome = resolve(scene, heard, {text: parse(text) for text in heard.texts})
    if outcome.replaced is not None:
        return _result(record, *decide_anew([outcome.replaced], candidates, manner))
    return _result(record, outcome, reply_to(scene, outcome, manner))


def _result(record: _Record, outcome: Outcome, said: Said) -> dict[str, Any]:
    ids = record.own_ids()
    targets = [ids[one] for one in outcome.targets]
    return {
        "id": record.id,
        "action": outcome.action,
        "target": targets[0] if len(targets) == 1 else None,
        "targets": targets,
        "text": said.text,
    }


def _asks_for_reading(record: _Record, split: Split) -> bool:
    """Tell whether the query of a record is the question for a reading."""
    if isinstance(record.query, _Asked) and record.query.reason:
        return record.query.reason == "readings"
    text = record.query if isinstance(record.query, str) else record.query.text
    return not text or any(wording in text for wording in compose_split(split).wordings)


def _read_as(split: Split, chosen: Chosen, scene: Scene, manner: Manner) -> tuple[Outcome, Said]:
    again = Outcome("ask_again")
    if chosen.how == "reading":
        return decide_anew(chosen.readings, scene.candidates, manner)
    if chosen.how == "any":
        return again, ask_about(scene, scene.ids, manner)
    return again, ask_reading_again(split, manner)


def _scene(
    record: _Record, decision: Decision, candidates: list[Candidate], *, reading: bool
) -> Scene:
    """Return the question as it was put: by its clauses, or as its text names them.

    Args:
        reading: a reading was asked for; those that any reading singles out are offered.
    """
    if reading:
        graphs = {one.id: one.graph for one in candidates}
        groups = [Clause([name], "", graphs[name]) for name in decision.matches]
        return Scene(record.graph, decision.state, "", groups, candidates, ordered=False)
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
    if not text or text in question.wordings:
        groups, ordered = own, True
    else:
        groups, ordered = read_question(text, own, of_class)
    if groups != own and len(groups) == 1:
        state = "INFORM-MISMATCH"
    elif len(groups) > 1:
        state = "INFORM-AMBIGUITY"
    return Scene(record.graph, state, text or question.wordings[0], groups, candidates, ordered)
