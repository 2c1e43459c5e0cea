"""Runs recordings through the methods: in several processes, resumable, progress by yield.

What a run found is kept under the digest of all that it depends on (recording, error model,
seed, settings, the code of the services and of this package), so that an interrupted or a
repeated evaluation only does what is new.
"""

from __future__ import annotations

import hashlib
import multiprocessing
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from importlib.util import find_spec
from pathlib import Path
from typing import TypeVar

import msgspec

from doro_evaluation.chain import (
    ERROR_MODELS,
    Language,
    Room,
    count_instances,
    false_positives,
    load_room,
)
from doro_evaluation.conceptgraphs import count_like_conceptgraphs
from doro_evaluation.outcomes import Outcome, Thing, found_things, true_things
from doro_mapper.settings import MapperSettings
from doro_nlu.settings import NluSettings
from doro_perception.settings import PerceptionSettings
from doro_schemas.detector_errors import read_pool, write_pool
from doro_schemas.errors import Refused
from doro_schemas.messages import FrameGraphs
from doro_sim_feeder.rooms.make_set import file_digest

Call = TypeVar("Call")
Result = TypeVar("Result")
CONCEPTGRAPHS = "conceptgraphs_like"
SYSTEMS = {"tracks": "ours", "grid": "grid", "paper_literal": "paper_literal"}
"""Name of a system in tables and figures, by the mapper's finder."""
PARTS = {
    "test": ("default", "copies", "extra"),
    "paper": ("default", "copies"),
}
"""What a name stands for that is no part of a set itself."""
DEPENDS_ON = ("doro_schemas", "doro_perception", "doro_nlu", "doro_mapper")
OWN_FILES = ("chain.py", "outcomes.py", "conceptgraphs.py")


class Recorded(msgspec.Struct, frozen=True):
    """A recording of a set: where it is, its part, its digest."""

    path: str
    part: str
    sha256: str

    @property
    def name(self) -> str:
        return Path(self.path).stem


class Context(msgspec.Struct, frozen=True, kw_only=True):
    """What all runs of an evaluation share.

    Attributes:
        pool: file of the false-positive pool; cache: folder of the outcomes.
        code: digest of the code and the models.
        fresh: do not read the cache.
    """

    perception: PerceptionSettings = PerceptionSettings()
    nlu: NluSettings = NluSettings()
    mapper: MapperSettings = MapperSettings()
    pool: str = ""
    cache: str = ""
    code: str = ""
    seed: int = 0
    fresh: bool = False


class Job(msgspec.Struct, frozen=True):
    """A recording and the (finder, error model) pairs to run on it."""

    recording: Recorded
    runs: tuple[tuple[str, str], ...]


def recordings_of(folder: Path, part: str) -> list[Recorded]:
    """Return the recordings of a part (a name of :data:`PARTS`) in a folder, by name.

    Raises:
        Refused: there is none.
    """
    wanted = PARTS.get(part, (part,))
    found = []
    for path in sorted(folder.glob("*.mcap")):
        own = path.stem.split("-FloorPlan")[0]
        if own in wanted:
            found.append(Recorded(str(path), own, file_digest(path)))
    if not found:
        raise Refused(
            f"{folder} has no recording of the part '{part}': make them with"
            f" 'doro rooms set --out {folder}'"
        )
    return found


def spread(recordings: Sequence[Recorded], most: int | None) -> list[Recorded]:
    """Return at most so many recordings, evenly spread over the names."""
    if most is None or most >= len(recordings):
        return list(recordings)
    return [recordings[k * len(recordings) // most] for k in range(most)]


def error_names(text: str) -> list[str]:
    """Return the error models of ``"gt,cs+sd"``.

    Raises:
        Refused: one of them is unknown.
    """
    names = [name.strip() for name in text.split(",") if name.strip()]
    for name in names:
        if name not in ERROR_MODELS:
            raise Refused(f"error model '{name}' is unknown: use {', '.join(ERROR_MODELS)}")
    return names


def make_pool(recordings: Sequence[Recorded], part: str, cache: Path) -> Path:
    """Return the file of the false-positive pool of a part, made where it is not there.

    Test rooms get false positives of other test rooms, validation rooms of validation rooms.
    """
    own = [item for item in recordings if item.part == "default"] or list(recordings)
    digest = hashlib.sha256("".join(item.sha256 for item in own).encode()).hexdigest()[:16]
    path = cache / f"fp_pool-{part}-{digest}.json"
    if not path.is_file():
        cache.mkdir(parents=True, exist_ok=True)
        write_pool(path, false_positives([Path(item.path) for item in own]))
    return path


def code_digest(packages: Sequence[str] = DEPENDS_ON, own_files: Sequence[str] = OWN_FILES) -> str:
    """Return the digest of the code and the models that outcomes depend on."""
    digest = hashlib.sha256()
    for package in packages:
        spec = find_spec(package)
        roots = list(spec.submodule_search_locations or ()) if spec else []
        for root in roots:
            for path in sorted(Path(root).rglob("*")):
                if path.suffix in (".py", ".onnx", ".json"):
                    digest.update(path.name.encode() + path.read_bytes())
    for name in own_files:
        digest.update((Path(__file__).parent / name).read_bytes())
    return digest.hexdigest()


def run_jobs(jobs: Sequence[Job], context: Context, workers: int = 2) -> Iterator[list[Outcome]]:
    """Yield the outcomes of each job as it is done."""
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    if workers <= 1 or len(jobs) <= 1:
        _prepare(context)
        for job in jobs:
            yield _run(job)
        return
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(
        min(workers, len(jobs)), mp_context=spawn, initializer=_prepare, initargs=(context,)
    ) as pool:
        futures = [pool.submit(_run, job) for job in jobs]
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

    @classmethod
    def speak(cls) -> Language:
        """Return perception and nlu, loaded on first use: a cached job needs neither."""
        if cls.language is None:
            pool = read_pool(Path(cls.context.pool)) if cls.context.pool else None
            cls.language = Language(cls.context.perception, cls.context.nlu, pool)
        return cls.language


def _prepare(context: Context) -> None:
    _Worker.context, _Worker.language = context, None


def _run(job: Job) -> list[Outcome]:
    """Return the outcomes of a job; the recording is read only if one of them is new."""
    context = _Worker.context
    found: list[Outcome] = []
    room: Room | None = None
    truth: tuple[Thing, ...] = ()
    graphs: dict[str, list[FrameGraphs]] = {}
    for finder, errors in job.runs:
        kept = Path(context.cache) / f"{job.recording.name}-{_digest(job, finder, errors)}.json"
        outcome = None if context.fresh else _read(kept)
        if outcome is None:
            if room is None:
                room = load_room(Path(job.recording.path))
                truth = true_things(room, context.perception)
            if errors not in graphs:
                models = ERROR_MODELS[errors]
                graphs[errors] = _Worker.speak().graphs(room, models, context.seed)
            outcome = Outcome(
                recording=job.recording.name,
                room=room.room,
                part=job.recording.part,
                system=SYSTEMS.get(finder, finder),
                errors=errors,
                frames=len(room.depths),
                truth=truth,
                found=_count(room, graphs[errors], finder, context.mapper),
            )
            _write(kept, outcome)
        found.append(outcome)
    return found


def _count(
    room: Room, graphs: Sequence[FrameGraphs], finder: str, settings: MapperSettings
) -> tuple[Thing, ...]:
    if finder == CONCEPTGRAPHS:
        return count_like_conceptgraphs(room.depths, graphs)
    chosen = with_finder(settings, finder)
    return found_things(count_instances(room, graphs, chosen).instances)


def with_finder(settings: MapperSettings, finder: str) -> MapperSettings:
    """Return the settings with another finder.

    Raises:
        Refused: the mapper has no such finder.
    """
    fields = {**msgspec.to_builtins(settings), "finder": finder}
    try:
        return msgspec.convert(fields, MapperSettings)
    except msgspec.ValidationError as error:
        raise Refused(f"the mapper has no finder '{finder}': {error}") from error


def _digest(job: Job, finder: str, errors: str) -> str:
    context = _Worker.context
    depends = {
        "recording": job.recording.sha256,
        "run": [finder, errors, context.seed],
        "settings": [context.perception, context.nlu, context.mapper],
        "pool": Path(context.pool).name,
        "code": context.code,
    }
    return hashlib.sha256(msgspec.json.encode(depends)).hexdigest()[:20]


def _read(path: Path) -> Outcome | None:
    """Return a kept outcome; None where it is not there or not whole."""
    try:
        return msgspec.json.decode(path.read_bytes(), type=Outcome)
    except (OSError, msgspec.DecodeError):
        return None


def _write(path: Path, outcome: Outcome) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_suffix(f".{os.getpid()}.part")
    part.write_bytes(msgspec.json.encode(outcome))
    part.replace(path)
