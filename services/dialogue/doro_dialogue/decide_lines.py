"""``doro decide``: one record in, one record out, by the code that the service runs."""

from __future__ import annotations

from typing import Any

from doro_dialogue import decision as rules
from doro_dialogue.question import compose, pick
from doro_dialogue.records import SceneRecord, answer_or_error

EXAMPLE = '{"id": "1", "graph": {"name": "cup"}, "instances": [{"id": "a", "graph": {...}}]}'


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

    def work(parsed: SceneRecord) -> dict[str, Any]:
        rule = rules.paper_literal if paper_literal else rules.decide
        decision = rule(parsed.graph, parsed.candidates())
        question = compose(decision, task=parsed.task, unseen_share=parsed.unseen_share)
        ids = parsed.own_ids()
        return {
            "id": parsed.id,
            "state": decision.state,
            "matches": [ids[one] for one in decision.matches],
            "reason": decision.reason,
            "text": pick(question.wordings, seed, str(parsed.id)),
        }

    return answer_or_error(record, SceneRecord, EXAMPLE, work)
