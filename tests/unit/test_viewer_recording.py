"""The Rerun recording: what a run leaves in the file, also when the viewer is killed."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import viewer_session as made
from rerun.chunk import RrdReader

from doro_schemas import messages as m
from doro_schemas.errors import Refused
from doro_viewer.grid_state import FrameClock, GridState, solid
from doro_viewer.outputs import RerunScreen
from doro_viewer.rerun_views import Bounds
from doro_viewer.settings import ViewerSettings

FRAMES = 6
MAP_PATHS = {"/map/grid/cup", "/map/grid/table", "/map/grid/sofa", "/map/path", "/map/camera/cam0"}
ANSWERED = {"/map/instances", "/map/labels", "/map/floor"}
REST = {"/camera/cam0/image", "/camera/cam0/image/objects", "/talk", "/summary"}


def columns(path: Path, entity: str) -> dict[str, list[object]]:
    """Return all values of an entity, by column, in the order they were logged."""
    found: dict[str, list[object]] = {}
    for chunk in RrdReader(path).stream():
        if str(chunk.entity_path) == entity:
            for name, values in chunk.to_record_batch().to_pydict().items():
                found.setdefault(name, []).extend(values)
    return found


def entities(path: Path) -> set[str]:
    return {str(chunk.entity_path) for chunk in RrdReader(path).stream()}


def record(path: Path, **settings: object) -> None:
    screen = RerunScreen(ViewerSettings(rrd=str(path), **settings))
    for message in [*made.session(FRAMES), made.snapshot(), made.instances()]:
        screen.show(message)
    screen.close()


def test_a_run_is_recorded_with_all_its_entities(tmp_path: Path) -> None:
    path = tmp_path / "run.rrd"
    record(path)
    assert entities(path) >= MAP_PATHS | ANSWERED | REST
    assert "/camera/cam0/depth" not in entities(path)


def test_the_image_is_passed_through_at_its_frame(tmp_path: Path) -> None:
    path = tmp_path / "run.rrd"
    record(path)
    image = columns(path, "/camera/cam0/image")
    assert sorted(image["frame"]) == list(range(FRAMES))
    blobs = dict(zip(image["frame"], image["EncodedImage:blob"], strict=True))
    assert bytes(blobs[3][0]) == made.color_frame(3).data.tobytes()


def test_the_talk_is_in_order_and_names_the_evidence(tmp_path: Path) -> None:
    path = tmp_path / "run.rrd"
    record(path)
    said = [text for row in columns(path, "/talk")["TextLog:text"] for text in row]
    assert said.index("Person: bring me the red cup from the table") < said.index(
        f"Robot: {made.query().text}"
    )
    assert "cup-1 = one red plastic cup: cam0 frame 1 box 10,20-40,60 'a cup on a table'" in said


def test_instances_are_right_handed_and_labelled(tmp_path: Path) -> None:
    path = tmp_path / "run.rrd"
    record(path)
    boxes = columns(path, "/map/instances")
    rows = [row for row in boxes["Boxes3D:centers"] if row]
    np.testing.assert_allclose(rows[-1][0], [1.0, 1.0, 0.85], rtol=1e-6)
    labels = [row for row in boxes["Boxes3D:labels"] if row][-1]
    assert labels[0] == "cup-1: red plastic cup"
    places = [row for row in columns(path, "/map/labels")["Points3D:positions"] if row][-1]
    apart = [np.hypot(*np.subtract(a, b)[:2]) for i, a in enumerate(places) for b in places[:i]]
    assert min(apart) > 0.15


def test_depth_is_thinned_out_when_wanted(tmp_path: Path) -> None:
    path = tmp_path / "run.rrd"
    record(path, depth=True, depth_stride=8)
    buffer = columns(path, "/camera/cam0/depth")["DepthImage:buffer"][0][0]
    assert len(buffer) == 4 * (made.SIDE_PX // 8) ** 2


def test_a_complete_recording_passes_reruns_own_check(tmp_path: Path) -> None:
    path = tmp_path / "run.rrd"
    record(path)
    command = [sys.executable, "-m", "rerun_cli", "rrd", "verify", str(path)]
    environment = {**os.environ, "HOME": str(tmp_path), "XDG_CONFIG_HOME": str(tmp_path)}
    checked = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    assert "verified without error" in checked.stdout + checked.stderr


def test_a_killed_viewer_leaves_a_recording_that_can_be_read(tmp_path: Path) -> None:
    path = tmp_path / "run.rrd"
    program = (
        "import os, signal, sys\n"
        f"sys.path.insert(0, {str(Path(__file__).parent)!r})\n"
        "import viewer_session as made\n"
        "from doro_viewer.outputs import RerunScreen\n"
        "from doro_viewer.settings import ViewerSettings\n"
        f"screen = RerunScreen(ViewerSettings(rrd={str(path)!r}, flush_frames=2))\n"
        "for message in made.session(9)[:-1]:\n"
        "    screen.show(message)\n"
        "os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    ended = subprocess.run([sys.executable, "-c", program], check=False)
    assert ended.returncode == -signal.SIGKILL
    with pytest.warns(Warning, match="no footer"):
        frames = columns(path, "/camera/cam0/image")["frame"]
    assert max(frames) >= 7


def test_an_older_recording_is_put_aside(tmp_path: Path) -> None:
    path = tmp_path / "run.rrd"
    path.write_bytes(b"older")
    record(path)
    assert (tmp_path / "run.previous.rrd").read_bytes() == b"older"


def test_a_directory_that_is_missing_is_named(tmp_path: Path) -> None:
    with pytest.raises(Refused, match=r"viewer\.rrd = '.*nowhere/run\.rrd' cannot be written"):
        RerunScreen(ViewerSettings(rrd=str(tmp_path / "nowhere" / "run.rrd")))


def test_grid_state_adds_deltas_up_and_drops_cells_that_emptied() -> None:
    state = GridState()
    first = made.frame_messages(0)[-1]
    assert isinstance(first, m.GridDelta)
    assert state.apply(first) == ["cup", "sofa", "table"]
    count = len(state.centers_m("table"))
    emptied = first.cells[first.cells[:, 0] == 0][:1].copy()
    emptied[:, 4] = 0
    gone = m.GridDelta(
        seq=1,
        frame=1,
        frames_merged=2,
        cell_m=made.CELL_M,
        band_m=made.BAND_M,
        cells=emptied,
        weights=np.zeros(1, dtype=np.float32),
    )
    assert state.apply(gone) == ["table"]
    assert len(state.centers_m("table")) == count - 1
    assert state.replace(made.snapshot()) == ["cup", "sofa", "table"]
    np.testing.assert_allclose(state.centers_m("table")[0], [0.725, 0.825, 0.625], rtol=1e-6)


def test_cells_that_were_mostly_not_confirmed_are_not_drawn() -> None:
    cells = np.array([[0, 0, 0, 0, 1, 20], [0, 1, 0, 0, 5, 20], [0, 2, 0, 0, 0, 0]], np.int32)
    assert solid(cells).tolist() == [False, True, False]


def test_boxes_of_the_class_asked_for_carry_their_caption(tmp_path: Path) -> None:
    path = tmp_path / "run.rrd"
    record(path)
    labels = columns(path, "/camera/cam0/image/objects")["Boxes2D:labels"]
    assert ["a red cup", "a dark blue cup", "table"] in labels
    assert ["a red cup", "a dark blue cup", "a white table"] in labels


def test_cells_of_an_unknown_graph_wait_for_the_snapshot() -> None:
    state = GridState()
    late = made.frame_messages(5)[-1]
    assert isinstance(late, m.GridDelta)
    assert state.apply(late) == []


def test_frame_numbers_run_on_over_episodes() -> None:
    clock = FrameClock()
    assert [clock.place("a", frame) for frame in (0, 1, 2)] == [0, 1, 2]
    clock.start("b")
    assert [clock.place("b", frame) for frame in (0, 1)] == [3, 4]
    assert clock.place("a", 2) == 2
    assert clock.place("c", 0) == 5


def test_bounds_cover_and_grow() -> None:
    small = Bounds(low_m=(0.0, 0.0), high_m=(1.0, 1.0))
    assert small.grown(0.5).covers(small)
    assert not small.covers(small.grown(0.5))
