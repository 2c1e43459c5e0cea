"""What runs share: which recordings, which settings, and the digest of all they depend on."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

import msgspec

from doro_evaluation.chain import ERROR_MODELS, false_positives
from doro_mapper.settings import MapperSettings
from doro_nlu.settings import NluSettings
from doro_perception.settings import PerceptionSettings
from doro_schemas.detector_errors import write_pool
from doro_schemas.errors import Refused
from doro_sim_feeder.rooms.make_set import file_digest

SYSTEMS = {"tracks": "ours", "grid": "grid", "paper_literal": "paper_literal"}
"""Name of a system in tables and figures, by the mapper's finder."""
PARTS = {
    "test": ("default", "copies", "extra"),
    "paper": ("default", "copies"),
}
"""What a name stands for that is no part of a set itself."""
DEPENDS_ON = ("doro_schemas", "doro_perception", "doro_nlu", "doro_mapper")
OWN_FILES = ("chain.py", "outcomes.py", "counting/conceptgraphs.py", "maps.py")
LEFT_OUT = ("train", "captioner")
"""Folders that no outcome depends on: training, and the detector that the oracle stands for."""


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

    def digest(self, recording: Recorded, *run: object) -> str:
        """Return the digest of all that a run on a recording depends on."""
        depends = {
            "recording": recording.sha256,
            "run": [*run, self.seed],
            "settings": [self.perception, self.nlu, self.mapper],
            "pool": Path(self.pool).name,
            "code": self.code,
        }
        return hashlib.sha256(msgspec.json.encode(depends)).hexdigest()[:20]


def room_of(recording: str) -> str:
    """Return iTHOR's room of a recording's name: ``copies-FloorPlan10-Bottle`` -> FloorPlan10."""
    parts = recording.split("-")
    return next((part for part in parts if part.startswith("FloorPlan")), recording)


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
                inner = path.relative_to(root).parts
                if path.suffix in (".py", ".onnx", ".json") and not set(inner) & set(LEFT_OUT):
                    digest.update(path.name.encode() + path.read_bytes())
    for name in own_files:
        digest.update((Path(__file__).parent / name).read_bytes())
    return digest.hexdigest()


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
