"""JSON records of ``doro decide`` and ``doro answer``: read, worked on, never raising."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import msgspec

from doro_dialogue.facts import Candidate
from doro_schemas.errors import Refused
from doro_schemas.graph import ObjectGraph
from doro_schemas.messages.map import Evidence


class RecordInstance(msgspec.Struct):
    """One instance of a record, by the caller's own id; views only for left and right."""

    id: str | int
    graph: ObjectGraph
    evidence: list[Evidence] = []


class SceneRecord(msgspec.Struct, kw_only=True):
    """What every record has: the input graph and the instances found."""

    id: str | int
    graph: ObjectGraph
    instances: list[RecordInstance]
    readings: list[ObjectGraph] = []
    task: str = ""
    unseen_share: float = 0.0

    def candidates(self) -> list[Candidate]:
        """Return the instances as candidates, ids as text."""
        return [Candidate(str(one.id), one.graph, tuple(one.evidence)) for one in self.instances]

    def all_readings(self) -> list[ObjectGraph]:
        """Return the graphs that the instruction may mean, the preferred one first."""
        return [self.graph, *self.readings]

    def own_ids(self) -> dict[str, str | int]:
        """Return the caller's ids by their text."""
        return {str(one.id): one.id for one in self.instances}


R = TypeVar("R", bound=SceneRecord)


def answer_or_error(
    record: dict[str, Any], kind: type[R], example: str, work: Callable[[R], dict[str, Any]]
) -> dict[str, Any]:
    """Return ``work(record)``, or ``{"id", "error"}`` with one sentence where it does not fit.

    Args:
        kind: the record's type.
        example: what a record looks like, for the sentence.
    """
    name = record.get("id") if isinstance(record, dict) else None
    try:
        if isinstance(record, dict) and record.get("graph") is None:
            raise Refused(
                "the record has no graph: the instruction was not given or not understood"
            )
        return work(msgspec.convert(record, kind, strict=True))
    except msgspec.ValidationError as error:
        return {"id": name, "error": f"the record does not fit: {error}; it looks like {example}"}
    except RecursionError:
        return {"id": name, "error": "a graph of the record nests too deep: use fewer landmarks"}
    except Refused as refused:
        return {"id": name, "error": refused.reason}
