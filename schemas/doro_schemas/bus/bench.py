"""Our bus beside raw zenoh with the same settings: publish-to-receive, in one run.

Two processes on one embedded router. The sender alternates raw and ours, message by
message, so that both see the same noise; the receiver keeps the time from just before
publishing to the moment when the application has it: raw bytes there, a validated message
with us. ``python -m doro_schemas.bus.bench receive ENDPOINT COUNT`` is the receiving process.
"""

from __future__ import annotations

import json
import socket
import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from typing import Any

import msgspec
import numpy as np
import zenoh

from doro_schemas import codec
from doro_schemas.bus.config import BusSettings
from doro_schemas.bus.links import declare_publisher, declare_subscriber
from doro_schemas.bus.session import Bus
from doro_schemas.camera import intrinsics_from_vertical_fov, pose_from_ai2thor
from doro_schemas.messages import CaptionedBox, ColorFrame, DepthFrame, FrameCaptions, Rejected
from doro_schemas.messages.base import Message
from doro_schemas.topics import TOPICS

RAW = "raw"
SERIES = ("1kB", "rgbd")
RATE_HZ = {"1kB": 200.0, "rgbd": 20.0}
WARM_UP = 20
END_EPISODE = "end"
READY = "ready"
LAST_FRAMES_S = 5.0


def caption_message(stamp_ns: int, number: int) -> FrameCaptions:
    """Return a message of about 1 kB: a frame with eight captions."""
    box = CaptionedBox([10.0, 20.0, 60.0, 80.0], 0.9, "a red plastic cup on the white table")
    return FrameCaptions(
        stamp_ns=stamp_ns, frame=number, height_px=480, width_px=640, detections=[box] * 8
    )


def frame_messages(stamp_ns: int, number: int) -> list[Message]:
    """Return a 640x480 RGB-D frame of 1.54 MB: raw colour and 16-bit depth."""
    common: dict[str, Any] = {
        "stamp_ns": stamp_ns,
        "frame": number,
        "height_px": 480,
        "width_px": 640,
    }
    return [
        ColorFrame(**common, data=np.ones((480, 640, 3), np.uint8)),
        DepthFrame(
            **common,
            encoding="u16_mm",
            intrinsics=intrinsics_from_vertical_fov(480, 640, 90.0),
            pose=pose_from_ai2thor((0.0, 1.5, 0.0), 0.0, 0.0),
            data=np.ones((480, 640), np.uint16),
        ),
    ]


class RawSender:
    """Raw zenoh: publishers declared with the same policy, bytes prepared beforehand."""

    def __init__(self, bus: Bus) -> None:
        self._publishers = {
            name: declare_publisher(bus.session, TOPICS[name], _raw_key(name), block=True)
            for name in ("captions", "color", "depth")
        }
        sizes = {"captions": len(codec.encode(caption_message(0, 0)))}
        for message, name in zip(frame_messages(0, 0), ("color", "depth"), strict=True):
            sizes[name] = len(codec.encode(message))
        self._bodies = {
            # Pages that were written to: fresh zeros would all be one cached page.
            name: b"\x01" * (size - 8)
            for name, size in sizes.items()
        }

    def send(self, series: str) -> None:
        for name in ("captions",) if series == "1kB" else ("color", "depth"):
            stamp = time.monotonic_ns().to_bytes(8, "little")
            self._publishers[name].put(stamp + self._bodies[name])


def send_ours(bus: Bus, messages: list[Message]) -> None:
    """Publish one message (1 kB) or two (colour, depth) through our shell, encoding included.

    The messages stand, as a camera's buffers do; only the stamp is new.
    """
    for message in messages:
        message.stamp_ns = time.monotonic_ns()
        bus.publish(message, lossless=True)


def run_bench(count: int, progress: Callable[[str, int], None]) -> dict[str, Any]:
    """Measure and return figures: medians in microseconds, differences and ratios.

    Args:
        count: messages per series and side.
        progress: called with the series and the number of messages sent.
    """
    endpoint = f"tcp/127.0.0.1:{_free_port()}"
    router = subprocess.Popen(
        [sys.executable, "-m", "doro_schemas.router", "--set", f"bus.endpoint={endpoint}"]
    )
    receiver = subprocess.Popen(
        [sys.executable, "-m", "doro_schemas.bus.bench", "receive", endpoint, str(count + WARM_UP)],
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        assert receiver.stdout is not None
        if receiver.stdout.readline().strip() != READY:
            raise RuntimeError("the receiving process did not start")
        with Bus("bench", BusSettings(endpoint=endpoint)) as bus:
            _send_all(bus, count, progress)
            bus.publish(Rejected(service="bench", key="", reason="end", episode=END_EPISODE))
            return _figures(json.loads(receiver.stdout.readline()))
    finally:
        for process in (receiver, router):
            process.terminate()
            process.wait(10)


def _send_all(bus: Bus, count: int, progress: Callable[[str, int], None]) -> None:
    raw = RawSender(bus)
    messages: dict[str, list[Message]] = {
        "1kB": [caption_message(0, 0)],
        "rgbd": frame_messages(0, 0),
    }
    for series in SERIES:
        period_s = 1.0 / RATE_HZ[series]
        due_s = time.monotonic() + 0.5
        for number in range(count + WARM_UP):
            for ours in (number % 2 == 0, number % 2 == 1):
                # Waiting on the bus until the next slot is what a paced publisher does.
                bus.run_until(due_s)
                due_s = max(due_s + period_s / 2, time.monotonic())
                if ours:
                    send_ours(bus, messages[series])
                else:
                    raw.send(series)
            progress(series, number + 1)


def receive(endpoint: str, expected: int) -> None:
    """Receive until the end message and all that was sent, then print the latencies as JSON.

    The end travels on another key and at a higher priority, so it may come before the last
    frames: these are waited for, but not for ever.
    """
    latencies: dict[str, list[float]] = {
        f"{who}/{s}": [] for who in ("raw", "ours") for s in SERIES
    }
    halves: dict[str, int] = {}

    def note(who: str, topic: str, sent_ns: int) -> None:
        now_ns = time.monotonic_ns()
        if topic == "captions":
            latencies[f"{who}/1kB"].append((now_ns - sent_ns) / 1e3)
        elif who in halves:
            # Colour and depth are two keys, and either may come first.
            first_ns = min(sent_ns, halves.pop(who))
            latencies[f"{who}/rgbd"].append((now_ns - first_ns) / 1e3)
        else:
            halves[who] = sent_ns

    def ours(topic: str, message: Message) -> None:
        note("ours", topic, message.stamp_ns)

    def raw(topic: str, sample: zenoh.Sample) -> None:
        note("raw", topic, _stamp_of(sample))

    with Bus("bench-receiver", BusSettings(endpoint=endpoint)) as bus:
        kept: list[Any] = []
        for name in ("captions", "color", "depth"):
            bus.subscribe(TOPICS[name], partial(ours, name))
            kept += declare_subscriber(
                bus.session,
                _raw_topic(name),
                partial(raw, name),
                late=0,
                missed=lambda _count: None,
            )
        ended: list[Message] = []
        bus.subscribe(TOPICS["rejected"], ended.append, late=False)
        print(READY, flush=True)
        bus.run_until(time.monotonic() + 600, lambda: bool(ended))
        deadline_s = time.monotonic() + LAST_FRAMES_S
        while min(map(len, latencies.values())) < expected and time.monotonic() < deadline_s:
            bus.run_until(time.monotonic() + 0.05)
        for item in kept:
            item.undeclare()
        print(json.dumps(latencies), flush=True)


def _stamp_of(sample: zenoh.Sample) -> int:
    """Take the bytes out, as an application must, and read the time they were sent."""
    return int.from_bytes(sample.payload.to_bytes()[:8], "little")


def _raw_key(name: str) -> str:
    return f"{RAW}/{TOPICS[name].key_for(camera='cam0')}"


def _raw_topic(name: str) -> Any:
    return msgspec.structs.replace(TOPICS[name], key=_raw_key(name))


def _figures(latencies: dict[str, list[float]]) -> dict[str, Any]:
    figures: dict[str, Any] = {}
    for series in SERIES:
        raw, ours = (sorted(latencies[f"{who}/{series}"][WARM_UP:]) for who in ("raw", "ours"))
        medians = raw[len(raw) // 2], ours[len(ours) // 2]
        figures[f"speed/bus/{series}_raw_p50_us"] = round(medians[0], 1)
        figures[f"speed/bus/{series}_ours_p50_us"] = round(medians[1], 1)
        figures[f"speed/bus/{series}_added_us"] = round(medians[1] - medians[0], 1)
        figures[f"speed/bus/{series}_ratio"] = round(medians[1] / medians[0], 3)
        figures[f"speed/bus/{series}_received"] = min(len(raw), len(ours))
    return figures


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
    return port


if __name__ == "__main__":
    receive(sys.argv[2], int(sys.argv[3]))
