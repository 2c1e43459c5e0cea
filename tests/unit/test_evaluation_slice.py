"""Two rooms with few views through the whole chain: frozen figures, with tolerances.

The sample kitchen lies in the package; the bedroom is rendered here. A change of generator,
error models, captions, parser or mapper that moves a figure by more than the tolerance fails.
"""

from __future__ import annotations

import importlib.util
import json
from pathlib import Path

import pytest
from click.testing import CliRunner

import doro_sim_feeder
from doro_console.__main__ import main
from doro_console.references import write_references
from doro_evaluation.chain import ERROR_MODELS, Language, Room, count_instances, load_room
from doro_evaluation.counting.conceptgraphs import count_like_conceptgraphs
from doro_evaluation.counting.metrics import measure
from doro_evaluation.counting.order import compare_order
from doro_evaluation.counting.report import figures_of, grouped
from doro_evaluation.outcomes import Outcome, Thing, found_things, true_things
from doro_evaluation.runs import (
    Context,
    Job,
    code_digest,
    error_names,
    make_pool,
    recordings_of,
    run_jobs,
    spread,
    with_finder,
)
from doro_mapper.settings import MapperSettings
from doro_schemas.errors import Refused
from doro_sim_feeder.recording import TRUTH, write_recording
from doro_sim_feeder.rooms.make_set import MANIFEST, RoomTruth

DATA = Path(doro_sim_feeder.__file__).parent / "data"
MISSING = [
    name for name in ("embreex", "procthor", "PIL") if importlib.util.find_spec(name) is None
]
needs_render = pytest.mark.skipif(
    bool(MISSING), reason=f"the extra 'render' is not installed: no {', '.join(MISSING)}"
)
BEDROOM, VIEWS = "FloorPlan301", 16
TOLERANCE = 0.07
"""One item of fifteen."""
FROZEN = {
    "gt/average/f1": 1.0,
    "gt/accuracy": 1.0,
    "gt/matched_f1_0.25m": 1.0,
    "all/average/f1": 0.933,
    "all/matched_f1_0.5m": 0.930,
}
ITEMS = 15


@pytest.fixture(scope="module")
def kitchen() -> Room:
    return load_room(DATA / "sample-kitchen.mcap")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a set of one bedroom and the sample, under names of a part."""
    from doro_sim_feeder.rooms.copies import CopySpec
    from doro_sim_feeder.rooms.episode import RoomEpisode, truth_json

    path = tmp_path_factory.mktemp("slice")
    episode = RoomEpisode(
        BEDROOM, seed=5, views=VIEWS, color=False, copies=CopySpec("Book", 3), name="bedroom"
    )
    metadata = {"room": BEDROOM}
    write_recording(
        path / f"validation-{BEDROOM}.mcap",
        episode.messages(),
        metadata,
        lambda: {TRUTH: truth_json(episode)},
    )
    for suffix in (".mcap", ".truth.json"):
        sample = (DATA / f"sample-kitchen{suffix}").read_bytes()
        (path / f"validation-FloorPlan19{suffix}").write_bytes(sample)
    return path


def context_of(folder: Path, out: Path, **changes: bool) -> Context:
    found = recordings_of(folder, "validation")
    pool = make_pool(found, "validation", out)
    return Context(pool=str(pool), cache=str(out / "cache"), code=code_digest(), **changes)


@needs_render
def test_the_slice_gives_the_frozen_figures(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    context = context_of(folder, tmp_path)
    recordings = recordings_of(folder, "validation")
    runs = tuple(("tracks", name) for name in error_names("gt,all"))
    jobs = [Job(item, runs) for item in recordings]
    outcomes = [one for some in run_jobs(jobs, context, workers=1) for one in some]
    figures = figures_of(grouped(outcomes))
    for name, value in FROZEN.items():
        assert figures[f"counting/ours/{name}"] == pytest.approx(value, abs=TOLERANCE), name
    assert figures["counting/ours/gt/average/items"] == ITEMS

    def never(_: Path) -> Room:
        raise AssertionError("a kept outcome was computed again")

    monkeypatch.setattr("doro_evaluation.maps.load_room", never)
    kept = [one for some in run_jobs(jobs, context, workers=1) for one in some]
    assert kept == outcomes


@needs_render
def test_the_command_writes_figures_plot_and_failures(folder: Path, tmp_path: Path) -> None:
    options = ["--part", "validation", "--errors", "gt", "--rooms", "1", "--workers", "1"]
    files = ["--json", "f.json", "--plot", "f.png", "--failures", "wrong.jsonl"]
    paths = [str(tmp_path / name) if "." in name else name for name in files]
    places = ["--set", str(folder), "--out", str(tmp_path / "out")]
    done = CliRunner().invoke(main, ["eval", "counting", *options, *places, *paths])
    assert done.exit_code == 0, done.output
    report = json.loads((tmp_path / "f.json").read_text())
    assert report["command"].startswith("doro eval counting --part validation --errors gt")
    assert report["figures"]["counting/ours/gt/recordings"] == 1
    assert 0.9 <= report["figures"]["counting/ours/gt/average/f1"] <= 1
    assert (tmp_path / "f.png").read_bytes().startswith(b"\x89PNG")
    assert (tmp_path / "wrong.jsonl").exists()
    refused = CliRunner().invoke(main, ["eval", "counting", *places, "--part", "validation",
                                        "--errors", "gt,xy"])  # fmt: skip
    assert refused.exit_code == 1


def test_a_perfect_answer_scores_one(kitchen: Room) -> None:
    truth = true_things(kitchen)
    assert len(truth) == 9
    perfect = Outcome("k", "FloorPlan19", "default", "ours", "gt", 72, truth, truth)
    figures = measure([perfect])
    assert figures["average/f1"] == figures["accuracy"] == figures["matched_f1_0.25m"] == 1
    assert figures["mae"] == 0


def test_conceptgraphs_like_counts_a_part_of_the_kitchen(kitchen: Room) -> None:
    graphs = Language().graphs(kitchen)
    found = count_like_conceptgraphs(kitchen.depths[:40], graphs[:40])
    cups = [one for one in found if one.object_type == "Cup"]
    assert 3 <= len(cups) <= 6
    truth = [one for one in true_things(kitchen) if one.object_type == "Cup"]
    assert all(min(_gap(one, other) for other in truth) < 0.25 for one in cups)


def test_errors_are_made_and_repeat(kitchen: Room) -> None:
    language = Language()
    exact, missing = language.graphs(kitchen), language.graphs(kitchen, ERROR_MODELS["cs+sd+fn"])
    before = sum(len(frame.detections) for frame in exact)
    after = sum(len(frame.detections) for frame in missing)
    assert 0.78 * before < after < 0.92 * before
    assert missing == language.graphs(kitchen, ERROR_MODELS["cs+sd+fn"])
    assert missing != language.graphs(kitchen, ERROR_MODELS["cs+sd+fn"], seed=1)
    with pytest.raises(Refused, match="other rooms"):
        language.graphs(kitchen, ERROR_MODELS["fp"])


def test_orders_are_compared(kitchen: Room) -> None:
    graphs = Language().graphs(kitchen)
    few = Room(
        kitchen.name,
        kitchen.room,
        kitchen.episode,
        kitchen.depths[:20],
        kitchen.detections[:20],
        kitchen.truth,
    )
    result = compare_order(few, graphs[:20], Context(), 1)
    assert 0.7 * result.classes <= result.same_counts <= result.classes
    assert len(result.moved_m) >= 0.8 * result.instances
    things = found_things(count_instances(few, graphs[:20]).instances)
    assert things == found_things(count_instances(few, graphs[:20], order=range(20)).instances)


def test_what_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(Refused, match="no recording of the part"):
        recordings_of(tmp_path, "test")
    with pytest.raises(Refused, match="'cd' is unknown"):
        error_names("gt,cd")
    with pytest.raises(Refused, match="no finder 'magic'"):
        with_finder(MapperSettings(), "magic")
    assert spread([], 3) == []


def _gap(a: Thing, b: Thing) -> float:
    return float(sum((x - y) ** 2 for x, y in zip(a.center_m, b.center_m, strict=True)) ** 0.5)


@pytest.fixture(scope="module")
def test_set(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the two recordings as test rooms, with their instructions."""
    path = tmp_path_factory.mktemp("set")
    for recording in recordings_of(folder, "validation"):
        room = load_room(Path(recording.path))
        name = recording.name.replace("validation", "default")
        truth = RoomTruth(
            episode=name, spec="", sha256="", views=0, cells=0, size_bytes=0, missing=(),
            instances=room.truth,
        )  # fmt: skip
        (path / f"{name}.mcap").write_bytes(Path(recording.path).read_bytes())
        sample = Path(recording.path).with_suffix(".truth.json")
        if sample.is_file():
            (path / f"{name}.truth.json").write_bytes(sample.read_bytes())
        write_references(path, truth)
    (path / MANIFEST).write_text('{"recordings": []}')  # nothing to render pictures from
    return path


@needs_render
def test_everything_twice_gives_the_same_figures(test_set: Path, tmp_path: Path) -> None:
    figures = []
    for out in ("one", "two"):
        places = ["--set", str(test_set), "--out", str(tmp_path / out)]
        options = ["--workers", "1", "--pairs", "12", "--tables", "counting,queries"]
        done = CliRunner().invoke(main, ["eval", "all", *options, *places])
        assert done.exit_code == 0, done.output
        figures.append((tmp_path / out / "figures.json").read_bytes())
        assert "Table IV" in (tmp_path / out / "report.html").read_text()
    assert figures[0] == figures[1]
    found = json.loads(figures[0])["figures"]
    assert found["multi-view/ours/pairs"] == found["single-view/paper_literal/pairs"] == 12
    for name in ("counting/ours/all/average/f1", "counting/paper_literal/gt/mae"):
        assert found[f"{name}_low"] <= found[name] <= found[f"{name}_high"]
    assert found["multi-view/ours/qa"] > found["multi-view/paper_literal/qa"]
