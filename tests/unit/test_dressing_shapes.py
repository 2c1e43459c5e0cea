"""Shapes, colours and meshes of the training frames."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
import pytest

from doro_evaluation.dressing.fittings.deceivers import deceivers
from doro_evaluation.dressing.fittings.doors import door
from doro_evaluation.dressing.looks.colours import colour_name, seen_colour
from doro_evaluation.dressing.looks.surfaces import floor, planks, stone, tiles, wall, wood
from doro_evaluation.dressing.meshes.libraries import (
    CATALOGUE,
    GLASS,
    MoreMeshes,
    Row,
    read_index,
)
from doro_evaluation.dressing.natural import ONLY_NATURAL, natural
from doro_evaluation.dressing.shapes.makers import MAKERS, make_shape
from doro_perception.classes import CLASSES, COLOURS, MATERIALS, UNNAMED
from doro_schemas.errors import Refused
from doro_sim_feeder.rooms.appearance import PALETTE
from doro_sim_feeder.rooms.footprints import Rect
from doro_sim_feeder.rooms.instances import Instance
from doro_sim_feeder.rooms.parts import Part, bounds, box_part, place

SIZE_M = (0.3, 0.4, 0.2)
SEEDS = range(6)
PRINTED = {"AluminumFoil", "CD", "CreditCard"}  # flat: what differs is printed or coloured
ROOM = Rect(-2.0, 2.0, -1.5, 1.5)
CUBE = """mtllib cube.mtl
v 0 0 0
v 2 0 0
v 2 1 0
v 0 1 0
v 0 0 1
v 2 0 1
v 2 1 1
v 0 1 1
usemtl paint
f 1 2 3 4
f 5 6 7 8
f 1 2 6 5
f 3 4 8 7
"""
ENTRIES = {
    "id": "Test#cup", "name": "Cup", "model": "/lib/cup/cube.obj", "width": "20",
    "height": "10", "depth": "10", "creator": "nobody",
}  # fmt: skip


def drawn(kind: str, seed: int) -> tuple[Part, ...]:
    parts = make_shape(kind, SIZE_M, (0.6, 0.2, 0.2), np.random.default_rng(seed))
    assert parts is not None
    return parts


@pytest.mark.parametrize("kind", sorted(MAKERS))
def test_a_shape_fills_its_size_and_can_be_shaded(kind: str) -> None:
    for seed in SEEDS:
        parts = drawn(kind, seed)
        low, high = bounds(parts)
        np.testing.assert_allclose(high - low, SIZE_M, rtol=1e-4)
        assert low[1] == pytest.approx(0, abs=1e-5)
        assert sum(part.area_m2() for part in parts) > 0.01
        for part in parts:
            assert np.isfinite(part.vertices).all()
            assert 0 <= part.faces.min() <= part.faces.max() < len(part.vertices)
            assert 0 <= min(part.color) <= max(part.color) <= 1
            assert (part.texture is None) or (part.uv is not None)
            length = np.linalg.norm(part.normals[np.unique(part.faces)], axis=1)
            assert np.mean(np.abs(length - 1) < 1e-3) > 0.8


@pytest.mark.parametrize("kind", sorted(set(MAKERS) - PRINTED))
def test_a_shape_follows_from_its_seed(kind: str) -> None:
    for first, second in zip(drawn(kind, 3), drawn(kind, 3), strict=True):
        np.testing.assert_array_equal(first.vertices, second.vertices)
        assert first.color == second.color
    outlines = {tuple(len(part.vertices) for part in drawn(kind, seed)) for seed in range(12)}
    extents = {round(float(sum(p.area_m2() for p in drawn(kind, s))), 6) for s in range(12)}
    assert len(outlines) + len(extents) > 3


def test_shapes_are_of_classes_that_are_taught() -> None:
    assert set(MAKERS) - set(CLASSES) - set(UNNAMED) == set()
    assert make_shape("Wall", SIZE_M, (1, 1, 1), np.random.default_rng(0)) is None


def test_the_named_colours_are_called_by_their_names() -> None:
    for name, rgb in PALETTE.items():
        assert colour_name(rgb) == name
    assert colour_name((0.72, 0.7, 0.62)) is None


def test_the_colour_of_most_of_a_thing_is_seen() -> None:
    body = box_part((0, 0, 0), (1, 1, 1), PALETTE["red"])
    cap = box_part((0, 1, 0), (0.2, 1.1, 0.2), PALETTE["blue"])
    assert seen_colour((body, cap)) == "red"
    assert seen_colour((body, body.moved((3, 0, 0)), _blue(body), _blue(cap))) == "red"
    assert seen_colour((body, _blue(body))) is None


def _blue(part: Part) -> Part:
    return Part(part.vertices, part.faces, part.normals, None, PALETTE["blue"])


def test_only_what_is_used_of_a_texture_counts() -> None:
    half = np.zeros((8, 8, 3), np.uint8)
    half[:, :4] = 230
    part = box_part((0, 0, 0), (1, 1, 1), (1, 1, 1), texture=half)
    assert part.uv is not None
    left = Part(part.vertices, part.faces, part.normals, part.uv * 0 + 0.1, (1, 1, 1), half)
    assert seen_colour((left,)) == "white"


def test_surfaces_keep_their_tone_and_follow_from_the_seed() -> None:
    tone = (0.5, 0.4, 0.3)
    for kind in (wood, planks, tiles, stone):
        image = kind(np.random.default_rng(5), tone)
        np.testing.assert_array_equal(image, kind(np.random.default_rng(5), tone))
        np.testing.assert_allclose(np.median(image, axis=(0, 1)) / 255, tone, atol=0.15)
    for kind_of in (floor, wall):
        texture, span_m, shine = kind_of(np.random.default_rng(6))
        assert texture.dtype == np.uint8
        assert 0.2 < span_m < 3
        assert shine in ("", *MATERIALS)


def thing(kind: str, yaw_deg: float = 30.0) -> Instance:
    parts = place((box_part((-0.15, 0, -0.1), (0.15, 0.4, 0.1), (1, 0, 1)),), yaw_deg, (1, 0.7, 2))
    return Instance(f"{kind}|1", kind, parts, "purple", "wood", yaw_deg)


@pytest.mark.parametrize("kind", ["Mug", "Statue", "Chair", "Bed", "Apple", "HousePlant", "Fridge"])
def test_a_natural_thing_stays_where_it_was(kind: str) -> None:
    for seed in SEEDS:
        before = thing(kind)
        after = natural(before, np.random.default_rng(seed), None)
        for old, new in zip(before.corners, after.corners, strict=True):
            np.testing.assert_allclose(new, old, atol=0.12)
        assert after.corners[0][1] == pytest.approx(0.7, abs=1e-4)
        assert after.color is None or after.color in COLOURS
        assert after.material is None or after.material in MATERIALS


def test_doors_stand_on_the_walls_of_the_room() -> None:
    for seed in range(20):
        low, high = bounds(door(ROOM, np.random.default_rng(seed)))
        assert low[1] == pytest.approx(0)
        assert 1.8 < high[1] < 2.2
        assert low[0] >= -2.001
        assert high[0] <= 2.001
        gaps = (low[0] + 2, 2 - high[0], low[2] + 1.5, 1.5 - high[2])
        assert min(gaps) == pytest.approx(0, abs=1e-5)


def test_curtains_and_pictures_are_labelled_and_doors_are_not() -> None:
    kinds = {
        (item.object_id.split("|")[1].rstrip("0123456789"), item.object_type)
        for seed in range(30)
        for item in deceivers(ROOM, np.random.default_rng(seed))
    }
    assert ("curtains", "Curtains") in kinds
    assert ("wall", "Painting") in kinds
    assert {kind for name, kind in kinds if name == "door"} == {"Structure"}


def library(folder: Path, row: Row, materials: str) -> None:
    """Write a library with one model, a block of 20 x 10 x 10 cm."""
    entries = ENTRIES | {"model": f"/{row.model}"}
    lines = [f"{key}#1={value}" for key, value in entries.items()]
    with zipfile.ZipFile(folder / f"{row.library}.sh3f", "w") as archive:
        archive.writestr(CATALOGUE, "\n".join(lines))
        archive.writestr(row.model, CUBE)
        archive.writestr(str(Path(row.model).with_name("cube.mtl")), materials)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A library with a red block that is listed as a plastic cup."""
    row = next(row for row in read_index() if row.kind == "Cup" and row.material == "plastic")
    library(tmp_path, row, "newmtl paint\nKd 0.8 0.1 0.1\n")
    return tmp_path


def test_more_meshes_are_read_from_their_libraries(folder: Path) -> None:
    meshes = MoreMeshes(folder)
    (row,) = meshes.of("Cup")
    assert row.material == "plastic"
    assert meshes.size_m(row) == pytest.approx((0.2, 0.1, 0.1))
    low, high = bounds(meshes.parts(row, (0.4, 0.2, 0.1)))
    np.testing.assert_allclose(high - low, (0.4, 0.2, 0.1), rtol=1e-5)
    assert meshes.any_size("Cup", 0.1, np.random.default_rng(0)) == pytest.approx((0.1, 0.05, 0.05))
    assert meshes.any_size("Bed", 0.1, np.random.default_rng(0)) is None


def test_a_mesh_is_not_stretched_out_of_shape(folder: Path) -> None:
    meshes, rng = MoreMeshes(folder), np.random.default_rng(0)
    assert meshes.fitting("Cup", (0.4, 0.2, 0.22), rng) is not None
    assert meshes.fitting("Cup", (0.1, 0.2, 0.1), rng) is None


def test_a_thing_of_a_mesh_is_called_by_its_look(folder: Path) -> None:
    meshes = MoreMeshes(folder)
    wide = place((box_part((-0.1, 0, -0.05), (0.1, 0.1, 0.05), (1, 0, 1)),), 0, (0, 0, 0))
    item = Instance("Cup|1", "Cup", wide, "purple", "wood")
    looks = {
        (made.color, made.material)
        for made in (natural(item, np.random.default_rng(seed), meshes) for seed in range(12))
    }
    assert ("red", "plastic") in looks


def test_glass_of_windows_is_marked_and_shows_a_view(tmp_path: Path) -> None:
    row = next(row for row in read_index() if row.kind == "Window")
    clear = "newmtl paint\nKd 0.8 0.8 0.8\nd 0.5\n"
    library(tmp_path, row, clear)
    meshes = MoreMeshes(tmp_path)
    (pane,) = meshes.parts(meshes.of("Window")[0], (1.0, 1.0, 0.1))
    assert pane.color == GLASS
    windows = [
        item
        for seed in range(8)
        for item in deceivers(ROOM, np.random.default_rng(seed), meshes)
        if item.object_type == "Window"
    ]
    assert windows
    assert all(part.texture is not None for item in windows for part in item.parts)


def test_a_folder_without_libraries_is_refused(tmp_path: Path) -> None:
    with pytest.raises(Refused, match=r"no \.sh3f file"):
        MoreMeshes(tmp_path)


def test_the_index_names_known_classes_and_materials() -> None:
    rows = read_index()
    extra = {"Wardrobe", "Door", "WallThing"}
    assert {row.kind for row in rows} - set(CLASSES) - set(UNNAMED) - extra == set()
    assert {row.material for row in rows} - set(MATERIALS) == {None}
    assert set(ONLY_NATURAL) <= {row.kind for row in rows}
    assert len({(row.kind, row.library, row.model) for row in rows}) == len(rows)
