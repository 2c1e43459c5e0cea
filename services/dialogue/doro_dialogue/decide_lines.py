"""``doro decide``: one record in, one record out, by the code that the service runs."""

from __future__ import annotations

from typing import Any

import msgspec

from doro_dialogue import decision as rules
from doro_dialogue.facts import Candidate
from doro_dialogue.question import compose, pick
from doro_schemas.errors import Refused
from doro_schemas.graph import ObjectGraph

EXAMPLE = '{"id": "1", "graph": {"name": "cup"}, "instances": [{"id": "a", "graph": {...}}]}'


class _Instance(msgspec.Struct):
    id: str | int
    graph: ObjectGraph


class _Record(msgspec.Struct):
    id: str | int
    graph: ObjectGraph
    instances: list[_Instance]
    task: str = ""
    unseen_share: float = 0.0


def decide_record(
    record: dict[str, Any], *, paper_literal: bool = False, seed: int = 0
) -> dict[str, Any]:
    """Decide one record.

    Args:
        record: ``{"id", "graph", "instances": [{"id", "graph"}]}``; ``task`` and
            ``unseen_share`` may be given.
        paper_literal: decide by the paper's formulas as printed.
        seed: chooses the wording, together with the record's id.

    Returns:
        ``{"id", "state", "matches", "reason", "text"}``, or ``{"id", "error"}`` with one
        sentence where the record does not fit. Nothing is raised.
    """
    name = record.get("id") if isinstance(record, dict) else None
    try:
        if isinstance(record, dict) and record.get("graph") is None:
            raise Refused(
                "the record has no graph: the instruction was not given or not understood"
            )
        parsed = msgspec.convert(record, _Record, strict=True)
        ids = {str(one.id): one.id for one in parsed.instances}
        candidates = [Candidate(str(one.id), one.graph) for one in parsed.instances]
        rule = rules.paper_literal if paper_literal else rules.decide
        decision = rule(parsed.graph, candidates)
    except msgspec.ValidationError as error:
        return {"id": name, "error": f"the record does not fit: {error}; it looks like {EXAMPLE}"}
    except RecursionError:
        return {"id": name, "error": "a graph of the record nests too deep: use fewer landmarks"}
    except Refused as refused:
        return {"id": name, "error": refused.reason}
    question = compose(decision, task=parsed.task, unseen_share=parsed.unseen_share)
    return {
        "id": name,
        "state": decision.state,
        "matches": [ids[one] for one in decision.matches],
        "reason": decision.reason,
        "text": pick(question.wordings, seed, str(name)),
    }
