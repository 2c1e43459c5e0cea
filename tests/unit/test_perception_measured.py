"""The measuring of perception: labels of rendered frames, real boxes, figures."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from doro_console.__main__ import main
from doro_evaluation.dressing.frames import write_shard
from doro_evaluation.dressing.labels import UNNAMED_KIND, Labels, label
from doro_evaluation.dressing.scatter import scattered
from doro_evaluation.outcomes import Outcome, Thing
from doro_evaluation.perception.chain import Chained, by_class
from doro_evaluation.perception.chain import figures_of as chain_figures
from doro_evaluation.perception.measure import NAMES, figures_of, measure, real, truth_of
from doro_evaluation.perception.speed import measure_speed
from doro_perception.backend import Detection, RgbImage
from doro_perception.classes import CLASSES, COLOURS, MATERIALS
from doro_schemas.errors import Refused
from doro_sim_feeder.rooms.camera import Camera
from doro_sim_feeder.rooms.exploration import plan_views
from doro_sim_feeder.rooms.scene import Scene, build_scene
from tests.unit.test_perception_captioner import folder, settings  # noqa: F401 - a fixture

SHARED = Path(os.environ.get("DORO_SHARED", Path(__file__).parents[3] / "shared")) / "data"
CUP, RED = CLASSES.index("Cup"), COLOURS.index("red")


@pytest.fixture(scope="module")
def bedroom() -> Scene:
    pytest.importorskip("embreex")
    return build_scene("FloorPlan304")


def labels() -> Labels:
    return Labels(
        box=np.array([[2, 2, 12, 12], [20, 2, 30, 12], [2, 20, 12, 30]], np.float32),
        kind=np.array([CUP, UNNAMED_KIND, -1], np.int16),
        colour=np.array([RED, -1, -1], np.int8),
        material=np.array([MATERIALS.index("glass"), -1, -1], np.int8),
        ignore=np.zeros(3, np.bool_),
        copy=np.zeros(3, np.bool_),
    )


def test_what_has_no_name_is_not_asked_for() -> None:
    truth = truth_of(labels())
    assert truth.ignore.tolist() == [False, True, True]
    assert truth.names[0] == {"cup"}
    assert truth.colours[0] == "red"
    assert truth.materials[0] == {"glass"}


def test_figures_of_a_detector_that_knows() -> None:
    def detect(rgb: RgbImage) -> list[Detection]:
        shares = (("cup", 0.9), ("mug", 0.1))
        colors = (("red", 1.0),)
        return [
            Detection(box_px=(2, 2, 12, 12), score=0.9, name="cup", classes=shares, colors=colors)
        ]

    image = np.zeros((40, 40, 3), np.uint8)
    images = [(image, truth_of(labels())) for _ in range(4)]
    figures = figures_of(measure("rendered", iter(images), detect))
    assert figures["perception/rendered/map50"] == 1.0
    assert figures["perception/rendered/boxes"] == 4
    assert figures["perception/rendered/top3"] == figures["perception/rendered/colour"] == 1.0
    assert figures["perception/rendered/calibration_error"] == pytest.approx(0.1)
    assert "perception/rendered/top1_given_box" not in figures


def test_scattered_things_stand_on_surfaces_in_the_picture(bedroom: Scene) -> None:
    scene = bedroom
    rng = np.random.default_rng(3)
    full = scattered(scene, rng, small=8, large=2)
    made = full.instances[len(scene.instances) :]
    assert len(made) >= 5
    assert all(item.object_type in CLASSES or item.color is None or item.copy for item in made)
    caster = full.caster()
    for item in made:
        low, high = item.corners
        middle = np.array([(low[0] + high[0]) / 2, low[1] - 0.001, (low[2] + high[2]) / 2])
        hit = caster.cast(middle[None].astype(np.float32), np.array([[0.0, -1.0, 0.0]]))
        assert hit.distance[0] < 0.15
    again = scattered(scene, np.random.default_rng(3), small=8, large=2)
    assert [item.object_id for item in again.instances] == [i.object_id for i in full.instances]


def test_labels_enclose_what_the_picture_shows(bedroom: Scene, tmp_path: Path) -> None:
    scene = bedroom
    camera, view = Camera(96), plan_views(scene.cells, 1, 2)[0]
    picture = camera.take(scene.caster(), view.pose())
    found = label(scene, picture.ids, view.pose(), camera)
    assert len(found.kind) > 3
    assert {name for kind in found.kind if 0 <= kind < len(CLASSES) for name in [NAMES[kind]]}
    assert (found.box[:, 2:] > found.box[:, :2]).all()
    assert found.box.max() <= 96
    color = np.full((96, 96, 3), 7, np.uint8)
    path = tmp_path / "train-x.npz"
    count = write_shard(path, iter([(color, labels()), (color, labels())]))
    with np.load(path) as data:
        assert (count, len(data["ends"]), data["frame"].tolist()) == (2, 2, [0, 0, 0, 1, 1, 1])


def test_speed_has_all_its_figures(folder: Path) -> None:  # noqa: F811
    figures = measure_speed([np.zeros((300, 300, 3), np.uint8)], settings(folder), threads=(1,))
    assert figures["perception_speed/1_threads/boxes"] > 0
    assert float(figures["perception_speed/1_threads/cpu_p50_ms"]) > 0


@pytest.mark.skipif(not SHARED.is_dir(), reason="the shared data is not there")
def test_the_real_boxes_are_all_read() -> None:
    images = list(real(SHARED))
    assert len(images) == 30
    assert sum(int((~truth.ignore).sum()) for _, truth in images) == 84
    assert {"dining table", "desk"} < next(
        names for _, truth in images for names in truth.names if "desk" in names
    )


def test_missing_real_boxes_are_refused(tmp_path: Path) -> None:
    with pytest.raises(Refused, match=r"boxes\.json cannot be read"):
        list(real(tmp_path))


def test_the_commands_are_there() -> None:
    result = CliRunner().invoke(main, ["eval", "perception", "--help"])
    assert result.exit_code == 0
    assert "--chain" in result.output


def test_no_frames_means_no_held_out_images(tmp_path: Path) -> None:
    path = tmp_path / "figures.json"
    result = CliRunner().invoke(
        main, ["eval", "perception", "--frames", "0", "--json", str(path)], catch_exceptions=False
    )
    assert result.exit_code == 0
    assert "held-out" not in result.output
    assert "perception/" not in path.read_text()
    plot = CliRunner().invoke(main, ["eval", "perception", "--frames", "0", "--plot", str(path)])
    assert plot.exit_code == 2
    assert "--plot draws what was seen on held-out images" in plot.output


def thing(kind: str, x_m: float) -> Thing:
    return Thing(object_type=kind, center_m=(x_m, 0.0, 0.0), size_m=(0.1, 0.1, 0.1), views=5)


def test_counts_by_class_pair_what_lies_close() -> None:
    outcome = Outcome(
        recording="r",
        room="FloorPlan1",
        part="test",
        system="fused",
        errors="captioner",
        frames=3,
        truth=(thing("Cup", 0.0), thing("Cup", 2.0), thing("Bowl", 1.0)),
        found=(thing("Cup", 0.1), thing("Cup", 5.0), thing("Vase", 1.0)),
    )
    assert by_class([outcome, outcome]) == {"Bowl": (2, 0, 0), "Cup": (4, 4, 2), "Vase": (0, 2, 0)}
    figures = chain_figures([Chained(outcome, ())])
    assert figures["perception_counting/fused/class/Cup/matched"] == 1
    assert "perception_counting/oracle/accuracy" not in figures
