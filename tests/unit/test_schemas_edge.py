"""The edge without a network: codec, settings, inbox, topics."""

from __future__ import annotations

import queue
import threading
from pathlib import Path

import msgspec
import numpy as np
import pytest

from doro_schemas import codec, topics
from doro_schemas.bus.config import BusSettings, client_config, config_text, router_config
from doro_schemas.bus.inbox import Inbox, Lane
from doro_schemas.errors import Refused
from doro_schemas.messages import ColorFrame, DepthFrame, FrameCaptions, Instruction
from doro_schemas.settings import load_settings
from tools.examples import examples

ROOT = Path(__file__).resolve().parents[2]


def test_arrays_are_views_into_the_payload_and_aligned() -> None:
    depth = next(one for one in examples() if isinstance(one, DepthFrame))
    payload = codec.encode(depth)
    decoded = codec.decode(payload, codec.encoding_of(DepthFrame))
    assert isinstance(decoded, DepthFrame)
    assert not decoded.data.flags.owndata
    assert decoded.data.flags.aligned
    assert np.array_equal(decoded.data, depth.data)


@pytest.mark.parametrize(
    ("encoding", "words"),
    [
        ("zenoh/bytes", "names no schema"),
        ("application/msgpack;doro.Nonsense.v1", "is unknown"),
        ("application/msgpack;doro.Query.v2", "reads doro.Query.v1"),
        ("application/msgpack;doro.ColorFrame.v1", "travels as"),
        ("application/json;doro.Query.v1", "travels as"),
    ],
)
def test_encodings_that_do_not_fit(encoding: str, words: str) -> None:
    with pytest.raises(Refused, match=words):
        codec.decode(b"\x80", encoding)


@pytest.mark.parametrize(
    "payload",
    [
        b"",
        b"\x00\x00\x00",
        b"\xff\xff\xff\xff" + bytes(20),
        b"\x01\x00\x00\x00\x80",
        b"\x01\x00\x00\x00\x90",
    ],
)
def test_segment_headers_that_do_not_fit(payload: bytes) -> None:
    with pytest.raises(Refused):
        codec.decode(payload, codec.encoding_of(ColorFrame))


def test_a_huge_declared_segment_is_refused_without_memory() -> None:
    header = codec.encode(next(one for one in examples() if isinstance(one, ColorFrame)))
    swollen = header.replace(b"\x93\x02\x03\x03", b"\x93\xce\x7f\xff\xff\xff"[:4])
    with pytest.raises(Refused):
        codec.decode(swollen, codec.encoding_of(ColorFrame))


def test_random_bytes_are_refused_and_never_crash() -> None:
    rng = np.random.default_rng(11)
    for kind in topics.TYPES.values():
        for _ in range(60):
            payload = rng.bytes(int(rng.integers(0, 90)))
            with pytest.raises(Refused):
                codec.decode(payload, codec.encoding_of(kind))


def test_mutated_messages_are_refused_or_fit() -> None:
    rng = np.random.default_rng(12)
    outcomes = {"fits": 0, "refused": 0}
    for message in examples():
        golden = codec.encode(message)
        for _ in range(120):
            mutated = bytearray(golden)
            for _ in range(int(rng.integers(1, 4))):
                mutated[int(rng.integers(len(mutated)))] = int(rng.integers(256))
            outcomes[_outcome(bytes(mutated), codec.encoding_of(type(message)))] += 1
    assert outcomes["refused"] > 500
    assert outcomes["fits"] > 100


def _outcome(payload: bytes, encoding: str) -> str:
    """Anything but a message or a refusal would raise here."""
    try:
        codec.decode(payload, encoding)
    except Refused:
        return "refused"
    return "fits"


def test_plain_text_becomes_an_instruction() -> None:
    message = codec.decode_text("bring me the café's cup".encode(), Instruction)
    assert message == Instruction(text="bring me the café's cup")


def test_settings_of_the_deploy_folder_fit_every_service() -> None:
    settings = load_settings("bus", BusSettings, ROOT / "deploy" / "doro.toml")
    assert settings.endpoint == "tcp/127.0.0.1:7447"


def test_overrides_and_unknown_settings(tmp_path: Path) -> None:
    path = tmp_path / "doro.toml"
    path.write_text('[bus]\nnamespace = "r1"\n', encoding="utf-8")
    settings = load_settings(
        "bus", BusSettings, path, ["bus.ask_timeout_s=2", "other.x=1", "bus.config=a.json5"]
    )
    assert (settings.namespace, settings.ask_timeout_s, settings.config) == ("r1", 2.0, "a.json5")
    with pytest.raises(Refused, match=r"setting bus\.port is unknown; known are"):
        load_settings("bus", BusSettings, path, ["bus.port=1"])
    with pytest.raises(Refused, match=r"\[bus\]"):
        load_settings("bus", BusSettings, path, ["bus.ask_timeout_s=soon"])
    with pytest.raises(Refused, match="cannot be read"):
        load_settings("bus", BusSettings, tmp_path / "missing.toml")


@pytest.mark.parametrize("name", ["router", "client"])
def test_deploy_holds_the_zenoh_configuration_that_is_built_in(name: str) -> None:
    text = (ROOT / "deploy" / "zenoh" / f"{name}.json5").read_text(encoding="utf-8")
    shown = msgspec.json.decode("\n".join(x for x in text.splitlines() if not x.startswith("//")))
    settings = BusSettings()
    assert shown == (router_config if name == "router" else client_config)(settings)


def test_only_loopback_by_default() -> None:
    config = msgspec.json.decode(config_text(BusSettings(), router=True))
    assert config["listen"]["endpoints"] == ["tcp/127.0.0.1:7447"]
    assert config["scouting"]["multicast"]["interface"] == "lo"


def test_a_slow_reader_keeps_the_newest_droppable_items() -> None:
    inbox, seen, dropped = Inbox(), [], []
    lane = Lane(4, seen.append, lambda: dropped.append(1))
    for number in range(10):
        inbox.put(lane, number, droppable=True)
    _drain(inbox)
    assert seen == [6, 7, 8, 9]
    assert len(dropped) == 6


def test_what_may_not_be_dropped_is_kept_in_order() -> None:
    inbox, seen = Inbox(), []
    lane = Lane(4, seen.append, lambda: None)
    other: list[int] = []
    second = Lane(0, other.append, lambda: None)
    for number in range(10):
        inbox.put(lane, number)
        inbox.put(second, number)
    _drain(inbox)
    assert seen == other == list(range(10))


def test_stop_wakes_the_reader() -> None:
    inbox = Inbox()
    threading.Thread(target=inbox.stop).start()
    assert inbox.take(5.0) is None


def test_topics_are_unique_and_complete() -> None:
    keys = [topic.key for topic in topics.TABLE]
    assert len(set(keys)) == len(keys)
    kinds = [kind for topic in topics.TABLE for kind in topic.messages]
    assert len(set(kinds)) == len(kinds)  # a type travels on one topic
    assert topics.topic_of(FrameCaptions).name == "captions"
    assert topics.TOPICS["color"].key_for(camera="left") == "doro/frames/left/color"
    assert topics.TOPICS["health"].pattern == "doro/*/health"


def _drain(inbox: Inbox) -> None:
    while True:
        try:
            taken = inbox.take(0.0)
        except queue.Empty:
            return
        assert taken is not None
        lane, item = taken
        lane.handle(item)
