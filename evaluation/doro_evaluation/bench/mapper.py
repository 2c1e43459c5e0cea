"""Speed and memory of the mapper over 2,000 frames, and of a ConceptGraphs-like association.

The frames are those of a scene (:mod:`doro_evaluation.bench.mapper_scenes`), over and over, no two
equal. Making them is not timed; merging is (``depth_frame`` and ``frame_graphs``). Times are CPU
times of the whole process, which a busy machine disturbs less; wall-clock times stand beside
them.
"""

from __future__ import annotations

import gc
import multiprocessing
import os
import sys
import time
import types
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from doro_evaluation.bench.mapper_scenes import EPISODE, Endless, Pair, scene_of
from doro_evaluation.counting.conceptgraphs import ConceptGraphsLike
from doro_evaluation.figures import Figure
from doro_mapper.core import Mapper
from doro_mapper.settings import MapperSettings
from doro_schemas.messages import Exploration, InstancesRequest

FRAMES, BASELINE_FRAMES, LARGE_FRAMES, QUERIES = 2000, 300, 200, 20
DETECTIONS, LARGE_DETECTIONS, LONG_DETECTIONS = 8, 20, 2
LARGE_PX, LONG_PX = (480, 640), (100, 100)
DEFAULT_SCENE = "room"
WANTED = {
    "frame_300_p50_ms": "< 2",
    "frame_300_p99_ms": "< 6",
    "flatness": "about 1",
    "query_after_2000_frames_ms": "< 5",
    "state_after_2000_frames_mb": "< 20",
    "frame_640_p50_ms": "< 8",
}
"""What is wanted, on an idle core."""
EARLY, LATE, WARM_UP = 200, 200, 10


class Times(msgspec.Struct):
    """CPU and wall-clock times of frames, seconds."""

    cpu_s: list[float] = []
    wall_s: list[float] = []

    def add(self, cpu_s: float, wall_s: float) -> None:
        self.cpu_s.append(cpu_s)
        self.wall_s.append(wall_s)

    def percentile_ms(self, percent: float, *, wall: bool = False) -> float:
        values = (self.wall_s if wall else self.cpu_s)[WARM_UP:]
        return float(np.percentile(values, percent)) * 1000


def wanted(name: str) -> str:
    """Return what is wanted of a figure, in whatever scene; empty where nothing is."""
    return WANTED.get(name.rpartition("/")[2], "") if name.startswith("speed/mapper/") else ""


def run_bench(scenes: Sequence[str], recording: Path, frames: int = FRAMES) -> dict[str, Figure]:
    """Return the figures of scenes, measured in a process with one thread.

    Args:
        scenes: see :mod:`doro_evaluation.bench.mapper_scenes`.
        recording: of the scene ``fronts``.
    """
    return _alone(_all, scenes, recording, frames)


def _all(scenes: Sequence[str], recording: Path, frames: int) -> dict[str, Figure]:
    figures: dict[str, Figure] = {}
    for scene in scenes:
        figures |= measure(scene, recording, frames)
    return figures


def run_long(recording: Path, frames: int) -> dict[str, Figure]:
    """Return memory and time of a long run of cheap frames, in a process with one thread."""
    return _alone(measure_long, "fronts", recording, frames)


def _alone(task: Any, scene: Any, recording: Path, frames: int) -> dict[str, Figure]:
    os.environ["OMP_NUM_THREADS"] = "1"
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, mp_context=spawn) as pool:
        figures: dict[str, Figure] = pool.submit(task, scene, recording, frames).result()
        return figures


def measure(
    scene: str, recording: Path, frames: int = FRAMES, large_frames: int = LARGE_FRAMES
) -> dict[str, Figure]:
    """Measure in this process; see :func:`run_bench`.

    The default scene's figures are ``speed/mapper/...``, another's ``speed/mapper/<scene>/...``.
    """
    shown = scene_of(scene, recording)
    pairs = Endless(shown, DETECTIONS)
    figures, times = _merged(pairs, frames)
    figures |= _baseline(pairs, times, min(frames, BASELINE_FRAMES))
    # No view of the room shows as many as large frames are to have.
    large = scene_of("home", recording) if scene == "room" else shown
    figures |= _large(Endless(large, LARGE_DETECTIONS, LARGE_PX), large_frames)
    prefix = "speed/mapper/" if scene == DEFAULT_SCENE else f"speed/mapper/{scene}/"
    return {prefix + name: value for name, value in figures.items()}


def _merged(pairs: Endless, frames: int) -> tuple[dict[str, Figure], Times]:
    mapper = _started()
    gc.collect()
    times = Times()
    for number in range(frames):
        _timed(mapper, pairs.make(number), times)
    query = Times()
    for number in range(frames, frames + QUERIES + WARM_UP):
        _timed(mapper, pairs.make(number), Times())
        started = time.process_time(), time.perf_counter()
        mapper.instances(InstancesRequest())
        query.add(time.process_time() - started[0], time.perf_counter() - started[1])
    early = np.median(times.cpu_s[WARM_UP:EARLY])
    late = np.median(times.cpu_s[-LATE:])
    return {
        "frames": frames,
        "views": pairs.views,
        "frame_300_p50_ms": _ms(times.percentile_ms(50)),
        "frame_300_p99_ms": _ms(times.percentile_ms(99)),
        "frame_300_p50_wall_ms": _ms(times.percentile_ms(50, wall=True)),
        "frame_300_p99_wall_ms": _ms(times.percentile_ms(99, wall=True)),
        "frame_300_early_p50_ms": _ms(float(early) * 1000),
        "frame_300_late_p50_ms": _ms(float(late) * 1000),
        "flatness": round(float(late / early), 3),
        f"query_after_{frames}_frames_ms": _ms(query.percentile_ms(50)),
        f"query_after_{frames}_frames_wall_ms": _ms(query.percentile_ms(50, wall=True)),
        f"state_after_{frames}_frames_mb": round(deep_bytes(mapper) / 1e6, 2),
        "instances": len(mapper.instances(InstancesRequest()).instances),
    }, times


def _started() -> Mapper:
    mapper = Mapper(MapperSettings())
    mapper.exploration(Exploration(episode=EPISODE, state="started"))
    return mapper


def measure_long(scene: str, recording: Path, frames: int) -> dict[str, Figure]:
    """Merge many small frames of two detections; memory and times of each tenth."""
    pairs = Endless(scene_of(scene, recording), LONG_DETECTIONS, LONG_PX)
    mapper, figures = _started(), dict[str, Figure]()
    tenth = max(1, frames // 10)
    for part in range(10):
        times = Times()
        for number in range(part * tenth, (part + 1) * tenth):
            _timed(mapper, pairs.make(number), times)
        done = (part + 1) * tenth
        figures[f"speed/mapper/long/state_after_{done}_frames_mb"] = round(
            deep_bytes(mapper) / 1e6, 2
        )
        median_s = float(np.median(times.cpu_s))
        figures[f"speed/mapper/long/frame_p50_up_to_{done}_ms"] = _ms(median_s * 1000)
    return figures


def _baseline(pairs: Endless, ours: Times, frames: int) -> dict[str, Figure]:
    """Return the times of the ConceptGraphs-like association on the same first frames."""
    association, times = ConceptGraphsLike(), Times()
    for number in range(frames):
        depth, graphs = pairs.make(number)
        started = time.process_time(), time.perf_counter()
        association.add(depth, graphs)
        times.add(time.process_time() - started[0], time.perf_counter() - started[1])
    ratio = sum(times.cpu_s[WARM_UP:]) / sum(ours.cpu_s[WARM_UP:frames])
    return {
        "conceptgraphs_like_frames": frames,
        "conceptgraphs_like_frame_300_p50_ms": _ms(times.percentile_ms(50)),
        "conceptgraphs_like_frame_300_p99_ms": _ms(times.percentile_ms(99)),
        "ratio_to_conceptgraphs_like": round(ratio, 2),
    }


def _large(pairs: Endless, frames: int) -> dict[str, Figure]:
    """Return the times at 640x480 with 20 detections a frame."""
    mapper, times = _started(), Times()
    for number in range(frames):
        _timed(mapper, pairs.make(number), times)
    return {
        "frame_640_p50_ms": _ms(times.percentile_ms(50)),
        "frame_640_p99_ms": _ms(times.percentile_ms(99)),
        "frame_640_p50_wall_ms": _ms(times.percentile_ms(50, wall=True)),
    }


def _timed(mapper: Mapper, pair: Pair, times: Times) -> None:
    depth, graphs = pair
    started = time.process_time(), time.perf_counter()
    mapper.depth_frame(depth)
    mapper.frame_graphs(graphs)
    times.add(time.process_time() - started[0], time.perf_counter() - started[1])


def deep_bytes(root: object) -> int:
    """Return the bytes of all objects that are reachable from ``root``, each counted once.

    Arrays count with what they own; of a view, the array that it looks into. Code (modules,
    classes, functions) does not count.
    """
    seen: set[int] = set()
    total = 0
    for item in _reachable(root, seen):
        total += sys.getsizeof(item)
    return total


def _reachable(root: object, seen: set[int]) -> Iterator[object]:
    code = (type, types.ModuleType, types.FunctionType, types.MethodType, types.CodeType)
    left: list[object] = [root]
    while left:
        item = left.pop()
        if id(item) in seen or isinstance(item, (*code, types.BuiltinFunctionType)):
            continue
        seen.add(id(item))
        yield item
        left.extend(gc.get_referents(item))
        left.extend(_hidden(item))


def _hidden(item: object) -> list[Any]:
    """Return what the garbage collector does not see: bases of views, fields of untracked."""
    if isinstance(item, np.ndarray):
        base: NDArray[Any] | None = item.base
        return [] if base is None else [base]
    if isinstance(item, (list, tuple)):
        return list(item)
    if isinstance(item, dict):
        return [*item.keys(), *item.values()]
    return []


def _ms(value: float) -> float:
    return round(value, 3)
