"""Recordings and folders of frames, without a bus."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest

from doro_schemas import codec
from doro_schemas.errors import Refused
from doro_schemas.messages import ColorFrame, DepthFrame, Exploration
from doro_schemas.messages.base import Message
from doro_sim_feeder.folder import FrameFolder
from doro_sim_feeder.recording import Recorder, Recording, describe, write_recording
from doro_sim_feeder.steps import INPUT_TOPICS, Cut, checked_steps, problem_of, steps
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
    assert recording.cameras == {
        "cam0": {"width_px": "3", "height_px": "2", "fx": "1", "fy": "1", "cx": "1.5", "cy": "1"}
    }


def test_a_recording_keeps_its_truth(tmp_path: Path) -> None:
    path = tmp_path / "truth.mcap"
    write_recording(path, examples()[:1], attachments=lambda: {"truth.json": b"{}"})
    assert Recording(path).attachment("truth.json") == b"{}"
    assert Recording(path).attachment("other.json") is None


def test_a_source_that_fails_midway_leaves_no_file(tmp_path: Path) -> None:
    def failing() -> Iterator[Message]:
        yield from examples()[:1]
        raise Refused("no more")

    with pytest.raises(Refused, match="no more"):
        write_recording(tmp_path / "half.mcap", failing())
    assert list(tmp_path.iterdir()) == []


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


def frame_messages(numbers: list[int], *, episode: str = "e", depth: bool = True) -> list[Message]:
    """Return colour and depth frames, 0.1 s apart by their number."""
    out: list[Message] = []
    for number in numbers:
        common = {
            "episode": episode,
            "frame": number,
            "stamp_ns": number * 100_000_000,
            "height_px": 2,
            "width_px": 2,
        }
        out.append(ColorFrame(**common, data=np.zeros((2, 2, 3), np.uint8)))
        if depth:
            template = next(one for one in examples() if isinstance(one, DepthFrame))
            out.append(
                DepthFrame(
                    **common,
                    intrinsics=template.intrinsics,
                    pose=template.pose,
                    data=np.ones((2, 2), np.float32),
                )
            )
    return out


def started(episode: str) -> Exploration:
    return Exploration(state="started", episode=episode)


def recording_of(path: Path, messages: list[Message]) -> Recording:
    write_recording(path, messages)
    return Recording(path)


MIXED = [
    started("a"),
    *frame_messages([0], episode="a"),
    *frame_messages([0], episode="b"),
    *frame_messages([1], episode="a"),
]
BAD = {
    "shuffled": ([started("e"), *frame_messages([0, 2, 1])], "out of order: frame 1", [0, 1, 2]),
    "no depth": (
        [started("e"), *frame_messages([0]), *frame_messages([1], depth=False)],
        "frame 1 of cam0 has no depth",
        [0],
    ),
    "mixed": (MIXED, "two rooms are mixed: frame 0 of cam0 is of 'b' inside 'a'", [0, 1, 0]),
    "twice": ([started("e"), *frame_messages([0, 1, 0])], "frame 0 of cam0 is there twice", [0, 1]),
}


@pytest.mark.parametrize("name", sorted(BAD))
def test_bad_recordings_are_refused_or_repaired(tmp_path: Path, name: str) -> None:
    messages, words, repaired = BAD[name]
    recording = recording_of(tmp_path / "bad.mcap", messages)
    with pytest.raises(Refused, match=words) as caught:
        checked_steps(recording, Cut())
    assert "--repair" in caught.value.reason
    given = list(checked_steps(recording, Cut(), repair=True))
    assert [step.frame for step in given if step.kind == "frame"] == repaired
    assert given[0].kind == "started"


def test_two_rooms_one_after_the_other_are_fine(tmp_path: Path) -> None:
    messages = [
        *(started("a"), *frame_messages([0, 1], episode="a")),
        *(started("b"), *frame_messages([0], episode="b")),
    ]
    assert problem_of(recording_of(tmp_path / "two.mcap", messages)) == ""


def test_a_cut_keeps_the_start(tmp_path: Path) -> None:
    recording = recording_of(tmp_path / "cut.mcap", [started("e"), *frame_messages([*range(10)])])
    given = list(checked_steps(recording, Cut(from_s=0.25, to_s=0.55)))
    assert [step.kind for step in given] == ["started", "frame", "frame", "frame"]
    assert [step.frame for step in given[1:]] == [3, 4, 5]
    depth = list(checked_steps(recording, Cut(topics=("exploration", "depth"))))
    assert [step.topics for step in depth[1:]] == [frozenset({"depth"})] * 10
