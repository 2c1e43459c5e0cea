"""Runs the end-to-end tables: recordings in several processes, what is done is kept."""

from __future__ import annotations

import hashlib
import multiprocessing
import os
from collections import defaultdict
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path

import msgspec

from doro_evaluation.chain import Language, load_room
from doro_evaluation.pairs import Pair
from doro_evaluation.queries import QueryOutcome, run_room
from doro_evaluation.runs import Recorded, code_digest
from doro_nlu.core import Nlu
from doro_nlu.settings import NluSettings
from doro_schemas.detector_errors import read_pool

DEPENDS_ON = ("doro_schemas", "doro_perception", "doro_nlu", "doro_mapper", "doro_dialogue")
OWN_FILES = ("chain.py", "judge.py", "outcomes.py", "queries.py")


class QueryJob(msgspec.Struct, frozen=True):
    """A recording, its pairs, and what to run on them."""

    recording: Recorded
    pairs: tuple[Pair, ...]
    errors: str
    systems: tuple[str, ...]
    pool: str
    cache: str
    code: str
    fresh: bool = False

    @property
    def kept(self) -> Path:
        """Where the outcomes are kept, by the digest of all that they depend on."""
        depends = [
            self.recording.sha256,
            self.pairs,
            self.errors,
            self.systems,
            Path(self.pool).name,
            self.code,
        ]
        digest = hashlib.sha256(msgspec.json.encode(depends)).hexdigest()[:20]
        return Path(self.cache) / f"queries-{self.recording.name}-{digest}.json"


def jobs_of(
    recordings: Sequence[Recorded],
    pairs: Sequence[Pair],
    *,
    errors: str,
    systems: Sequence[str],
    pool: Path,
    cache: Path,
    fresh: bool = False,
) -> list[QueryJob]:
    """Return a job for each recording that has pairs."""
    of_room: dict[str, list[Pair]] = defaultdict(list)
    for pair in pairs:
        of_room[pair.episode].append(pair)
    code = code_digest(DEPENDS_ON, OWN_FILES)
    return [
        QueryJob(
            one,
            tuple(of_room[one.name]),
            errors,
            tuple(systems),
            str(pool),
            str(cache),
            code,
            fresh,
        )
        for one in recordings
        if of_room[one.name]
    ]


def run_queries(jobs: Sequence[QueryJob], workers: int = 2) -> Iterator[list[QueryOutcome]]:
    """Yield the outcomes of each job as it is done; the order of jobs is not kept."""
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    if workers <= 1:
        yield from map(_run, jobs)
        return
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(workers, mp_context=spawn) as pool:
        futures = [pool.submit(_run, job) for job in jobs]
        try:
            for future in as_completed(futures):
                yield future.result()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


class _Worker:
    """What a process keeps between jobs."""

    language: Language | None = None
    nlu: Nlu | None = None


def _run(job: QueryJob) -> list[QueryOutcome]:
    if not job.fresh:
        try:
            return msgspec.json.decode(job.kept.read_bytes(), type=list[QueryOutcome])
        except (OSError, msgspec.DecodeError):
            pass  # not there or not whole: it is made
    if _Worker.language is None or _Worker.nlu is None:
        pool = read_pool(Path(job.pool)) if job.pool else None
        _Worker.language, _Worker.nlu = Language(pool=pool), Nlu(NluSettings())
    room = load_room(Path(job.recording.path))
    outcomes = run_room(
        room, job.pairs, _Worker.language, _Worker.nlu, errors=job.errors, systems=job.systems
    )
    job.kept.parent.mkdir(parents=True, exist_ok=True)
    part = job.kept.with_suffix(f".{os.getpid()}.part")
    part.write_bytes(msgspec.json.encode(outcomes))
    part.replace(job.kept)
    return outcomes
