"""The mesh library: 110 household models by AI2-THOR class, normalised to metres.

The models come from Debian's ``sweethome3d-furniture`` (CC0 and CC-BY; authors and
licences in ``data/meshes/LICENCES.txt``), packed in one archive.
"""

from __future__ import annotations

import functools
import io
import tarfile
from dataclasses import replace
from pathlib import Path, PurePosixPath

import msgspec
import numpy as np
from numpy.typing import NDArray

from doro_schemas.errors import Refused
from doro_sim_feeder.rooms.obj_files import parse_obj
from doro_sim_feeder.rooms.parts import Part, bounds, unit

MESH_DIR = Path(__file__).resolve().parent.parent / "data" / "meshes"
MAX_TEXTURE_PX = 512
SAME_MESH = {"Pot": "Pan", "PepperShaker": "SaltShaker", "Footstool": "Ottoman"}


class _Row(msgspec.Struct, array_like=True):
    """A row of ``mesh_index.json``; sizes are width, depth, height in centimetres."""

    object_type: str
    library: str
    file: str
    folder: str
    size_bytes: int
    creator: str
    textures: list[str]
    width_cm: str
    depth_cm: str
    height_cm: str
    rotation: str | None


class Mesh(msgspec.Struct, frozen=True):
    """A model with its origin at the bottom centre, front to +z, in Unity's left-handed axes.

    Attributes:
        name: ``library/file``.
        size_m: width (x), height (y), depth (z).
    """

    name: str
    size_m: tuple[float, float, float]
    parts: tuple[Part, ...]

    def scaled(self, size_m: tuple[float, float, float]) -> tuple[Part, ...]:
        """Return the parts stretched to a size."""
        scale = np.maximum(size_m, 0.004) / np.asarray(self.size_m)
        return tuple(
            replace(
                part,
                vertices=(part.vertices * scale).astype(np.float32),
                normals=unit(part.normals / scale).astype(np.float32),
            )
            for part in self.parts
        )


class MeshLibrary:
    """Reads models from the archive on first use; the archive is unpacked into memory."""

    def __init__(self, folder: Path = MESH_DIR) -> None:
        archive, index = folder / "meshes.tar.xz", folder / "mesh_index.json"
        for path in (archive, index):
            if not path.is_file():
                raise Refused(f"the mesh library lacks {path.name}: reinstall doro-sim-feeder")
        self._files: dict[str, bytes] = {}
        with tarfile.open(archive, "r:xz") as tar:
            for member in tar:
                content = tar.extractfile(member) if member.isfile() else None
                if content is not None:
                    self._files[member.name] = content.read()
        rows = msgspec.json.decode(index.read_bytes(), type=list[_Row])
        self._rows: dict[str, list[_Row]] = {}
        for row in rows:
            self._rows.setdefault(row.object_type, []).append(row)
        self._cache: dict[str, Mesh] = {}

    def choose(self, object_type: str, key: int, material: str | None = None) -> Mesh | None:
        """Return one of the class's models, the same for the same key; None if there is none.

        Models whose file name says the material ("plasticCup") are preferred.
        """
        rows = self._rows.get(SAME_MESH.get(object_type, object_type), [])
        fitting = [row for row in rows if material and material in row.file.lower()]
        rows = fitting or rows
        return self._mesh(rows[key % len(rows)]) if rows else None

    def _mesh(self, row: _Row) -> Mesh:
        name = f"{row.library}/{row.file}"
        if name not in self._cache:
            self._cache[name] = self._load(name, row)
        return self._cache[name]

    def _load(self, name: str, row: _Row) -> Mesh:
        folder = PurePosixPath("meshes") / row.library / row.folder

        def text(file: str) -> str:
            return self._files.get(str(folder / file), b"").decode("latin-1")

        def texture(file: str) -> NDArray[np.uint8] | None:
            return decode_texture(self._files.get(str(folder / file)))

        size = (float(row.width_cm) / 100, float(row.height_cm) / 100, float(row.depth_cm) / 100)
        parts = parse_obj(text(row.file), text, texture)
        if not parts:
            raise Refused(f"the mesh library's model {name} is empty: reinstall doro-sim-feeder")
        return Mesh(name, size, normalised(parts, size, row.rotation))


def normalised(
    parts: tuple[Part, ...], size_m: tuple[float, float, float], rotation: str | None
) -> tuple[Part, ...]:
    """Return the parts turned, scaled, centred on the ground and mirrored to left-handed axes."""
    turn = np.eye(3)
    if rotation:
        turn = np.array([float(word) for word in rotation.split()]).reshape(3, 3)
    turned = tuple(
        replace(
            part,
            vertices=(part.vertices @ turn.T).astype(np.float32),
            normals=(part.normals @ turn.T).astype(np.float32),
        )
        for part in parts
    )
    low, high = bounds(turned)
    scale = np.asarray(size_m) / np.maximum(high - low, 1e-9)
    origin = np.array([(low[0] + high[0]) / 2, low[1], (low[2] + high[2]) / 2])
    mirror = np.array([-1.0, 1.0, 1.0])
    return tuple(
        replace(
            part,
            vertices=((part.vertices - origin) * scale * mirror).astype(np.float32),
            normals=unit(part.normals / scale * mirror).astype(np.float32),
            faces=np.ascontiguousarray(part.faces[:, ::-1]),  # mirrored: turn the winding back
        )
        for part in turned
    )


def decode_texture(data: bytes | None) -> NDArray[np.uint8] | None:
    if data is None:
        return None
    from PIL import Image  # noqa: PLC0415 - optional dependency of the extra "render"

    image = Image.open(io.BytesIO(data)).convert("RGB")
    longest = max(image.size)
    if longest > MAX_TEXTURE_PX:
        width, height = (max(1, side * MAX_TEXTURE_PX // longest) for side in image.size)
        image = image.resize((width, height))
    return np.asarray(image, np.uint8)


@functools.cache
def mesh_library() -> MeshLibrary:
    """Return the library of this installation, loaded once per process."""
    return MeshLibrary()
