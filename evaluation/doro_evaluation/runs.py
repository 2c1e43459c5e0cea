"""Runs recordings through the methods: in several processes, resumable, progress by yield.

What a run found is kept under the digest of all that it depends on (recording, error model,
seed, settings, the code of the services and of this package), so that an interrupted or a
repeated evaluation only does what is new.
"""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import TypeVar

import msgspec

from doro_evaluation.chain import Language
from doro_evaluation.context import (
    PARTS,
    SYSTEMS,
    Context,
    Recorded,
    code_digest,
    error_names,
    make_pool,
    recordings_of,
    spread,
    with_finder,
)
from doro_evaluation.maps import CONCEPTGRAPHS, MappedRoom
from doro_evaluation.outcomes import Outcome
from doro_schemas.detector_errors import read_pool

__all__ = [
    "CONCEPTGRAPHS",
    "PARTS",
    "SYSTEMS",
    "Context",
    "Job",
    "Recorded",
    "code_digest",
    "error_names",
    "in_processes",
    "make_pool",
    "recordings_of",
    "run_jobs",
    "spread",
    "with_finder",
]

Call = TypeVar("Call")
Result = TypeVar("Result")


class Job(msgspec.Struct, frozen=True):
    """A recording and the (finder, error model) pairs to run on it."""

    recording: Recorded
    runs: tuple[tuple[str, str], ...]


def run_jobs(jobs: Sequence[Job], context: Context, workers: int = 2) -> Iterator[list[Outcome]]:
    """Yield the outcomes of each job as it is done."""
    yield from as_done(run_job, jobs, context, workers)


def as_done(
    function: Callable[[Call], Result], calls: Sequence[Call], context: Context, workers: int
) -> Iterator[Result]:
    """Yield the results of calls as they are done, from processes that share a context.

    Each process has one thread and loads perception and nlu once (:func:`speak`).
    """
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    if workers <= 1 or len(calls) <= 1:
        prepare(context)
        for call in calls:
            yield function(call)
        return
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(
        min(workers, len(calls)), mp_context=spawn, initializer=prepare, initargs=(context,)
    ) as pool:
        futures = [pool.submit(function, call) for call in calls]
        try:
            for future in as_completed(futures):
                yield future.result()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def in_processes(
    function: Callable[[Call], Result], calls: Sequence[Call], workers: int
) -> Iterator[Result]:
    """Yield the results of calls in their order, from several processes with one thread each."""
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    if workers <= 1 or len(calls) <= 1:
        yield from map(function, calls)
        return
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(min(workers, len(calls)), mp_context=spawn) as pool:
        yield from pool.map(function, calls)


class _Worker:
    """What a process keeps between jobs."""

    context: Context = Context()
    language: Language | None = None


def prepare(context: Context) -> None:
    """Give a process the context of the jobs to come."""
    _Worker.context, _Worker.language = context, None


def context_here() -> Context:
    """Return the context of this process."""
    return _Worker.context


def speak() -> Language:
    """Return this process' perception and nlu, loaded on first use: a kept job needs neither."""
    if _Worker.language is None:
        context = _Worker.context
        pool = read_pool(Path(context.pool)) if context.pool else None
        _Worker.language = Language(context.perception, context.nlu, pool)
    return _Worker.language


def run_job(job: Job) -> list[Outcome]:
    """Return the outcomes of a job; the recording is read only if one of them is new."""
    room = MappedRoom(job.recording, _Worker.context, speak)
    return [room.outcome(finder, errors) for finder, errors in job.runs]
