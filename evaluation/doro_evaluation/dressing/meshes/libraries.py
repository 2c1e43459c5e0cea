"""More meshes for the training frames alone, read from the libraries of a Debian package.

They are not committed. On Debian: ``apt-get download sweethome3d-furniture`` and
``dpkg-deb -x sweethome3d-furniture_*.deb MESHES``; then ``--meshes MESHES``. The libraries are zip
files named ``*.sh3f``: BlendSwap-CC-0 (CC0), BlendSwap-CC-BY, Scopia (CC-BY 3.0), KatorLegaz and
Reallusion (CC-BY 3.0 US). ``index.tsv`` tells which of the models belongs to which class,
what it is made of where one sees it, and who made it; they are scaled, shaded and recoloured.
"""

from __future__ import annotations

import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

import numpy as np

from doro_schemas.errors import Refused
from doro_sim_feeder.rooms.meshes import Mesh, decode_texture, normalised
from doro_sim_feeder.rooms.obj_files import parse_obj
from doro_sim_feeder.rooms.parts import Part, Rgb

INDEX = Path(__file__).with_name("index.tsv")
CATALOGUE = "PluginFurnitureCatalog.properties"
MOST_BYTES, MOST_STRETCH = 1_600_000, 1.5
GLAZED, CLEAR = frozenset({"Window", "Door"}), 0.95
GLASS: Rgb = (0.123, 0.456, 0.789)
"""The colour that marks glass in windows and doors; no model has it."""
Rng = np.random.Generator
Size = tuple[float, float, float]


@dataclass(frozen=True)
class Row:
    """A model of the index; ``material`` None where one would not see what it is made of."""

    kind: str
    library: str
    model: str
    material: str | None


def read_index(path: Path = INDEX) -> list[Row]:
    """Return the rows of the index."""
    lines = path.read_text().splitlines()[1:]
    words = [line.split("\t") for line in lines]
    return [Row(a, b, c, None if d == "-" else d) for a, b, c, d, _creator in words]


class MoreMeshes:
    """The models of a folder that holds the ``.sh3f`` files, read when they are first wanted."""

    def __init__(self, folder: Path) -> None:
        paths = {path.stem: path for path in sorted(folder.rglob("*.sh3f"))}
        if not paths:
            raise Refused(
                f"{folder} holds no .sh3f file; see doro_evaluation.dressing.meshes.libraries"
            )
        self._zips = {name: zipfile.ZipFile(path) for name, path in paths.items()}
        self._entries = {name: _catalogue(archive) for name, archive in self._zips.items()}
        self._rows: dict[str, list[Row]] = {}
        for row in read_index():
            entry = self._entries.get(row.library, {}).get(row.model)
            if entry is not None and self._bytes(row) <= MOST_BYTES:
                self._rows.setdefault(row.kind, []).append(row)
        self._cache: dict[tuple[str, str], Mesh] = {}

    def of(self, kind: str) -> Sequence[Row]:
        """Return the models of a class."""
        return self._rows.get(kind, [])

    def size_m(self, row: Row) -> Size:
        """Return width, height and depth of a model as its catalogue has them."""
        entry = self._entries[row.library][row.model]
        wide, high, deep = (float(entry[name]) / 100 for name in ("width", "height", "depth"))
        return wide, high, deep

    def fitting(self, kind: str, size_m: Size, rng: Rng) -> Row | None:
        """Return a model of a class whose shape is near to a size; None without one."""
        rows = [row for row in self.of(kind) if _stretch(self.size_m(row), size_m) < MOST_STRETCH]
        return rows[int(rng.integers(len(rows)))] if rows else None

    def any_size(self, kind: str, longest_m: float | None, rng: Rng) -> Size | None:
        """Return the size of one of a class's models, scaled to a longest side if one is given."""
        rows = self.of(kind)
        if not rows:
            return None
        size = np.asarray(self.size_m(rows[int(rng.integers(len(rows)))]))
        wide, high, deep = (size * ((longest_m or size.max()) / size.max())).tolist()
        return wide, high, deep

    def parts(self, row: Row, size_m: Size) -> tuple[Part, ...]:
        """Return a model in a size, standing on the origin, front to +z."""
        key = (row.library, row.model)
        if key not in self._cache:
            self._cache[key] = self._load(row)
        return self._cache[key].scaled(size_m)

    def _bytes(self, row: Row) -> int:
        return self._zips[row.library].getinfo(row.model).file_size

    def _load(self, row: Row) -> Mesh:
        archive, folder = self._zips[row.library], PurePosixPath(row.model).parent
        names = set(archive.namelist())

        def content(file: str) -> bytes | None:
            name = str(folder / file)
            return archive.read(name) if name in names else None

        parts = parse_obj(
            archive.read(row.model).decode("latin-1"),
            lambda file: _marked((content(file) or b"").decode("latin-1"), row.kind),
            lambda file: decode_texture(content(file)),
        )
        size = self.size_m(row)
        rotation = self._entries[row.library][row.model].get("modelRotation")
        return Mesh(row.model, size, normalised(parts, size, rotation))


def _marked(materials: str, kind: str) -> str:
    """Return an MTL file with what is glass in windows and doors in the colour that marks it."""
    if kind not in GLAZED:
        return materials
    blocks = materials.split("newmtl ")
    for number, block in enumerate(blocks):
        words = dict(line.split(None, 1) for line in block.splitlines()[1:] if " " in line.strip())
        if float(words.get("d", "1").split()[-1]) < CLEAR:
            name = block.splitlines()[0]
            blocks[number] = f"{name}\nKd {' '.join(str(value) for value in GLASS)}\n"
    return "newmtl ".join(blocks)


def _stretch(size_m: Size, wanted_m: Size) -> float:
    """Return by how much a shape would be stretched in one direction against another, from 1 on."""
    ratio = np.asarray(wanted_m) / np.maximum(size_m, 1e-3)
    return float(ratio.max() / max(ratio.min(), 1e-6))


def _catalogue(archive: zipfile.ZipFile) -> dict[str, dict[str, str]]:
    """Return the entries of a library's catalogue by the path of the model."""
    entries: dict[str, dict[str, str]] = {}
    for line in archive.read(CATALOGUE).decode("latin-1").splitlines():
        key, equals, value = line.partition("=")
        name, hash_, number = key.strip().partition("#")
        if equals and hash_:
            entries.setdefault(number, {})[name] = value.strip()
    return {one["model"].lstrip("/"): one for one in entries.values() if "model" in one}
