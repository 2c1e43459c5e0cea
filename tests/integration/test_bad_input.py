"""Each bad input is refused with one clear sentence, counted, and loses nothing else."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator
from pathlib import Path

import msgpack
import numpy as np
import pytest

from doro_schemas import codec
from doro_schemas.camera import intrinsics_from_vertical_fov, pose_from_ai2thor
from doro_schemas.errors import Refused
from doro_schemas.messages import DepthFrame, FrameCaptions, FrameGraphs, Health, Rejected
from doro_schemas.topics import TOPICS, topic_of
from doro_sim_feeder.recording import Recording
from tests.integration.chain import BIN, SAMPLE, Chain

CAPTIONS = codec.encoding_of(FrameCaptions)
FRAME = {"episode": "bad", "frame": 3, "height_px": 30, "width_px": 40}
GOOD_BOX = {"box_px": [1, 1, 9, 9], "score": 0.5, "caption": "a cup"}


@pytest.fixture(scope="module")
def chain() -> Iterator[Chain]:
    with Chain() as running:
        yield running


def refused(chain: Chain, topic: str, payload: bytes, encoding: str, key: str = "") -> Rejected:
    """Put bytes on a topic; return the refusal that comes back."""
    before = len(chain.rejected)
    row = TOPICS[topic]
    chain.bus.put_raw(row, key or row.key, payload, encoding)
    rejected = chain.rejection(before + 1)
    assert "\n" not in rejected.reason
    assert rejected.key == (key or row.key)
    return rejected


def captions(**fields: object) -> bytes:
    packed: bytes = msgpack.packb({**FRAME, "detections": [GOOD_BOX], **fields})
    return packed


def test_truncated_msgpack(chain: Chain) -> None:
    rejected = refused(chain, "captions", captions()[:-5], CAPTIONS)
    assert (rejected.service, rejected.size_bytes) == ("nlu", len(captions()) - 5)
    assert "no complete msgpack map" in rejected.reason


def test_wrong_types(chain: Chain) -> None:
    rejected = refused(chain, "captions", captions(height_px="tall"), CAPTIONS)
    assert "$.height_px" in rejected.reason
    assert rejected.frame == 3


def test_unknown_schema_version(chain: Chain) -> None:
    encoding = CAPTIONS.replace(".v1", ".v9")
    rejected = refused(chain, "captions", captions(), encoding)
    assert "doro.FrameCaptions.v9" in rejected.reason
    assert "doro.FrameCaptions.v1" in rejected.reason


def test_no_schema(chain: Chain) -> None:
    assert "names no schema" in refused(chain, "captions", captions(), "zenoh/bytes").reason


def test_another_message_than_the_key_takes(chain: Chain) -> None:
    payload = codec.encode(Rejected(service="x", key="y", reason="z"))
    reason = refused(chain, "captions", payload, codec.encoding_of(Rejected)).reason
    assert "does not travel on this key" in reason


def test_box_outside_the_image(chain: Chain) -> None:
    box = {**GOOD_BOX, "box_px": [30, 1, 90, 9]}
    rejected = refused(chain, "captions", captions(detections=[box]), CAPTIONS)
    assert "outside its image of 40x30 px" in rejected.reason


def depth(frame: int, **fields: object) -> DepthFrame:
    values: dict[str, object] = {
        **FRAME,
        "frame": frame,
        "intrinsics": intrinsics_from_vertical_fov(30, 40, 90.0),
        "pose": pose_from_ai2thor((0.0, 1.5, 0.0), 0.0, 0.0),
        "data": np.ones((30, 40), np.float32),
    }
    return DepthFrame(**{**values, **fields})  # type: ignore[arg-type]


def test_nan_pose(chain: Chain) -> None:
    payload = codec.encode(depth(4)).replace(
        msgpack.packb([0.0, 1.5, 0.0]), msgpack.packb([0.0, float("nan"), 0.0])
    )
    key = TOPICS["depth"].key_for(camera="cam0")
    rejected = refused(chain, "depth", payload, codec.encoding_of(DepthFrame), key)
    assert "not finite" in rejected.reason
    assert (rejected.service, rejected.frame) == ("mapper", 4)


def test_depth_segment_cut_off(chain: Chain) -> None:
    key = TOPICS["depth"].key_for(camera="cam0")
    payload = codec.encode(depth(5))[:-1000]
    rejected = refused(chain, "depth", payload, codec.encoding_of(DepthFrame), key)
    assert "segment 'data' needs 4800 bytes" in rejected.reason


def test_depth_of_another_size(chain: Chain) -> None:
    before = len(chain.rejected)
    chain.bus.publish(depth(6), lossless=True)
    chain.bus.publish(FrameGraphs(episode="bad", frame=6, height_px=60, width_px=80))
    rejected = chain.rejection(before + 1)
    assert (rejected.service, rejected.frame) == ("mapper", 6)
    assert "80x60" in rejected.reason
    assert "40x30" in rejected.reason


INSTRUCTIONS = (
    (b"", "instruction is empty"),
    (b"red cup " * 12_500, "100000 characters"),
    (b"\xff\xfe", "UTF-8"),
)


@pytest.mark.parametrize(("text", "words"), INSTRUCTIONS)
def test_instructions(chain: Chain, text: bytes, words: str) -> None:
    rejected = refused(chain, "instruction", text, "zenoh/bytes")
    assert rejected.service == "nlu"
    assert words in rejected.reason
    assert len(rejected.reason) < 300


@pytest.mark.parametrize("share", [0.2, 0.6, 0.999])
def test_truncated_recording(chain: Chain, tmp_path: Path, share: float) -> None:
    whole = SAMPLE.read_bytes()
    path = tmp_path / "cut.mcap"
    path.write_bytes(whole[: int(len(whole) * share)])
    with pytest.raises(Refused, match=r"cut\.mcap is cut off") as caught:
        Recording(path)
    assert "\n" not in caught.value.reason
    frames = [s for s in Recording(path, salvage=True).samples() if s.topic.name == "depth"]
    assert 0 < len(frames) <= 72


def test_playing_a_truncated_recording_is_refused_on_the_bus(chain: Chain, tmp_path: Path) -> None:
    path = tmp_path / "cut.mcap"
    path.write_bytes(SAMPLE.read_bytes()[:700_000])
    before = len(chain.rejected)
    command = [str(BIN / "doro"), "play", str(path), "--set", f"bus.endpoint={chain.endpoint}"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 1
    assert "cut.mcap is cut off" in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
    rejected = chain.rejection(before + 1)
    assert (rejected.service, rejected.key) == ("feeder", "cut.mcap")


def test_the_chain_goes_on_to_the_right_answer_and_counted_all(chain: Chain) -> None:
    chain.say("bring me the blue cup")
    report = chain.play()
    assert report.merged == 72
    query = chain.query(1)
    assert query.state == "CONFIRM"
    health: dict[str, Health] = {}
    chain.bus.subscribe(topic_of(Health), lambda one: health.update({one.service: one}))  # type: ignore[attr-defined]
    assert chain.wait(lambda: {"nlu", "mapper"} <= set(health), 10.0)
    for service in ("nlu", "mapper"):
        count = sum(one.service == service for one in chain.rejected)
        assert health[service].counters["rejected"] == count > 0
        assert health[service].last_rejection
