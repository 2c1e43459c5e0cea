"""Runs the end-to-end tables: recordings in several processes, what is done is kept.

A system's outcomes on a recording are kept by the digest of what they depend on, so that a
new baseline runs the baseline only.
"""

from __future__ import annotations

import hashlib
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import msgspec

from doro_evaluation import baseline
from doro_evaluation.baseline import configurations
from doro_evaluation.context import Context, Recorded, code_digest
from doro_evaluation.maps import MappedRoom, read_kept, write_kept
from doro_evaluation.queries import bertscore
from doro_evaluation.queries.pairs import Pair
from doro_evaluation.queries.systems import QueryOutcome, run_system
from doro_evaluation.runs import as_done, context_here, speak
from doro_nlu.core import Nlu

BASELINE = "baseline"
OWN_FILES = ("queries/judge.py", "queries/systems.py")
SIMILARITY_FILES = ("queries/bertscore.py", "onnx_files.py", "data/minilm/vocabulary.json")
BASELINE_FILES = tuple(
    f"baseline/{name}"
    for name in (
        "configurations.py",
        "examples.py",
        "judging.py",
        "model.py",
        "reading.py",
        "text.py",
    )
)


class QueryJob(msgspec.Struct, frozen=True):
    """A recording, its pairs, what to run on them, and by system the digest of what it is."""

    recording: Recorded
    pairs: tuple[Pair, ...]
    errors: str
    systems: Mapping[str, str]

    def kept(self, context: Context, system: str) -> Path:
        """Return where a system's outcomes are kept."""
        pairs = hashlib.sha256(msgspec.json.encode(self.pairs)).hexdigest()
        run = (self.errors, system, self.systems[system], pairs)
        digest = context.digest(self.recording, *run)
        return Path(context.cache) / f"queries-{self.recording.name}-{system}-{digest}.json"


def missing_baseline() -> str:
    """Return why the baseline's rows are not there, with the command; empty: they are."""
    return baseline.available()


def jobs_of(
    recordings: Sequence[Recorded], pairs: Sequence[Pair], *, errors: str, systems: Sequence[str]
) -> list[QueryJob]:
    """Return a job for each recording that has pairs; a baseline that is not there is left out."""
    of_room: dict[str, list[Pair]] = defaultdict(list)
    for pair in pairs:
        of_room[pair.episode].append(pair)
    wanted = [name for name in systems if name != BASELINE or not missing_baseline()]
    codes = {name: _code(name) for name in wanted}
    return [
        QueryJob(one, tuple(of_room[one.name]), errors, codes)
        for one in recordings
        if of_room[one.name]
    ]


def run_queries(
    jobs: Sequence[QueryJob], context: Context, workers: int = 2
) -> Iterator[list[QueryOutcome]]:
    """Yield the outcomes of each job as it is done; the order of jobs is not kept."""
    yield from as_done(_run, jobs, context, workers)


def _code(system: str) -> str:
    """Return the digest of what decides, judges and compares, and of the models."""
    own: tuple[str, ...] = OWN_FILES
    if not bertscore.available():
        own += SIMILARITY_FILES
    if system == BASELINE:
        own += BASELINE_FILES
        model = (baseline.MODEL_DIR / "vocabulary.json").read_bytes()
        return code_digest(("doro_dialogue",), own) + hashlib.sha256(model).hexdigest()
    return code_digest(("doro_dialogue",), own)


class _Worker:
    """What a process keeps between jobs."""

    nlu: Nlu | None = None
    model: baseline.Baseline | None = None

    @classmethod
    def parser(cls, context: Context) -> Nlu:
        if cls.nlu is None:
            cls.nlu = Nlu(context.nlu)
        return cls.nlu

    @classmethod
    def trained(cls) -> baseline.Baseline:
        if cls.model is None:
            cls.model = baseline.load()
        return cls.model


def _run(job: QueryJob) -> list[QueryOutcome]:
    context = context_here()
    mapped = MappedRoom(job.recording, context, speak)
    found: list[QueryOutcome] = []
    for system in job.systems:
        kept = job.kept(context, system)
        known = None if context.fresh else read_kept(kept, list[QueryOutcome])
        if known is None:
            known = _compared(_outcomes(job, mapped, system))
            write_kept(kept, known)
        found += known
    return found


def _outcomes(job: QueryJob, mapped: MappedRoom, system: str) -> list[QueryOutcome]:
    nlu = _Worker.parser(mapped.context)
    if system == BASELINE:
        trained = _Worker.trained()
        return configurations.run(mapped, job.pairs, trained, nlu, errors=job.errors)
    return run_system(mapped, job.pairs, nlu, errors=job.errors, system=system)


def _compared(outcomes: list[QueryOutcome]) -> list[QueryOutcome]:
    """Return the outcomes with BERTScore and cosine, where their model is there."""
    if bertscore.available():
        return outcomes
    said = [one.verdict.text for one in outcomes]
    meant = [one.verdict.references for one in outcomes]
    scores, cosines = bertscore.bertscore(said, meant), bertscore.cosine(said, meant)
    return [
        msgspec.structs.replace(one, bertscore=round(score, 6), cosine=round(cosine, 6))
        for one, score, cosine in zip(outcomes, scores, cosines, strict=True)
    ]
