"""Runs the end-to-end tables: recordings in several processes, what is done is kept."""

from __future__ import annotations

import hashlib
from collections import defaultdict
from collections.abc import Iterator, Sequence
from pathlib import Path

import msgspec

from doro_evaluation.context import Context, Recorded, code_digest
from doro_evaluation.maps import MappedRoom, read_kept, write_kept
from doro_evaluation.pairs import Pair
from doro_evaluation.queries import QueryOutcome, run_room
from doro_evaluation.runs import as_done, context_here, speak
from doro_nlu.core import Nlu

OWN_FILES = ("judge.py", "queries.py")


class QueryJob(msgspec.Struct, frozen=True):
    """A recording, its pairs, what to run on them, and the digest of what decides and judges."""

    recording: Recorded
    pairs: tuple[Pair, ...]
    errors: str
    systems: tuple[str, ...]
    code: str

    def kept(self, context: Context) -> Path:
        """Return where the outcomes are kept, by the digest of all that they depend on."""
        pairs = hashlib.sha256(msgspec.json.encode(self.pairs)).hexdigest()
        digest = context.digest(self.recording, self.errors, self.systems, self.code, pairs)
        return Path(context.cache) / f"queries-{self.recording.name}-{digest}.json"


def jobs_of(
    recordings: Sequence[Recorded], pairs: Sequence[Pair], *, errors: str, systems: Sequence[str]
) -> list[QueryJob]:
    """Return a job for each recording that has pairs."""
    of_room: dict[str, list[Pair]] = defaultdict(list)
    for pair in pairs:
        of_room[pair.episode].append(pair)
    code = code_digest(("doro_dialogue",), OWN_FILES)
    return [
        QueryJob(one, tuple(of_room[one.name]), errors, tuple(systems), code)
        for one in recordings
        if of_room[one.name]
    ]


def run_queries(
    jobs: Sequence[QueryJob], context: Context, workers: int = 2
) -> Iterator[list[QueryOutcome]]:
    """Yield the outcomes of each job as it is done; the order of jobs is not kept."""
    yield from as_done(_run, jobs, context, workers)


class _Worker:
    """What a process keeps between jobs."""

    nlu: Nlu | None = None


def _run(job: QueryJob) -> list[QueryOutcome]:
    context = context_here()
    kept = job.kept(context)
    known = None if context.fresh else read_kept(kept, list[QueryOutcome])
    if known is not None:
        return known
    if _Worker.nlu is None:
        _Worker.nlu = Nlu(context.nlu)
    mapped = MappedRoom(job.recording, context, speak)
    outcomes = run_room(mapped, job.pairs, _Worker.nlu, errors=job.errors, systems=job.systems)
    write_kept(kept, outcomes)
    return outcomes
