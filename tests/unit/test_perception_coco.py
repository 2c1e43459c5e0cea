"""The packaged detector runs; what is no such model is refused."""

import hashlib
import json
import os
import shutil
from pathlib import Path

import cv2
import msgspec
import numpy as np
import pytest

from doro_perception.backend import RgbImage, intersection_over_union
from doro_perception.coco import CocoSsd
from doro_perception.coco_model import CLASSES_FILE, PACKAGED_MODEL, stretched
from doro_perception.core import Perception
from doro_perception.settings import NOT_HOUSEHOLD, STRUCTURE, PerceptionSettings
from doro_schemas.errors import Refused
from doro_schemas.messages import ColorFrame, FrameCaptions
from doro_schemas.settings import load_settings

WALKS = (
    Path(os.environ.get("DORO_SHARED", Path(__file__).parents[3] / "shared"))
    / "data/ai2thor_walks/house_idx_10"
)


def synthetic_clock(side_px: int = 300) -> RgbImage:
    """A wall clock: round, white, twelve marks, two hands."""
    image = np.full((side_px, side_px, 3), 170, dtype=np.uint8)
    middle, radius = side_px // 2, side_px // 4
    cv2.circle(image, (middle, middle), radius, (40, 30, 25), cv2.FILLED, cv2.LINE_AA)
    cv2.circle(image, (middle, middle), radius - 9, (245, 245, 240), cv2.FILLED, cv2.LINE_AA)
    for hour in range(12):
        angle = hour * np.pi / 6
        ends = [
            (
                round(middle + share * radius * np.sin(angle)),
                round(middle - share * radius * np.cos(angle)),
            )
            for share in (0.68, 0.82)
        ]
        cv2.line(image, ends[0], ends[1], (20, 20, 20), 4, cv2.LINE_AA)
    cv2.line(image, (middle, middle), (middle + 28, middle - 22), (10, 10, 10), 5, cv2.LINE_AA)
    cv2.line(image, (middle, middle), (middle - 12, middle - 48), (10, 10, 10), 4, cv2.LINE_AA)
    return image


def settings(**values: object) -> PerceptionSettings:
    return PerceptionSettings(backend="coco", **values)


@pytest.fixture(scope="module")
def detector() -> CocoSsd:
    return CocoSsd(settings())


def test_a_drawn_clock_is_seen_as_a_clock_where_it_is(detector: CocoSsd) -> None:
    found = detector.detect(synthetic_clock())
    best = found[0]
    assert best.name == "clock"
    assert best.score > 0.5
    truth = np.array([75.0, 75.0, 225.0, 225.0])
    assert intersection_over_union(truth, np.array([best.box_px]))[0] > 0.7
    assert best.classes[0][0] == "clock"
    assert sum(share for _, share in best.classes) <= 1.0 + 1e-9


@pytest.mark.parametrize("side", [(480, 640), (37, 900), (1, 1), (8, 8)])
def test_any_image_size_works(detector: CocoSsd, side: tuple[int, int]) -> None:
    image = np.full((*side, 3), 90, dtype=np.uint8)
    for detection in detector.detect(image):
        xmin, ymin, xmax, ymax = detection.box_px
        assert 0 <= xmin < xmax <= side[1]
        assert 0 <= ymin < ymax <= side[0]


def test_boxes_of_whatever_class_do_not_cover_each_other() -> None:
    found = CocoSsd(settings(score_threshold=0.02, max_area_share=1.0)).detect(synthetic_clock())
    assert len(found) > 3
    boxes = np.array([detection.box_px for detection in found])
    for index in range(len(boxes) - 1):
        assert intersection_over_union(boxes[index], boxes[index + 1 :]).max() <= 0.55
    scores = [detection.score for detection in found]
    assert scores == sorted(scores, reverse=True)


def test_class_thresholds_and_left_out_classes_count() -> None:
    names = lambda **values: {  # noqa: E731
        found.name for found in CocoSsd(settings(**values)).detect(synthetic_clock())
    }
    assert "clock" in names()
    assert "clock" not in names(class_thresholds={"clock": 0.999})
    assert "clock" not in names(coco_leave_out=("clock",))
    assert names(max_area_share=0.1) == set()


def test_flip_finds_the_mirrored_thing_at_its_place() -> None:
    image = np.full((300, 500, 3), 170, dtype=np.uint8)
    image[:, :300] = synthetic_clock()
    best = CocoSsd(settings(flip=True, tiles=0)).detect(image)[0]
    assert best.name == "clock"
    assert np.allclose(best.box_px, [75, 75, 225, 225], atol=25)


def test_same_bytes_out_twice() -> None:
    frame = ColorFrame(frame=0, height_px=300, width_px=300, data=synthetic_clock())
    encoded = []
    for _ in range(2):
        core = Perception(settings(), CocoSsd(settings()))
        encoded += [msgspec.msgpack.encode(core.color_frame(frame)) for _ in range(2)]
    assert len(set(encoded)) == 1


def test_stretching_leaves_a_flat_wall_flat() -> None:
    assert np.ptp(stretched(np.full((30, 30, 3), 128, dtype=np.uint8))) == 0
    ramp = np.tile(np.linspace(50, 150, 90).astype(np.uint8)[:, None, None], (1, 90, 3))
    assert (stretched(ramp).min(), stretched(ramp).max()) == (0, 255)


def test_names_are_household_names(detector: CocoSsd) -> None:
    names = detector.names
    assert {"dining table", "television", "house plant", "remote control", "sofa"} <= set(names)
    assert not {"diningtable", "tvmonitor", "pottedplant", "person", "airplane"} & set(names)
    assert len(names) == len(set(names)) == 80 - len(NOT_HOUSEHOLD)


def copy_model(folder: Path) -> Path:
    for name in (PACKAGED_MODEL.name, CLASSES_FILE, PACKAGED_MODEL.name + ".sha256"):
        shutil.copy(PACKAGED_MODEL.with_name(name), folder / name)
    return folder / PACKAGED_MODEL.name


def test_the_packaged_file_is_the_one_of_the_model_card() -> None:
    digest = hashlib.sha256(PACKAGED_MODEL.read_bytes()).hexdigest()
    assert digest in PACKAGED_MODEL.with_name("MODEL_CARD.md").read_text(encoding="utf-8")


def test_a_missing_model_is_refused(tmp_path: Path) -> None:
    with pytest.raises(Refused, match=r"nowhere\.onnx is missing: set perception\.model"):
        CocoSsd(settings(model=str(tmp_path / "nowhere.onnx")))


def test_a_changed_model_is_refused(tmp_path: Path) -> None:
    path = copy_model(tmp_path)
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(bytes(data))
    with pytest.raises(Refused, match="is corrupt: it does not have the sha256"):
        CocoSsd(settings(model=str(path)))


@pytest.mark.parametrize(
    "content", [b"", b"no model at all", PACKAGED_MODEL.read_bytes()[:100_000]]
)
def test_what_is_no_onnx_is_refused(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "model.onnx"
    path.write_bytes(content)
    with pytest.raises(Refused, match=r"model\.onnx is no ONNX model that can be run") as caught:
        CocoSsd(settings(model=str(path)))
    assert "\n" not in caught.value.reason


def test_another_model_is_refused(tmp_path: Path) -> None:
    """The same model with its input renamed takes something else than an image."""
    path = copy_model(tmp_path)
    path.with_name(path.name + ".sha256").unlink()
    path.write_bytes(path.read_bytes().replace(b"image_tensor:0", b"other_tensor:0"))
    with pytest.raises(Refused, match=r"takes tensor\(uint8\) 'other_tensor:0' and"):
        CocoSsd(settings(model=str(path)))


def test_a_class_list_that_does_not_fit_is_refused(tmp_path: Path) -> None:
    path = copy_model(tmp_path)
    path.with_name(CLASSES_FILE).write_text("cup\nbed\n", encoding="utf-8")
    with pytest.raises(Refused, match="for 2 classes"):
        CocoSsd(settings(model=str(path))).warm_up()
    path.with_name(CLASSES_FILE).unlink()
    with pytest.raises(Refused, match=r"class list .* cannot be read"):
        CocoSsd(settings(model=str(path)))


def test_leaving_out_every_class_is_refused(detector: CocoSsd) -> None:
    with pytest.raises(Refused, match="leaves no class"):
        CocoSsd(settings(coco_leave_out=(*NOT_HOUSEHOLD, *detector.names)))


def test_settings_come_from_the_table(tmp_path: Path) -> None:
    path = tmp_path / "doro.toml"
    path.write_text(
        '[perception]\nbackend = "coco"\nleave_out = ["Floor"]\nclass_thresholds = {bed = 0.5}\n',
        encoding="utf-8",
    )
    read = load_settings("perception", PerceptionSettings, path, ["perception.tiles=3"])
    assert (read.backend, read.leave_out, read.tiles) == ("coco", ("Floor",), 3)
    assert read.class_thresholds == {"bed": 0.5}
    assert "Floor" in STRUCTURE
    for wrong in ("perception.backend=yolo", "perception.nms_iou=1.5", "perception.threads=0"):
        with pytest.raises(Refused, match=r"settings of \[perception\]"):
            load_settings("perception", PerceptionSettings, None, [wrong])


@pytest.mark.skipif(not WALKS.is_dir(), reason="the recorded walks are not here")
@pytest.mark.parametrize(
    ("walk", "index", "name", "place"),
    [
        ("task_5", 1, "television", [20.0, 40.0, 195.0, 160.0]),
        ("task_9", 24, "bed", [335.0, 215.0, 540.0, 380.0]),
    ],
)
def test_recorded_frames_show_what_is_there(
    detector: CocoSsd, walk: str, index: int, name: str, place: list[float]
) -> None:
    tasks = {frame["task"] for frame in json.loads((WALKS / "frames.json").read_text())["frames"]}
    (task,) = [name for name in tasks if name.startswith(walk)]
    data = np.fromfile(WALKS / task / f"{index:02d}.rgb.png", dtype=np.uint8)
    frame = ColorFrame(frame=index, height_px=640, width_px=640, encoding="png", data=data)
    (output,) = Perception(settings(), detector).color_frame(frame)
    assert isinstance(output, FrameCaptions)
    boxes = [box.box_px for box in output.detections if box.caption.endswith(name)]
    assert boxes, f"no {name} seen"
    assert intersection_over_union(np.array(place), np.array(boxes)).max() > 0.5
