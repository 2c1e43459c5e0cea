"""Makes the recordings of the evaluation set: resumable, in several processes."""

from __future__ import annotations

import hashlib
import json
import multiprocessing
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import Any

import msgspec

from doro_schemas.errors import Refused
from doro_sim_feeder.recording import TRUTH, write_recording
from doro_sim_feeder.rooms.copies import Unplaced
from doro_sim_feeder.rooms.episode import RoomEpisode, truth_json
from doro_sim_feeder.rooms.evaluation_set import SetRow
from doro_sim_feeder.rooms.truth import TrueInstance
from doro_sim_feeder.rooms.version import generator_version

MANIFEST = "manifest.json"
READ_BYTES = 1 << 20


class RoomTruth(msgspec.Struct, frozen=True):
    """What lies beside a recording, ``<name>.truth.json``.

    Attributes:
        spec: digest of what the recording depends on; sha256: of the recording itself.
        views: number of observations; each instance has the number in which it is visible.
    """

    episode: str
    spec: str
    sha256: str
    views: int
    cells: int
    size_bytes: int
    missing: tuple[Unplaced, ...]
    instances: tuple[TrueInstance, ...]


class Made(msgspec.Struct, frozen=True):
    """A recording of the set that is there now; ``again`` where it was made by this run."""

    row: SetRow
    truth: RoomTruth
    again: bool


class Render(msgspec.Struct, frozen=True):
    """How the recordings are rendered: where to, image size, number of views (None: all)."""

    out: Path
    size_px: int = 300
    views: int | None = None


def make_set(rows: list[SetRow], render: Render, workers: int = 2) -> Iterator[Made]:
    """Make what is not there yet; yield each recording as it is done.

    A recording counts as there if the digest of what it depends on and its own digest are
    those of its ``.truth.json``. Files appear whole, by renaming.

    Raises:
        Refused: the folder cannot be written, or a room cannot be rendered.
    """
    try:
        render.out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise Refused(f"{render.out} cannot be made a folder: {error.strerror}") from error
    todo = []
    for row in rows:
        truth = finished(row, render)
        if truth is None:
            todo.append(row)
        else:
            yield Made(row, truth, again=False)
    if workers <= 1 or len(todo) <= 1:
        for row in todo:
            yield Made(row, make_one(row, render), again=True)
        return
    context = multiprocessing.get_context("spawn")  # a forked Embree scene is not safe
    with ProcessPoolExecutor(min(workers, len(todo)), mp_context=context) as pool:
        futures = {pool.submit(make_one, row, render): row for row in todo}
        try:
            for future in as_completed(futures):
                yield Made(futures[future], future.result(), again=True)
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def make_one(row: SetRow, render: Render) -> RoomTruth:
    """Render one recording and its truth."""
    episode = RoomEpisode(
        row.room,
        seed=row.seed,
        copies=row.spec(),
        views=render.views,
        size_px=render.size_px,
        color=False,
        allow_missing=True,
        name=row.name,
        arrange=row.arrangement(),
    )
    path = render.out / f"{row.name}.mcap"
    metadata = _metadata(row, render, episode)
    write_recording(path, episode.messages(), metadata, lambda: {TRUTH: truth_json(episode)})
    truth = RoomTruth(
        episode=row.name,
        spec=row.digest(render.size_px, render.views),
        sha256=file_digest(path),
        views=len(episode.views),
        cells=len(episode.scene.cells),
        size_bytes=path.stat().st_size,
        missing=episode.missing,
        instances=tuple(episode.truth()),
    )
    write_json(render.out / f"{row.name}.truth.json", truth)
    return truth


def _metadata(row: SetRow, render: Render, episode: RoomEpisode) -> dict[str, str]:
    """Return what is written into the recording; MCAP's metadata are strings."""
    return {
        "source": "rendered",
        "room": row.room,
        "part": row.part,
        "seed": str(row.seed),
        "generator": generator_version(),
        "spec": row.digest(render.size_px, render.views),
        "intrinsics": json.dumps(msgspec.to_builtins(episode.intrinsics)),
    }


def finished(row: SetRow, render: Render) -> RoomTruth | None:
    """Return the truth of a recording that is there and whole, else None."""
    path = render.out / f"{row.name}.mcap"
    truth = read_truth(render.out / f"{row.name}.truth.json")
    if truth is None or truth.spec != row.digest(render.size_px, render.views):
        return None
    if not path.is_file() or path.stat().st_size != truth.size_bytes:
        return None
    return truth if file_digest(path) == truth.sha256 else None


def read_truth(path: Path) -> RoomTruth | None:
    """Return a truth file, None where it is missing or no truth file."""
    try:
        return msgspec.json.decode(path.read_bytes(), type=RoomTruth)
    except (OSError, msgspec.DecodeError):
        return None


def file_digest(path: Path) -> str:
    """Return the SHA-256 of a file."""
    digest = hashlib.sha256()
    with path.open("rb") as stream:
        while chunk := stream.read(READ_BYTES):
            digest.update(chunk)
    return digest.hexdigest()


def write_json(path: Path, content: Any) -> None:
    """Write a JSON file that appears whole."""
    part = path.with_suffix(".json.part")
    part.write_bytes(msgspec.json.format(msgspec.json.encode(content), indent=1) + b"\n")
    part.replace(path)


def write_manifest(plan: list[SetRow], made: list[Made], render: Render, seed: int) -> Path:
    """Write ``manifest.json``: what is in the set, with digests; no times, so that it repeats.

    Args:
        plan: the whole set; what of it was made by an earlier run is listed too.
        made: what this run has made or found.
    """
    known = {one.row.name: one for one in made}
    for row in plan:
        truth = None if row.name in known else finished(row, render)
        if truth is not None:
            known[row.name] = Made(row, truth, again=False)
    ordered = [known[name] for name in sorted(known)]
    rows = [_manifest_row(one) for one in ordered]
    content = {
        "generator": generator_version(),
        "seed": seed,
        "size_px": render.size_px,
        "recordings": rows,
        "digest": hashlib.sha256("".join(row["sha256"] for row in rows).encode()).hexdigest(),
    }
    path = render.out / MANIFEST
    write_json(path, content)
    return path


def _manifest_row(one: Made) -> dict[str, Any]:
    of_class = [i for i in one.truth.instances if i.object_type == one.row.object_type]
    return {
        **msgspec.to_builtins(one.row),
        "views": one.truth.views,
        "sha256": one.truth.sha256,
        "spec": one.truth.spec,
        "size_bytes": one.truth.size_bytes,
        "instances": len(of_class),
        "visible": sum(item.views > 0 for item in of_class),
        "missing": msgspec.to_builtins(one.truth.missing),
    }
