"""The (recording, instruction) pairs of the end-to-end tables (paper, Section V-D: 600)."""

from __future__ import annotations

import hashlib
from collections import defaultdict
from pathlib import Path

import msgspec

from doro_evaluation.context import PARTS
from doro_schemas.errors import Refused
from doro_schemas.graph import ObjectGraph
from doro_sim_feeder.rooms.expressions import KINDS

PAIRS = 600
REFERENCES = ".references.jsonl"


class Pair(msgspec.Struct, frozen=True):
    """What is read of a line of ``<recording>.references.jsonl``.

    Attributes:
        episode: the recording's name.
        kind: the paper's type: ``self``, ``self_relation``, ``name``.
        variant: ``true`` of an instance, ``other_value``, or ``absent``.
        graph: the true input graph of the instruction.
    """

    id: str
    episode: str
    kind: str
    variant: str
    instruction: str
    task: str
    graph: ObjectGraph


def select_pairs(folder: Path, part: str, seed: int, count: int = PAIRS) -> list[Pair]:
    """Return pairs of a part of the set, a third of each kind, drawn by seed; in order of id.

    Args:
        folder: as ``doro rooms set`` made it.
        part: ``test`` (rooms as they are and with copies, not ``extra``) or ``validation``.

    Raises:
        Refused: no instructions are there.
    """
    wanted = PARTS["paper"] if part == "test" else (part,)
    by_kind: dict[str, list[Pair]] = defaultdict(list)
    for path in sorted(folder.glob(f"*{REFERENCES}")):
        if path.name.split("-FloorPlan")[0] in wanted:
            for line in path.read_bytes().splitlines():
                pair = msgspec.json.decode(line, type=Pair)
                by_kind[pair.kind].append(pair)
    if not by_kind:
        raise Refused(
            f"{folder} has no instructions of the part '{part}': make the set with"
            f" 'doro rooms set --out {folder}'"
        )
    chosen: list[Pair] = []
    for index, kind in enumerate(KINDS):
        share = count // len(KINDS) + (index < count % len(KINDS))
        chosen += sorted(by_kind[kind], key=lambda pair: _draw(seed, pair.id))[:share]
    return sorted(chosen, key=lambda pair: pair.id)


def _draw(seed: int, name: str) -> bytes:
    """Return a number that stands for the seed and the name, the same on every machine."""
    return hashlib.sha256(f"{seed}|{name}".encode()).digest()
