"""Checkpoints made of the shipped files."""

from typing import Any

import cv2
import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="the extra train is not installed")
onnx = pytest.importorskip("onnx", reason="the extra train is not installed")

from doro_perception.captioner import PACKAGED_FOLDER  # noqa: E402
from doro_perception.crop_reader import OUTPUTS  # noqa: E402
from doro_perception.sessions import Session  # noqa: E402
from doro_perception.train import crops, proposer, recover  # noqa: E402
from doro_perception.train.shards import Frame, Shards  # noqa: E402


def test_module_paths_are_read_from_names_of_nodes() -> None:
    assert recover.module_of("/model/side2/side2.0/Conv") == "model.side2.0"
    assert recover.module_of("/model/deep5/steps.0/steps.0.3/Conv") == "model.deep5.steps.0.3"


def test_recovered_crop_nets_say_what_the_file_says() -> None:
    nets = [recover.recovered(name, PACKAGED_FOLDER) for name in ("crops", "names")]
    images = np.random.default_rng(1).integers(0, 256, (3, 96, 96, 3), np.uint8)
    with torch.no_grad():
        found = crops.Exported(nets)(torch.from_numpy(images))
    wanted = Session(PACKAGED_FOLDER / "crops.onnx", 1, "").run(list(OUTPUTS), {"crops": images})
    for one, other in zip(found, wanted, strict=True):
        assert np.abs(one.numpy() - other).max() < 1e-3


def test_measured_norms_change_nothing_at_work(monkeypatch: pytest.MonkeyPatch) -> None:
    net: Any = recover.recovered("proposer", PACKAGED_FOLDER)
    monkeypatch.setattr(recover, "STATISTICS_BATCHES", 1)
    monkeypatch.setattr(recover, "BATCH", 2)
    image = np.random.default_rng(2).integers(0, 256, (160, 160, 3), np.uint8)
    x = proposer.scaled(torch.from_numpy(image[None]))
    with torch.no_grad():
        before = [item for pair in net(x) for item in pair]
        recover.measure_norms(net, shards_of(image))
        after = [item for pair in net(x) for item in pair]
    assert float(net.side5[1].running_var.max()) != pytest.approx(1, abs=0.1)
    for one, other in zip(before, after, strict=True):
        assert (one - other).abs().max() < 1e-2


def shards_of(image: Any) -> Shards:
    """Return one frame without things as shards."""
    shards = Shards.__new__(Shards)
    none: Any = np.zeros(0)
    jpeg = cv2.imencode(".jpg", image)[1].ravel()
    empty = np.zeros((0, 4), np.float32)
    shards.frames = [Frame(jpeg, empty, none, none, none, none.astype(bool))]
    return shards
