"""Training frames in the evaluation's look: other furniture, and what a proposer takes for it."""

from __future__ import annotations

from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest

from doro_evaluation.dressing import copied
from doro_evaluation.dressing.frames import number_of, rooms_of, write_shard
from doro_evaluation.dressing.labels import Labels
from doro_evaluation.dressing.varied import LEAST_LONG_M, stretch, varied, varied_scene
from doro_evaluation.dressing.views import Views
from doro_perception.captioner import (
    CALIBRATION,
    PACKAGED_FOLDER,
    Candidates,
    Captioner,
    read_calibration,
)
from doro_perception.classes import CLASSES, MATERIALS
from doro_perception.train.calibrate import material_prior, prior_of
from doro_perception.train.mine import mine
from doro_perception.train.shards import NOBODY, UNCLEAR, Shards, mined_path, read_frames
from doro_sim_feeder.rooms.copies import CopySpec
from doro_sim_feeder.rooms.evaluation_set import plan_set
from doro_sim_feeder.rooms.exploration import plan_views
from doro_sim_feeder.rooms.layout import apartment_names, load_layout, sizes_of_type
from doro_sim_feeder.rooms.placement import Spawned
from doro_sim_feeder.rooms.scene import Scene, build_layout, build_scene

ROOM = "FloorPlan304"


def looks(scene: Scene) -> dict[str, tuple[str | None, int]]:
    """Return colour and number of triangles of what moves, by id."""
    return {
        item.object_id: (item.color, sum(len(part.faces) for part in item.parts))
        for item in scene.instances
    }


def test_a_varied_room_has_less_and_looks_otherwise() -> None:
    layout = load_layout(ROOM)
    other = varied(layout, np.random.default_rng(3))
    ids, kept = ({item.object_id for item in one.objects} for one in (layout, other))
    assert kept < ids
    gone = [item for item in layout.objects if item.object_id not in kept]
    assert all(item.moveable or item.pickupable for item in gone)


def test_what_stood_on_a_thing_that_was_taken_out_goes_with_it() -> None:
    seen = 0
    for room in ("RoboTHOR11", ROOM, "FloorPlan201"):
        layout = load_layout(room)
        for seed in range(6):
            kept = {item.object_id for item in varied(layout, np.random.default_rng(seed)).objects}
            for item in layout.objects:
                bases = [
                    one.object_id for one in layout.objects if one.object_id in item.receptacles
                ]
                without = [name for name in bases if name not in kept]
                seen += len(without)
                assert not (without and item.object_id in kept)
    assert seen > 0


def test_a_varied_room_repeats_by_its_seed_and_differs_by_it() -> None:
    own = looks(build_scene(ROOM))
    first, again, other = (looks(varied_scene(ROOM, np.random.default_rng(k))) for k in (1, 1, 2))
    assert first == again
    common = [key for key in first if key in other and key in own]
    assert len(common) > 10
    for left, right in ((first, other), (first, own)):
        assert sum(left[key] != right[key] for key in common) > len(common) // 4
    assert varied_scene(ROOM, np.random.default_rng(1)).name == ROOM


class Proposing:
    """A captioner that proposes the same boxes in every frame."""

    def propose(self, rgb: np.ndarray[Any, Any]) -> Candidates:
        boxes = [[10.0, 10.0, 30.0, 30.0], [60.0, 60.0, 80.0, 80.0], [41.0, 11.0, 49.0, 19.0]]
        return Candidates(np.array(boxes), np.zeros((3, 2)))


def test_what_is_mined_tells_things_from_nothing(tmp_path: Path) -> None:
    path = tmp_path / "train-FloorPlan304-1.npz"
    labels = Labels(
        box=np.array([[11, 11, 30, 30], [40, 10, 60, 30]], np.float32),
        kind=np.array([0, 1], np.int16),
        colour=np.array([-1, -1], np.int8),
        material=np.array([-1, -1], np.int8),
        ignore=np.array([False, True]),
        copy=np.zeros(2, np.bool_),
    )
    image = np.full((100, 100, 3), 128, np.uint8)
    write_shard(path, iter([(image, labels), (image, labels)]), plain=True)
    assert [len(frame.mined) for frame in read_frames(path)] == [0, 0]
    assert mine(cast("Captioner", Proposing()), path) == 6
    assert mined_path(path).exists()
    frames = Shards(tmp_path).frames  # the mined file is no shard of its own
    assert len(frames) == 2
    for frame in frames:
        # The first shows a thing, the second nothing, the third is part of what is hidden.
        assert frame.mined_of.tolist() == [0, NOBODY, UNCLEAR]


def test_only_rooms_as_they_are_tell_what_is_made_of_what(tmp_path: Path) -> None:
    cup, glass, metal = CLASSES.index("Cup"), MATERIALS.index("glass"), MATERIALS.index("metal")
    image = np.zeros((64, 64, 3), np.uint8)
    for number, (material, varied_) in enumerate(((glass, False), (metal, True), (metal, True))):
        labels = Labels(
            box=np.array([[5, 5, 30, 30]], np.float32),
            kind=np.array([cup], np.int16),
            colour=np.array([-1], np.int8),
            material=np.array([material], np.int8),
            ignore=np.zeros(1, np.bool_),
            copy=np.zeros(1, np.bool_),
        )
        path = tmp_path / f"train-FloorPlan304-{number}.npz"
        write_shard(path, iter([(image, labels)]), plain=True, varied=varied_)
    share = material_prior(Shards(tmp_path))[cup]
    assert share[glass] > 0.5
    assert share[metal] < 0.1
    shipped = PACKAGED_FOLDER / CALIBRATION
    assert prior_of(shipped, tmp_path)[cup] == share
    assert prior_of(shipped, None) == read_calibration(shipped).material_prior


def test_other_sizes_find_room_and_leave_what_carries_as_high_as_it_is() -> None:
    layout = load_layout(ROOM)
    own = {item.object_id: item for item in layout.objects}
    carrying = {name for item in layout.objects for name in item.receptacles}
    changed = 0
    for seed in range(8):
        for item in varied(layout, np.random.default_rng(seed)).objects:
            before = own[item.object_id]
            if item.asset_size_m == before.asset_size_m:
                continue
            changed += 1
            assert item.asset_size_m is not None
            assert before.asset_size_m is not None
            assert item.low_m[1] == before.low_m[1]
            assert item.asset_size_m[0] <= 1.11 * before.asset_size_m[0]
            assert item.asset_size_m[1] <= 0.21 + before.asset_size_m[1]
            if item.object_id in carrying:
                assert item.asset_size_m[1] == before.asset_size_m[1]
    assert changed > 10


def test_what_deceives_is_put_into_varied_rooms(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[tuple[str, Any]] = []

    def placed(scene: Scene, spec: CopySpec, seed: int, size_m: Any) -> Spawned:
        asked.append((spec.object_type, size_m))
        return Spawned(scene, ())

    monkeypatch.setattr(copied, "place_copies", placed)
    scene = cast("Scene", None)
    for seed in range(4):
        copied.with_varied_copies(scene, np.random.default_rng(seed))
    names = {name for name, _ in asked}
    assert names & set(copied.DECEIVING_FLOOR)
    assert names & set(copied.DECEIVING)
    assert names & copied.FLOOR
    sizes = [size_m for name, size_m in asked if size_m is not None]
    assert 0 < len(sizes) < len(asked)
    assert all(size_m in sizes_of_type(name) for name, size_m in asked if size_m is not None)


def test_apartments_train_and_never_measure() -> None:
    apartments = set(apartment_names())
    assert len(apartments) == 75
    assert apartments <= set(rooms_of("train"))
    assert not apartments & {row.room for row in plan_set()}
    assert not apartments & {*rooms_of("calibration"), *rooms_of("held-out")}
    assert len({number_of(room) for room in rooms_of("train")}) == len(rooms_of("train"))


def test_a_stretch_of_an_apartment_is_a_room_of_its_own_length() -> None:
    layout = load_layout("RoboTHOR11")
    sizes = set()
    for seed in range(6):
        part = stretch(layout, np.random.default_rng(seed))
        long_m = max(item.high_m[0] for item in part.objects) - min(
            item.low_m[0] for item in part.objects
        )
        assert {item.object_id for item in part.objects} <= {i.object_id for i in layout.objects}
        sizes.add(len(part.objects))
        assert long_m <= 9
        assert build_layout(part).cells.shape[1] == 2
    assert len(sizes) > 3
    assert min(sizes) < len(layout.objects)
    assert LEAST_LONG_M > 3


def test_recorded_views_with_more_in_them_are_taken() -> None:
    scene = build_scene(ROOM)
    views = plan_views(scene.cells, None, 1)
    rich = Views(scene, views, frozenset({"Book", "Pillow", "Laptop"}))
    rng = np.random.default_rng(2)
    taken = [rich.rich_as_recorded(rng) for _ in range(40)]
    assert all(view in views for view in taken)
    usual = [views[int(number)] for number in rng.integers(len(views), size=40)]
    assert sum(map(rich.worth, taken)) > sum(map(rich.worth, usual))
