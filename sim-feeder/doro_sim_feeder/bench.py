"""How fast, and how evenly, recordings play: a sink that acknowledges takes the chain's place.

``python -m doro_sim_feeder.bench sink ENDPOINT`` is the sink's process.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from doro_schemas.bus import Bus, BusSettings
from doro_schemas.messages import DepthFrame, Exploration, GridDelta
from doro_schemas.messages.base import FrameMessage, Message
from doro_schemas.topics import TOPICS
from doro_sim_feeder.play import Player, PlaySettings
from doro_sim_feeder.presence import Presence
from doro_sim_feeder.recording import Recording, write_recording

FRAMES = 167
FRAME_PERIOD_NS = 100_000_000
SINK = "sink"
READY_S = 30.0


def run_bench(
    sample: Path, endpoint: str, paced_frames: int, progress: Callable[[int, int], None]
) -> dict[str, Any]:
    """Play the paper's 167 views at 300x300 with nothing else limiting; return figures.

    Args:
        sample: a recording whose frames are played over and over.
        endpoint: where the bench's own router shall listen.
        paced_frames: frames of the second play, in real time.
        progress: called with frames sent and taken.
    """
    router = subprocess.Popen(
        [sys.executable, "-m", "doro_schemas.router", "--set", f"bus.endpoint={endpoint}"]
    )
    sink = subprocess.Popen([sys.executable, "-m", "doro_sim_feeder.bench", SINK, endpoint])
    try:
        with (
            tempfile.TemporaryDirectory() as folder,
            Bus("bench", BusSettings(endpoint=endpoint)) as bus,
        ):
            Presence(bus).wait_for([SINK], READY_S)
            path = Path(folder) / "bench.mcap"
            write_recording(path, repeated(sample, FRAMES))
            fast = Player(bus, PlaySettings(), progress).play(Recording(path))
            write_recording(path, repeated(sample, paced_frames))
            paced = Player(bus, PlaySettings(speed=1.0), progress).play(Recording(path))
        real_s = FRAMES * FRAME_PERIOD_NS / 1e9
        return {
            "speed/play/frames": fast.merged,
            "speed/play/elapsed_s": round(fast.elapsed_s, 3),
            "speed/play/times_real_time": round(real_s / fast.elapsed_s, 1),
            "speed/play/pacing_p95_ms": round(paced.pacing_p95_ms, 3),
            "speed/play/paced_elapsed_s": round(paced.elapsed_s, 3),
            "speed/play/lost": fast.lost + paced.lost,
        }
    finally:
        for process in (sink, router):
            process.terminate()
            process.wait(10)


def repeated(sample: Path, count: int) -> Iterator[Message]:
    """Yield an episode of ``count`` frames at 10 Hz from the frames of a recording."""
    frames: dict[int, list[FrameMessage]] = {}
    for one in Recording(sample).samples():
        message = one.message()
        if isinstance(message, FrameMessage):
            frames.setdefault(message.frame, []).append(message)
    groups = list(frames.values())
    yield Exploration(state="started", episode="bench")
    for number in range(count):
        for message in groups[number % len(groups)]:
            yield msgspec.structs.replace(
                message, episode="bench", frame=number, stamp_ns=number * FRAME_PERIOD_NS
            )
    stamp_ns = count * FRAME_PERIOD_NS
    yield Exploration(state="finished", episode="bench", stamp_ns=stamp_ns, frames=count)


def sink(endpoint: str) -> None:
    """Take frames and acknowledge each, as a mapper would, until SIGTERM."""
    with Bus(SINK, BusSettings(endpoint=endpoint)) as bus:
        bus.stop_on_signals()

        def acknowledge(message: Message) -> None:
            reset = isinstance(message, Exploration) and message.state == "started"
            if not reset and not isinstance(message, DepthFrame):
                return
            frame = message.frame if isinstance(message, DepthFrame) else -1
            bus.publish(
                GridDelta(
                    episode=message.episode,
                    seq=frame + 1,
                    reset=reset,
                    frame=frame,
                    frames_merged=frame + 1,
                    cell_m=0.05,
                    band_m=0.1,
                    cells=np.zeros((0, 6), np.int32),
                    weights=np.zeros(0, np.float32),
                )
            )

        for name in ("exploration", "color", "depth", "sim_detections"):
            bus.subscribe(TOPICS[name], acknowledge, late=False)
        bus.declare_alive()
        bus.run_until(None)


if __name__ == "__main__":
    sink(sys.argv[2])
