"""``doro decide``: one record in, one record out, by the code that the service runs."""

from __future__ import annotations

from typing import Any

from doro_dialogue.ask_reading import compose_read
from doro_dialogue.decision import decide
from doro_dialogue.decision import paper_literal as by_the_paper
from doro_dialogue.question import pick
from doro_dialogue.readings import Read, decide_readings
from doro_dialogue.records import SceneRecord, answer_or_error

EXAMPLE = '{"id": "1", "graph": {"name": "cup"}, "instances": [{"id": "a", "graph": {...}}]}'


def decide_record(
    record: dict[str, Any], *, paper_literal: bool = False, seed: int = 0, wordings: bool = False
) -> dict[str, Any]:
    """Decide one record.

    Args:
        record: ``{"id", "graph", "instances": [{"id", "graph"}]}``; ``readings`` (other graphs
            that the instruction may mean), ``task`` and ``unseen_share`` may be given, and by
            instance ``evidence``, as in Instance, for left and right.
        paper_literal: decide by the paper's formulas as printed.
        seed: chooses the wording, together with the record's id.
        wordings: also return every wording, as ``wordings``.

    Returns:
        ``{"id", "state", "matches", "reason", "text"}``, or ``{"id", "error"}`` with one
        sentence where the record does not fit. Nothing is raised.
    """

    def work(parsed: SceneRecord) -> dict[str, Any]:
        seen = parsed.candidates()
        if paper_literal:
            read = Read(by_the_paper(parsed.graph, seen))
        else:
            read = decide_readings(parsed.all_readings(), seen, decide)
        question = compose_read(read, task=parsed.task, unseen_share=parsed.unseen_share)
        ids = parsed.own_ids()
        result = {
            "id": parsed.id,
            "state": read.decision.state,
            "matches": [ids[one] for one in read.decision.matches],
            "reason": read.decision.reason,
            "text": pick(question.wordings, seed, str(parsed.id)),
        }
        return {**result, "wordings": question.wordings} if wordings else result

    return answer_or_error(record, SceneRecord, EXAMPLE, work)
