"""The captioner's two networks put together, with tiny ones that see colours."""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np
import pytest

from doro_perception.backend import Detection, RgbImage, without_doubles
from doro_perception.captioner import Calibration, Captioner, fitted, top
from doro_perception.classes import CLASSES, COLOURS, MATERIALS, class_names
from doro_perception.core import Perception
from doro_perception.crop import SIDE_PX, cut_out
from doro_perception.settings import PerceptionSettings
from doro_perception.stages import Stages
from doro_schemas.errors import Refused
from doro_schemas.messages import ColorFrame, FrameCaptions
from doro_schemas.vocabulary import canonical_name
from tests.tiny_onnx import FLOAT, UINT8, model, node, port

UNNAMED = len(CLASSES)
CUP, BOWL = CLASSES.index("Cup"), CLASSES.index("Bowl")
# Pixels of the proposer's 320: two at one place, then three more.
BOXES = np.array(
    [
        [20, 20, 100, 100],
        [22, 20, 101, 99],
        [120, 20, 200, 100],
        [20, 120, 100, 200],
        [0, 0, 0.5, 0.5],
    ],
    np.float32,
)[None]
SCORES = np.array([[0.8, 0.7, 0.6, 0.5, 0.9]], np.float32)
KINDS = np.zeros((1, 5, UNNAMED + 1), np.float32)
KINDS[0, np.arange(5), [CUP, BOWL, BOWL, UNNAMED, CUP]] = SCORES[0]


def proposer(shape: tuple[int | str, ...] = (1, 320, 320, 3)) -> bytes:
    nodes = [
        node("Cast", ["image"], ["pixels"], to=FLOAT),
        node("ReduceMean", ["pixels"], ["mean"], axes=[1, 2, 3], keepdims=0),
        node("Mul", ["mean", "zero"], ["nothing"]),
        node("Add", ["_boxes", "nothing"], ["boxes"]),
        node("Identity", ["_scores"], ["scores"]),
        node("Identity", ["_kinds"], ["kinds"]),
    ]
    constants = {
        "zero": np.zeros(1, np.float32),
        "_boxes": BOXES,
        "_scores": SCORES,
        "_kinds": KINDS,
    }
    outputs = [port("boxes", FLOAT, [1, 5, 4]), port("scores", FLOAT, [1, 5])]
    outputs.append(port("kinds", FLOAT, [1, 5, UNNAMED + 1]))
    return model(nodes, constants, [port("image", UINT8, list(shape))], outputs)


def crop_net() -> bytes:
    """Red is a red plastic cup, green a green glass bowl, blue something; else nothing."""
    kind = np.zeros((3, UNNAMED + 2), np.float32)
    kind[0, CUP], kind[1, BOWL], kind[2, UNNAMED] = 0.1, 0.1, 0.1
    bias = np.zeros((1, UNNAMED + 2), np.float32)
    bias[0, -1] = 8
    color = np.zeros((3, len(COLOURS)), np.float32)
    color[0, COLOURS.index("red")] = color[1, COLOURS.index("green")] = 0.05
    material = np.zeros((3, len(MATERIALS)), np.float32)
    material[0, MATERIALS.index("plastic")] = material[1, MATERIALS.index("glass")] = 0.05
    nodes = [
        node("Cast", ["crops"], ["pixels"], to=FLOAT),
        node("ReduceMean", ["pixels"], ["mean"], axes=[1, 2], keepdims=0),
        node("MatMul", ["mean", "w_kind"], ["raw"]),
        node("Add", ["raw", "bias"], ["kind"]),
        node("MatMul", ["mean", "w_color"], ["color"]),
        node("MatMul", ["mean", "w_material"], ["material"]),
    ]
    constants = {"w_kind": kind, "bias": bias, "w_color": color, "w_material": material}
    outputs = [
        port("kind", FLOAT, ["n", UNNAMED + 2]),
        port("color", FLOAT, ["n", len(COLOURS)]),
        port("material", FLOAT, ["n", len(MATERIALS)]),
    ]
    inputs = [port("crops", UINT8, ["n", SIDE_PX, SIDE_PX, 3])]
    return model(nodes, constants, inputs, outputs)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "proposer.onnx").write_bytes(proposer())
    (tmp_path / "crops.onnx").write_bytes(crop_net())
    (tmp_path / "calibration.json").write_bytes(msgspec.json.encode(Calibration()))
    return tmp_path


def picture(side_px: int = 320) -> RgbImage:
    """A red square where the first box is, a green and a blue one where the others are."""
    image = np.zeros((320, 320, 3), np.uint8)
    image[10:110, 10:110, 0] = 255
    image[10:110, 110:210, 1] = 255
    image[110:210, 10:110, 2] = 255
    return image[:: 320 // side_px, :: 320 // side_px]


def settings(folder: Path, **values: object) -> PerceptionSettings:
    """The tiny proposer sees the same boxes in a mirrored image: it is looked at in one test."""
    given = {"mirror": False, **values}
    return PerceptionSettings(backend="captioner", captioner=str(folder), **given)


def test_boxes_of_one_place_are_one_thing_with_both_opinions(folder: Path) -> None:
    found = Captioner(settings(folder)).propose(picture())
    assert np.allclose(found.boxes, BOXES[0, [0, 2, 3]])  # and a box of no size is none
    assert found.opinions[0, [CUP, BOWL]] == pytest.approx([0.8, 0.7])


def test_the_mirrored_image_is_looked_at_and_mirrored_back(folder: Path) -> None:
    found = Captioner(settings(folder, mirror=True)).propose(picture())
    both = np.vstack([BOXES[0, [0, 2, 3]], BOXES[0, [0, 2, 3]][:, [2, 1, 0, 3]]])
    both[3:, [0, 2]] = 320 - both[3:, [0, 2]]
    # (120..200 is its own mirror image.)
    assert len(found.boxes) == 5
    for box in both:
        assert np.abs(found.boxes - box).max(axis=1).min() <= 2


def test_named_and_nameless_things_with_distributions(folder: Path) -> None:
    found = Captioner(settings(folder)).detect(picture())
    names = [item.name for item in found]
    assert names.count("") == 1
    cup = found[names.index("cup")]
    assert cup.box_px == pytest.approx((20, 20, 100, 100))
    assert cup.classes[0] == ("cup", pytest.approx(1.0, abs=0.01))
    assert cup.colors is not None
    assert cup.colors[0][0] == "red"
    assert cup.materials[0][0] == "plastic"
    bowl = found[names.index("bowl")]
    assert bowl.colors is not None
    assert (bowl.colors[0][0], bowl.materials[0][0]) == ("green", "glass")
    assert found[names.index("")].box_px == pytest.approx((20, 120, 100, 200))
    for item in found:
        assert sum(share for _, share in item.classes) <= 1 + 1e-9


def test_boxes_come_back_in_pixels_of_the_image(folder: Path) -> None:
    small = Captioner(settings(folder)).detect(picture(160))
    assert min(item.box_px[0] for item in small) == pytest.approx(10)
    wide = np.zeros((160, 640, 3), np.uint8)
    found = Captioner(settings(folder)).propose(wide)
    assert found.boxes[:, [0, 2]].max() <= 640
    assert found.boxes[0] == pytest.approx([40, 40, 200, 160])  # cut at the lower edge


def test_the_message_tells_names_regions_shares_and_times(folder: Path) -> None:
    ticks = iter(np.arange(0.0, 9.0, 0.001).tolist())
    stages = Stages(lambda: next(ticks))
    use = settings(folder)
    core = Perception(use, Captioner(use, stages), stages=stages)
    (message,) = core.color_frame(ColorFrame(frame=0, height_px=320, width_px=320, data=picture()))
    assert isinstance(message, FrameCaptions)
    assert {box.caption for box in message.detections} == {
        "a red plastic cup",
        "a green glass bowl",
    }
    assert [region.box_px for region in message.unnamed] == [[20, 120, 100, 200]]
    assert [shares.colors[0].name for shares in message.shares] == ["red", "green"]
    assert set(message.timing_us) >= {"decode", "propose", "crops", "fuse", "describe"}
    assert core.counters["unnamed"] == 1
    quiet = Perception(use, Captioner(use))
    (other,) = quiet.color_frame(ColorFrame(frame=0, height_px=320, width_px=320, data=picture()))
    assert isinstance(other, FrameCaptions)
    assert other.timing_us == {}


def test_no_candidate_is_an_empty_list(folder: Path) -> None:
    assert Captioner(settings(folder, candidate_score=0.95)).detect(picture()) == []


def test_left_out_classes_are_not_reported(folder: Path) -> None:
    use = settings(folder, captioner_leave_out=("cup",))
    assert "cup" not in [item.name for item in Captioner(use).detect(picture())]


def test_calibration_scales_scores_and_the_prior_chooses(folder: Path) -> None:
    prior = np.full((len(CLASSES), len(MATERIALS)), 1e-3)
    prior[CUP, MATERIALS.index("paper")] = 1.0
    table = tuple(tuple(row) for row in prior.tolist())
    use = Calibration(scale=2.0, offset=-1.0, material_prior=table, prior_share=3.0)
    before = {item.name: item for item in Captioner(settings(folder)).detect(picture())}
    (folder / "calibration.json").write_bytes(msgspec.json.encode(use))
    after = {
        item.name: item
        for item in Captioner(settings(folder, captioner_threshold=0.2)).detect(picture())
    }
    raw = before["cup"].score
    wanted = 1 / (1 + np.exp(-(2 * np.log(raw / (1 - raw)) - 1)))
    assert after["cup"].score == pytest.approx(wanted, rel=1e-3)
    assert before["cup"].materials[0][0] == "plastic"
    assert after["cup"].materials[0][0] == "paper"


@pytest.mark.parametrize("name", ["proposer.onnx", "crops.onnx"])
def test_models_that_are_missing_corrupt_or_others_are_refused(name: str, folder: Path) -> None:
    path = folder / name
    good = path.read_bytes()
    path.unlink()
    with pytest.raises(Refused, match=rf"{name} is missing: set perception\.captioner"):
        Captioner(settings(folder))
    path.write_bytes(good[: len(good) // 2])
    with pytest.raises(Refused, match=rf"{name} is no ONNX model"):
        Captioner(settings(folder))
    path.write_bytes(proposer() if name == "crops.onnx" else crop_net())
    with pytest.raises(Refused, match="but the detector takes"):
        Captioner(settings(folder))
    path.write_bytes(good)
    (folder / f"{name}.sha256").write_text("0" * 64 + "  x\n", encoding="utf-8")
    with pytest.raises(Refused, match="is corrupt: it does not have the sha256") as caught:
        Captioner(settings(folder))
    assert "\n" not in caught.value.reason


def test_a_damaged_calibration_is_refused(folder: Path) -> None:
    (folder / "calibration.json").write_text('{"temperature": "hot"}', encoding="utf-8")
    with pytest.raises(Refused, match="is no calibration"):
        Captioner(settings(folder))
    (folder / "calibration.json").unlink()
    with pytest.raises(Refused, match=r"calibration\.json cannot be read"):
        Captioner(settings(folder))


@pytest.mark.parametrize("side", [(480, 640), (37, 900), (16, 16), (4320, 7680)])
def test_any_image_size_works(side: tuple[int, int], folder: Path) -> None:
    image = np.full((*side, 3), 90, np.uint8)
    small, scale = fitted(image, 320)
    assert small.shape == (320, 320, 3)
    assert scale == pytest.approx(320 / max(side))
    for item in Captioner(settings(folder)).detect(image):
        assert 0 <= item.box_px[0] < item.box_px[2] <= side[1]
        assert 0 <= item.box_px[1] < item.box_px[3] <= side[0]


def test_crops_show_the_square_around_a_box() -> None:
    image = np.zeros((100, 200, 3), np.uint8)
    image[40:60, 80:120] = 255
    crop = cut_out(image, [80.0, 40.0, 120.0, 60.0])
    assert crop.shape == (SIDE_PX, SIDE_PX, 3)
    assert crop[SIDE_PX // 2, SIDE_PX // 2].tolist() == [255, 255, 255]
    assert crop[2, 2].tolist() == [0, 0, 0]
    # What lies outside of the image is gray, also where nothing of the square is inside.
    assert cut_out(image, [-20.0, -20.0, 10.0, 10.0])[0, 0].tolist() == [114, 114, 114]
    assert (cut_out(image, [300.0, 300.0, 310.0, 310.0]) == 114).all()


def test_names_are_canonical_and_their_own() -> None:
    names = class_names()
    assert len(set(names)) == len(names) == len(CLASSES)
    assert all(canonical_name(name) == name for name in names)
    assert top(names, np.eye(len(names))[3], 5) == ((names[3], 1.0),)


def test_of_two_boxes_of_one_name_the_better_one_stays() -> None:
    first = Detection(box_px=(0, 0, 10, 10), score=0.9, name="cup")
    double = Detection(box_px=(0, 0, 10, 5), score=0.8, name="cup")
    bowl = Detection(box_px=(0, 0, 10, 5), score=0.7, name="bowl")
    apart = Detection(box_px=(8, 0, 18, 10), score=0.6, name="cup")
    assert without_doubles([first, double, bowl, apart], 0.4) == [first, bowl, apart]


def test_the_side_of_the_image_is_that_of_the_model(folder: Path) -> None:
    (folder / "proposer.onnx").write_bytes(proposer((1, 640, 640, 3)))
    (folder / "proposer.onnx.sha256").unlink(missing_ok=True)
    (first, *_) = Captioner(settings(folder)).detect(picture())
    assert first.box_px[2] - first.box_px[0] == pytest.approx(40, abs=1)
    others: list[tuple[int | str, ...]] = [(1, 320, 256, 3), (1, "h", "w", 3)]
    for shape in others:
        (folder / "proposer.onnx").write_bytes(proposer(shape))
        with pytest.raises(Refused, match=r"takes images .* not \(1, side, side, 3\)"):
            Captioner(settings(folder))
