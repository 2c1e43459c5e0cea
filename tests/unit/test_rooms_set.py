"""The evaluation set: what is in it, that it repeats, resumes and is what it says."""

from __future__ import annotations

import gzip
import importlib.util
import json
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from doro_console.references import references, write_references
from doro_schemas.errors import Refused
from doro_schemas.messages import DepthFrame, SimDetections
from doro_schemas.vocabulary import name_satisfies
from doro_sim_feeder.recording import Recording
from doro_sim_feeder.rooms.check import all_rooms, check_rooms
from doro_sim_feeder.rooms.classes import CLASSES
from doro_sim_feeder.rooms.evaluation_set import SetRow, plan_set, select
from doro_sim_feeder.rooms.exploration import plan_views
from doro_sim_feeder.rooms.footprints import CELL_M
from doro_sim_feeder.rooms.layout import room_names
from doro_sim_feeder.rooms.make_set import (
    MANIFEST,
    Made,
    Render,
    make_set,
    read_truth,
    write_manifest,
)
from doro_sim_feeder.rooms.scene import build_scene
from doro_sim_feeder.rooms.statistics import statistics

MISSING = [
    name for name in ("embreex", "procthor", "PIL") if importlib.util.find_spec(name) is None
]
pytestmark = pytest.mark.skipif(
    bool(MISSING), reason=f"the extra 'render' is not installed: no {', '.join(MISSING)}"
)
ALFRED = Path(__file__).parents[3] / "shared/data/rooms/reachable_alfred.json.gz"
ROWS = [
    SetRow("default-FloorPlan25", "default", "FloorPlan25", "kitchens", 7),
    SetRow("copies-FloorPlan19-Cup", "copies", "FloorPlan19", "kitchens", 8, "Cup", 4, 3),
]


def made(folder: Path, workers: int = 1) -> tuple[Render, list[Made]]:
    render = Render(folder, size_px=120, views=14)
    done = list(make_set(ROWS, render, workers))
    write_manifest(ROWS, done, render, seed=7)
    return render, done


@pytest.fixture(scope="module")
def small_set(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("set")
    made(folder)
    return folder


def test_the_plan_is_the_papers():
    rows = plan_set()
    assert Counter(row.part for row in rows) == {"validation": 5, "default": 34, "copies": 68}
    assert Counter(row.room_kind for row in rows if row.part == "default") == {
        "kitchens": 17,
        "living_rooms": 17,
    }
    copies = [row for row in rows if row.part == "copies"]
    assert Counter(row.total for row in copies) == {2: 17, 3: 17, 4: 17, 5: 17}
    assert {row.object_type for row in copies} == {item.object_type for item in CLASSES}
    assert all(1 <= row.copies <= 5 for row in copies)
    assert len({row.name for row in rows}) == 107
    assert rows == plan_set()
    assert rows != plan_set(8)


def test_there_are_21_classes_and_the_papers_seven_among_them():
    assert len(CLASSES) == len({item.object_type for item in CLASSES}) == 21
    named = {item.object_type for item in CLASSES if item.named}
    assert named == {"Cup", "Laptop", "Sofa", "Book", "Pillow", "Chair", "HousePlant"}
    assert {item.size for item in CLASSES} == {"small", "medium", "large"}
    assert not {"Television", "Fridge"} & {item.object_type for item in CLASSES}


def test_a_part_of_the_set_can_be_chosen():
    rows = plan_set()
    assert len(select(rows, ("validation",))) == 5
    assert {row.room for row in select(rows, (rows[7].room,))} == {rows[7].room}
    with pytest.raises(Refused, match="nothing named 'FloorPlan99'"):
        select(rows, ("FloorPlan99",))


def test_a_set_is_the_same_from_run_to_run(small_set: Path, tmp_path: Path):
    """Two processes and one give the same bytes in every file."""
    made(tmp_path, workers=2)
    names = sorted(path.name for path in small_set.iterdir())
    assert len(names) == 5
    assert names == sorted(path.name for path in tmp_path.iterdir())
    for name in names:
        assert (small_set / name).read_bytes() == (tmp_path / name).read_bytes(), name


def test_only_what_is_missing_or_damaged_is_made_again(small_set: Path):
    manifest = (small_set / MANIFEST).read_bytes()
    assert [one.again for one in made(small_set)[1]] == [False, False]
    broken = small_set / "default-FloorPlan25.mcap"
    whole = broken.read_bytes()
    broken.write_bytes(whole[:1000] + b"?" + whole[1001:])
    again = {one.row.name: one.again for one in made(small_set)[1]}
    assert again == {"default-FloorPlan25": True, "copies-FloorPlan19-Cup": False}
    assert broken.read_bytes() == whole
    assert (small_set / MANIFEST).read_bytes() == manifest
    assert not list(small_set.glob("*.part"))


def test_recordings_hold_depth_and_detections_and_say_where_they_come_from(small_set: Path):
    recording = Recording(small_set / "copies-FloorPlan19-Cup.mcap")
    messages = [sample.message() for sample in recording.samples()]
    kinds = Counter(type(message).__name__ for message in messages)
    assert kinds == {"Exploration": 2, "DepthFrame": 14, "SimDetections": 14}
    depth = next(message for message in messages if isinstance(message, DepthFrame))
    assert depth.encoding == "u16_mm"
    assert recording.metadata["room"] == "FloorPlan19"
    assert recording.metadata["seed"] == "8"
    assert "rooms" in recording.metadata["generator"]
    assert json.loads(recording.metadata["intrinsics"])["fx"] == pytest.approx(60)
    truth = read_truth(small_set / "copies-FloorPlan19-Cup.truth.json")
    assert truth is not None
    seen = Counter(
        detection.object_id
        for message in messages
        if isinstance(message, SimDetections)
        for detection in message.detections
    )
    assert seen == {item.object_id: item.views for item in truth.instances if item.views}


def test_manifest_and_statistics_count_what_is_there(small_set: Path):
    rows = {
        row["name"]: row for row in json.loads((small_set / MANIFEST).read_text())["recordings"]
    }
    cups = rows["copies-FloorPlan19-Cup"]
    assert (cups["instances"], cups["missing"], cups["views"]) == (4, [], 14)
    found = statistics(small_set)
    everything = next(one for one in found.observations if one.part == "all")
    assert (everything.recordings, everything.mean, everything.sigma) == (2, 14.0, 0.0)
    of_class = next(one for one in found.classes if one.object_type == "Cup")
    assert of_class.visible + of_class.hidden == 5
    assert sum(of_class.by_count.values()) == of_class.recordings
    assert found.size_bytes == sum(path.stat().st_size for path in small_set.glob("*.mcap"))


def test_an_empty_folder_has_no_statistics(tmp_path: Path):
    with pytest.raises(Refused, match=r"no readable manifest\.json"):
        statistics(tmp_path)


def test_instructions_are_true_and_have_reference_queries(small_set: Path, tmp_path: Path):
    truth = read_truth(small_set / "copies-FloorPlan19-Cup.truth.json")
    assert truth is not None
    lines = list(references(truth))
    assert {line.kind for line in lines} == {"self", "self_relation", "name"}
    visible = {item.object_id: item for item in truth.instances if item.views}
    for line in lines:
        assert line.references
        assert set(line.matches) <= set(line.instances) <= set(visible)
        if line.variant == "true":
            assert line.about in line.matches
            expected = "CONFIRM" if len(line.matches) == 1 else "INFORM-AMBIGUITY"
            assert line.state == expected
        elif line.variant == "absent":
            assert (line.state, line.instances) == ("INFORM-MISSING", [])
        else:
            assert line.matches == []
            expected = "INFORM-MISMATCH" if len(line.instances) == 1 else "INFORM-AMBIGUITY"
            assert line.state == expected
    cup = next(line for line in lines if line.kind == "name" and line.object_type == "Cup")
    cups = [name for name, item in visible.items() if name_satisfies("cup", item.object_type)]
    assert sorted(cup.matches) == sorted(cups)
    assert write_references(tmp_path, truth) == len(lines)
    first = (tmp_path / f"{truth.episode}.references.jsonl").read_bytes()
    write_references(tmp_path, truth)
    assert (tmp_path / f"{truth.episode}.references.jsonl").read_bytes() == first


def test_rooms_are_checked_and_refused_by_name():
    found = list(check_rooms(["FloorPlan25", "FloorPlan430", "FloorPlan99"], views=3))
    assert [bool(one.problem) for one in found] == [False, False, True]
    assert "FloorPlan99" in found[2].problem
    assert all(one.worst_box_m < 0.01 and one.holes == 0 for one in found[:2])
    assert found[0].measured > 20
    assert len(all_rooms()) == 120


def test_sweep_goes_to_and_fro_and_looks_all_around():
    x, z = np.meshgrid(np.arange(8) * CELL_M, np.arange(7) * CELL_M, indexing="ij")
    cells = np.stack([x.ravel(), z.ravel()], axis=1)
    views = plan_views(cells, None, seed=1, order="sweep")
    assert len(views) == 9 * 4
    assert [view.yaw_deg for view in views[:4]] == [0, 90, 180, 270]
    rows = [[v.position_m[2] for v in views[12 * k : 12 * k + 12 : 4]] for k in range(3)]
    assert rows[0] == sorted(rows[0])
    assert rows[1] == sorted(rows[1], reverse=True)
    assert len(plan_views(cells, 10, seed=1, order="sweep")) == 10
    with pytest.raises(Refused, match="no order 'planned'"):
        plan_views(cells, None, seed=1, order="planned")


@pytest.mark.skipif(not ALFRED.is_file(), reason="the recorded reachable cells are not at hand")
def test_reachable_cells_agree_with_ai2thors_own():
    """A sixth of the 90 rooms; all of them: mean IoU .679, 166 cells against 144."""
    recorded = json.loads(gzip.decompress(ALFRED.read_bytes()))
    shares, counts = [], []
    for kind in ("kitchens", "living_rooms", "bedrooms"):
        for name in room_names(kind)[::6]:
            real = {tuple(cell) for cell in np.rint(np.array(recorded[name]) / CELL_M).tolist()}
            ours = {tuple(cell) for cell in np.rint(build_scene(name).cells / CELL_M).tolist()}
            shares.append(len(real & ours) / len(real | ours))
            counts.append((len(real), len(ours)))
    assert np.mean(shares) > 0.62
    real_mean, our_mean = np.mean(counts, axis=0)
    assert our_mean / real_mean < 1.35
