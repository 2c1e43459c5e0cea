"""What is mined of training frames: proposals, and how sure the crop nets are of each thing."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from doro_perception.captioner import Captioner
from doro_perception.classes import CLASSES
from doro_perception.settings import PerceptionSettings
from doro_perception.train.mine import doubt, mine
from doro_perception.train.shards import mined_path, read_frames


@pytest.fixture(scope="module")
def captioner() -> Captioner:
    return Captioner(PerceptionSettings(candidate_score=0.05))


def written_shard(folder: Path, kinds: list[list[int]]) -> Path:
    """Write a shard of gray frames with a box of each kind in them."""
    image = np.full((300, 300, 3), 127, np.uint8)
    cv2.rectangle(image, (40, 40), (120, 160), (40, 60, 200), -1)
    jpeg = cv2.imencode(".jpg", image)[1].ravel()
    kind = np.concatenate(kinds).astype(np.int16)
    path = folder / "train-FloorPlan1-1.npz"
    np.savez(
        path,
        jpeg=np.concatenate([jpeg] * len(kinds)),
        ends=np.cumsum([len(jpeg)] * len(kinds)),
        frame=np.repeat(np.arange(len(kinds)), [len(k) for k in kinds]).astype(np.int32),
        box=np.tile(np.array([40, 40, 120, 160], np.float32), (len(kind), 1)),
        kind=kind,
        colour=np.full(len(kind), -1, np.int8),
        material=np.full(len(kind), -1, np.int8),
        ignore=np.zeros(len(kind), bool),
    )
    return path


def test_doubts_are_kept_by_thing_and_frame(tmp_path: Path, captioner: Captioner) -> None:
    everything = list(range(len(CLASSES) + 1))
    path = written_shard(tmp_path, [everything, [], [-1, 3]])
    mine(captioner, path)
    first, second, third = read_frames(path)
    right = 1 - first.doubt.astype(np.float64)
    assert 0.1 < right.sum() <= 1 + 1e-5  # one picture, each name in turn; the rest is "nothing"
    assert len(second.doubt) == 0
    assert third.doubt[0] == 1.0
    assert third.doubt[1] == pytest.approx(first.doubt[3])


def test_frames_that_nobody_looked_at_have_no_doubts(tmp_path: Path) -> None:
    (frame,) = read_frames(written_shard(tmp_path, [[3]]))
    assert not len(frame.doubt)
    assert not len(frame.mined)


def test_what_was_mined_before_doubts_is_still_read(tmp_path: Path, captioner: Captioner) -> None:
    path = written_shard(tmp_path, [[3, 4]])
    np.savez(mined_path(path), box=np.zeros((0, 4), np.float32), ends=np.array([0]))
    (frame,) = read_frames(path)
    assert frame.doubt.tolist() == [1.0, 1.0]
    assert len(doubt(captioner, frame)) == 2
