"""How long the captioner takes for a frame with ten things, and how much memory it needs.

Wall-clock times of a busy machine say more about the others than about the detector: the median
of the process's CPU time stands beside them, which one thread would take on an idle machine.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from multiprocessing import get_context
from pathlib import Path

import msgspec
import numpy as np

from doro_evaluation.figures import Figure
from doro_perception.backend import RgbImage
from doro_perception.captioner import Captioner
from doro_perception.settings import PerceptionSettings
from doro_perception.stages import Stages

THINGS, ROUNDS = 10, 60


def measure_speed(
    images: Sequence[RgbImage], settings: PerceptionSettings, threads: Sequence[int] = (1, 2)
) -> dict[str, Figure]:
    """Return milliseconds a frame, ``perception_speed/<threads>/...``, and the peak memory of a
    process of its own that does nothing but look at the images with one captioner.

    Args:
        images: frames in turn; each is made to have ten boxes, whatever it shows.
    """
    figures: dict[str, Figure] = {}
    for count in threads:
        use = msgspec.structs.replace(
            settings, threads=count, max_boxes=THINGS, candidate_score=0.0
        )
        stages = Stages(time.perf_counter)
        captioner = Captioner(use, stages)
        captioner.warm_up()
        wall_ms, cpu_ms, boxes = [], [], []
        laps: dict[str, list[float]] = {}
        for number in range(ROUNDS):
            image = images[number % len(images)]
            stages.start()
            started, cpu = time.perf_counter(), time.process_time()
            captioner.detect(image)
            wall_ms.append((time.perf_counter() - started) * 1e3)
            cpu_ms.append((time.process_time() - cpu) * 1e3)
            for name, spent_us in stages.taken_us().items():
                laps.setdefault(name, []).append(spent_us / 1e3)
            boxes.append(len(captioner.propose(image).boxes))
        prefix = f"perception_speed/{count}_threads"
        figures[f"{prefix}/wall_p50_ms"] = round(float(np.median(wall_ms)), 1)
        figures[f"{prefix}/wall_best_ms"] = round(min(wall_ms), 1)
        figures[f"{prefix}/cpu_p50_ms"] = round(float(np.median(cpu_ms)), 1)
        figures[f"{prefix}/boxes"] = round(float(np.mean(boxes)), 1)
        for name, spent in sorted(laps.items()):
            figures[f"{prefix}/{name}_p50_ms"] = round(float(np.median(spent)), 1)
    with get_context("spawn").Pool(1) as pool:
        peak_mb = pool.apply(_peak_memory_mb, (settings, list(images)))
    figures["perception_speed/peak_memory_mb"] = peak_mb
    return figures


def _peak_memory_mb(settings: PerceptionSettings, images: list[RgbImage]) -> float:
    captioner = Captioner(
        msgspec.structs.replace(settings, max_boxes=THINGS, candidate_score=0.0, threads=1)
    )
    for image in images:
        captioner.detect(image)
    # Not getrusage: a child's figure begins with what its parent needed.
    status = Path("/proc/self/status").read_text(encoding="ascii")
    (peak_kb,) = (row.split()[1] for row in status.splitlines() if row.startswith("VmHWM:"))
    return round(int(peak_kb) / 1024, 0)
