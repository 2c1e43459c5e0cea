"""``doro caption`` on good and bad images; the user's detector of the tests looks at them."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from click.testing import CliRunner

from doro_console.__main__ import main
from doro_perception.core import Perception
from doro_perception.files import describe_file, read_frame
from doro_perception.own import OwnDetector
from doro_perception.settings import PerceptionSettings
from doro_schemas.errors import Refused
from tests.unit.test_perception_own import red, yolo


@pytest.fixture
def core(tmp_path: Path) -> Perception:
    settings = PerceptionSettings(backend="onnx", detector=str(yolo(tmp_path)), colour=False)
    return Perception(settings, OwnDetector(settings))


@pytest.mark.parametrize(
    ("name", "image"),
    [
        ("colour.png", red(64, 64)[..., ::-1]),
        ("grey.png", np.full((64, 64), 250, np.uint8)),
        ("deep.png", np.full((64, 64, 3), 64000, np.uint16)),
        ("deep_grey.png", np.full((64, 64), 64000, np.uint16)),
        ("alpha.png", np.full((64, 64, 4), 250, np.uint8)),
        ("photo.jpg", np.full((64, 64, 3), 250, np.uint8)),
        ("8k.jpg", np.full((4320, 7680, 3), 250, np.uint8)),
    ],
)
def test_images_of_all_kinds_are_looked_at(
    name: str, image: np.ndarray, core: Perception, tmp_path: Path
) -> None:
    """Grey and 16-bit images become 8-bit RGB; an 8k image is made small first."""
    path = tmp_path / name
    cv2.imwrite(str(path), image)
    rgb, message = describe_file(core, path)
    assert rgb.shape == (*image.shape[:2], 3)
    assert rgb.dtype == np.uint8
    assert [box.caption for box in message.detections] == ["a cup", "a coffee table"]


@pytest.mark.parametrize(
    ("name", "data", "sentence"),
    [
        ("none.png", None, r"cannot be read \(No such file or directory\): name a file"),
        ("empty.png", b"", r"is neither JPEG nor PNG: convert it"),
        ("text.jpg", b"hello", r"is neither JPEG nor PNG: convert it"),
        ("cut.jpg", b"\xff\xd8\xff\xe0", r"has no readable header: its data is corrupt"),
    ],
)
def test_what_is_no_image_is_refused(
    name: str, data: bytes | None, sentence: str, tmp_path: Path
) -> None:
    if data is not None:
        (tmp_path / name).write_bytes(data)
    with pytest.raises(Refused, match=sentence) as caught:
        read_frame(tmp_path / name)
    assert "\n" not in caught.value.reason


def test_one_pixel_is_too_small_and_a_giant_too_large(core: Perception, tmp_path: Path) -> None:
    pixel, giant = tmp_path / "pixel.png", tmp_path / "giant.png"
    cv2.imwrite(str(pixel), np.zeros((1, 1, 3), np.uint8))
    with pytest.raises(Refused, match=r"1x1 px, too small to see anything in: send at least 16x16"):
        describe_file(core, pixel)
    cv2.imwrite(str(giant), np.zeros((20, 9000, 3), np.uint8))
    with pytest.raises(Refused, match="cannot be taken"):
        describe_file(core, giant)


def test_the_command_draws_what_it_can_and_says_what_it_cannot(tmp_path: Path) -> None:
    good, bad = tmp_path / "good.png", tmp_path / "bad.png"
    cv2.imwrite(str(good), red()[..., ::-1])
    bad.write_bytes(b"no image")
    out = tmp_path / "out"
    given = ["caption", str(bad), str(good), "--out", str(out), "--backend", "onnx"]
    result = CliRunner().invoke(
        main, [*given, "--set", f"perception.detector={yolo(tmp_path)}"], catch_exceptions=False
    )
    assert result.exit_code == 1
    assert "good.png: 2 things" in result.output
    drawn = cv2.imread(str(out / "good.png"))
    assert drawn is not None
    assert (drawn != red()[..., ::-1]).any()
    assert not (out / "bad.png").exists()


def test_images_of_one_name_do_not_overwrite_each_other(tmp_path: Path) -> None:
    images = [tmp_path / name / "001.png" for name in ("a", "b", "c/b", "c/d/b")]
    for image in images:
        image.parent.mkdir(parents=True)
        cv2.imwrite(str(image), red()[..., ::-1])
    out = tmp_path / "out"
    given = ["caption", *map(str, images), "--out", str(out), "--backend", "onnx"]
    result = CliRunner().invoke(
        main, [*given, "--set", f"perception.detector={yolo(tmp_path)}"], catch_exceptions=False
    )
    assert result.exit_code == 0
    assert sorted(path.name for path in out.iterdir()) == [
        "001-2.png",
        "001-3.png",
        "001.png",
        "b-001.png",
    ]
    assert all(str(path) in result.output for path in out.iterdir())
