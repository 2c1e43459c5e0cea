"""Speed of the whole way on recordings: per frame and per question, CPU time of one thread.

The paper gives 32 ms (BERT) and 3 ms (Bi-LSTM) for its taggers and calls its aggregation
real-time without a figure; here each stage is timed on real recordings. CPU time, so that other
work on the machine does not count; the wall clock stands beside.
"""

from __future__ import annotations

import os
import platform
import time
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path

import msgspec
import numpy as np
from rich.table import Table

from doro_dialogue.facts import Candidate
from doro_evaluation.chain import Language, load_room
from doro_evaluation.context import Context, Recorded
from doro_evaluation.figures import Figure
from doro_evaluation.queries.pairs import Pair
from doro_evaluation.queries.systems import Speaker
from doro_mapper.core import Mapper
from doro_nlu.core import Nlu
from doro_schemas.messages import FrameGraphs, InstancesRequest

PAPER_MS = {"default": 32.0, "bilstm": 3.0}
"""The paper's BERT tagger, which the shipped encoder stands for, and its Bi-LSTM, on 3.7 GHz."""
STAGES = {
    "captions": "captions of a frame to graphs (nlu)",
    "aggregation": "a frame into the map (mapper)",
    "instances": "all instances of the map after another frame (mapper)",
    "question": "instruction to query, the map at hand (nlu, dialogue)",
}
WARM_UP = 10
NS_PER_MS = 1e6


class Timed(msgspec.Struct, frozen=True):
    """Time of one call of a stage, nanoseconds: of the thread, and of the wall."""

    stage: str
    cpu_ns: int
    wall_ns: int


class _Clock:
    """Takes the times of calls."""

    def __init__(self) -> None:
        self.found: list[Timed] = []
        self._began = (0, 0)

    def start(self) -> None:
        self._began = time.thread_time_ns(), time.perf_counter_ns()

    def stop(self, stage: str) -> None:
        cpu_ns, wall_ns = time.thread_time_ns(), time.perf_counter_ns()
        self.found.append(Timed(stage, cpu_ns - self._began[0], wall_ns - self._began[1]))


def time_recording(recording: Recorded, pairs: Sequence[Pair], context: Context) -> list[Timed]:
    """Return the times of all frames and pairs of a recording under no error, from fresh caches."""
    room, clock = load_room(Path(recording.path)), _Clock()
    nlu, mapper = Nlu(context.nlu), Mapper(context.mapper)
    captions = Language(context.perception, context.nlu).captions(room)
    mapper.exploration(room.start())
    for view, said in enumerate(captions):
        clock.start()
        graphs = [one for one in nlu.captions(said) if isinstance(one, FrameGraphs)]
        clock.stop("captions")
        clock.start()
        mapper.depth_frame(room.depths[view])
        for one in graphs:
            mapper.frame_graphs(one)
        clock.stop("aggregation")
        if view < WARM_UP:
            clock.found.clear()
    clock.start()
    answer = mapper.instances(InstancesRequest())
    clock.stop("instances")
    candidates = [Candidate(one.instance_id, one.graph) for one in answer.instances]
    speaker = Speaker(nlu, "ours")
    for pair in pairs:
        clock.start()
        speaker.say(pair, candidates, answer.unseen_share)
        clock.stop("question")
    return clock.found


def machine() -> str:
    """Return what it was measured on, in one line."""
    model = platform.processor() or platform.machine()
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        named = [line.split(":")[1].strip() for line in lines if line.startswith("model name")]
        model = named[0] if named else model
    except OSError:
        pass  # not Linux: what Python says must do
    load = f", load {os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else ""
    return (
        f"{model}, {os.cpu_count()} cores, {platform.system()}, Python"
        f" {platform.python_version()}, ONNX Runtime {version('onnxruntime')},"
        f" numpy {version('numpy')}, one thread{load}"
    )


def figures_of(found: Sequence[Timed], recordings: int) -> dict[str, Figure]:
    """Return ``speed/<stage>/p50_ms`` and so on: CPU time; ``..._wall_...``: the wall clock."""
    figures: dict[str, Figure] = {"speed/machine": machine(), "speed/recordings": recordings}
    for stage in STAGES:
        own = [one for one in found if one.stage == stage]
        if not own:
            continue
        for name, values in (
            ("", [one.cpu_ns for one in own]),
            ("wall_", [one.wall_ns for one in own]),
        ):
            p50, p99 = np.percentile(values, [50, 99]) / NS_PER_MS
            figures[f"speed/{stage}/{name}p50_ms"] = round(float(p50), 3)
            figures[f"speed/{stage}/{name}p99_ms"] = round(float(p99), 3)
        figures[f"speed/{stage}/calls"] = len(own)
    return figures


def table_of(figures: dict[str, Figure]) -> Table:
    """Return the stages: median and 99th percentile, CPU time and wall clock."""
    table = Table(
        "one thread, ms", "CPU p50", "CPU p99", "wall p50", "wall p99", "calls", title="Speed"
    )
    for stage, title in STAGES.items():
        names = ("p50_ms", "p99_ms", "wall_p50_ms", "wall_p99_ms", "calls")
        if f"speed/{stage}/p50_ms" in figures:
            table.add_row(title, *(str(figures[f"speed/{stage}/{name}"]) for name in names))
    table.caption = str(figures["speed/machine"])
    return table
