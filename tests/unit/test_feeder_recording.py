"""Recordings and folders of frames, without a bus."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from doro_schemas import codec
from doro_schemas.errors import Refused
from doro_schemas.messages import ColorFrame, DepthFrame, Exploration
from doro_sim_feeder.folder import FrameFolder
from doro_sim_feeder.play import INPUT_TOPICS, steps
from doro_sim_feeder.recording import Recorder, Recording, describe, write_recording
from tools.examples import examples


def make_folder(path: Path, *, frames: int = 3, size: tuple[int, int] = (40, 30)) -> Path:
    index = {
        "width": size[0],
        "height": size[1],
        "frames": [
            {"task": "a", "index": i, "position": {"x": i, "y": 0.9, "z": 0}, "yaw_deg": 90}
            for i in range(frames)
        ],
    }
    (path / "a").mkdir(parents=True)
    (path / "frames.json").write_text(json.dumps(index), encoding="utf-8")
    for i in range(frames):
        cv2.imwrite(str(path / "a" / f"{i:02d}.rgb.png"), np.full((30, 40, 3), 40 * i, np.uint8))
        cv2.imwrite(str(path / "a" / f"{i:02d}.depth_u8.png"), np.full((30, 40), 255 - i, np.uint8))
    return path


def test_a_recording_gives_back_the_very_bytes(tmp_path: Path) -> None:
    path = tmp_path / "all.mcap"
    messages = examples()
    sent = [one for one in messages if type(one).__name__ not in ("Health",)]
    assert write_recording(path, sent, {"room": "r", "seed": "3"}) == len(sent)
    recording = Recording(path)
    samples = list(recording.samples())
    assert [sample.payload for sample in samples] == [codec.encode(one) for one in sent]
    assert [sample.encoding for sample in samples] == [codec.encoding_of(type(x)) for x in sent]
    assert recording.metadata == {"format": "1", "room": "r", "seed": "3"}
    assert describe(recording)["messages"]["doro/query"] == 1


def test_the_same_messages_give_the_same_file(tmp_path: Path) -> None:
    one, other = tmp_path / "1.mcap", tmp_path / "2.mcap"
    for path in (one, other):
        write_recording(path, examples()[:2])
    assert one.read_bytes() == other.read_bytes()


def test_a_recorder_that_was_killed_leaves_whole_chunks(tmp_path: Path) -> None:
    path = tmp_path / "killed.mcap"
    recorder = Recorder(path)
    rng = np.random.default_rng(0)
    for number in range(40):
        image = rng.integers(0, 255, (200, 200, 3), dtype=np.uint8)  # does not compress
        recorder.add(ColorFrame(frame=number, height_px=200, width_px=200, data=image))
    # No close: what a kill leaves is what has been written so far.
    left = tmp_path / "left.mcap"
    left.write_bytes(path.read_bytes())
    recorder.close()
    with pytest.raises(Refused, match=r"left\.mcap is cut off"):
        Recording(left)
    frames = [sample.message().frame for sample in Recording(left, salvage=True).samples()]  # type: ignore[attr-defined]
    assert frames == list(range(len(frames)))
    assert len(frames) >= 30


@pytest.mark.parametrize(
    ("content", "words"),
    [(b"", "no MCAP"), (b"hello, this is text", "no MCAP"), (b"\x89MCAP0\r\n", "cut off")],
)
def test_files_that_are_no_recording(tmp_path: Path, content: bytes, words: str) -> None:
    path = tmp_path / "x.mcap"
    path.write_bytes(content)
    with pytest.raises(Refused, match=words):
        Recording(path)


def test_a_missing_file_and_another_format(tmp_path: Path) -> None:
    with pytest.raises(Refused, match="cannot be read: No such file"):
        Recording(tmp_path / "no.mcap")
    path = tmp_path / "old.mcap"
    write_recording(path, [], {"format": "0"})
    with pytest.raises(Refused, match="has format 0, this version reads 1"):
        Recording(path)


def test_a_folder_becomes_an_episode(tmp_path: Path) -> None:
    messages = list(FrameFolder(make_folder(tmp_path / "walk")).messages())
    kinds = [type(one).__name__ for one in messages]
    assert kinds == ["Exploration", *["ColorFrame", "DepthFrame"] * 3, "Exploration"]
    depth = [one for one in messages if isinstance(one, DepthFrame)]
    assert [one.pose.position_m for one in depth] == [
        [i, pytest.approx(1.575), 0] for i in range(3)
    ]
    assert depth[0].depth_m().max() == 0.0  # 255 is clipped: unknown, not 5 m
    assert depth[1].depth_m()[0, 0] == pytest.approx(254 * 5 / 255, abs=5e-4)
    finished = messages[-1]
    assert isinstance(finished, Exploration)
    assert finished.frames == 3


def test_folders_that_do_not_fit(tmp_path: Path) -> None:
    with pytest.raises(Refused, match=r"frames\.json cannot be read"):
        FrameFolder(tmp_path)
    (tmp_path / "frames.json").write_text("{}", encoding="utf-8")
    with pytest.raises(Refused, match="no frame index"):
        FrameFolder(tmp_path)
    missing = make_folder(tmp_path / "missing")
    (missing / "a" / "01.rgb.png").unlink()
    with pytest.raises(Refused, match=r"a/01\.rgb\.png is missing"):
        list(FrameFolder(missing).messages())
    wrong = make_folder(tmp_path / "wrong", size=(50, 30))
    with pytest.raises(Refused, match=r"has 40x30 px, frames\.json says 50x30"):
        list(FrameFolder(wrong).messages())
    with pytest.raises(Refused, match="has no walk 'z'"):
        list(FrameFolder(missing).messages(["z"]))


def test_steps_group_the_samples_of_a_frame(tmp_path: Path) -> None:
    path = tmp_path / "walk.mcap"
    write_recording(path, FrameFolder(make_folder(tmp_path / "walk")).messages())
    grouped = list(steps(Recording(path), INPUT_TOPICS))
    assert [step.kind for step in grouped] == ["started", "frame", "frame", "frame", "finished"]
    assert [len(step.samples) for step in grouped] == [1, 2, 2, 2, 1]
    only_depth = list(steps(Recording(path), ("depth",)))
    assert [[s.topic.name for s in step.samples] for step in only_depth] == [["depth"]] * 3
