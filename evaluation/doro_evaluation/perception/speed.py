"""How long the captioner takes for a frame with ten things, and how much memory it needs.

Wall-clock times of a busy machine say more about the others than about the detector: the median
of the process's CPU time stands beside them, which one thread would take on an idle machine.
"""

from __future__ import annotations

import resource
import time
from collections.abc import Sequence

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
    """Return milliseconds a frame, ``perception_speed/<threads>/...``, and the peak memory of the
    process with the first captioner, the evaluation's own share included.

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
        # Later captioners lie beside the first one's memory.
        peak_kb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        figures.setdefault("perception_speed/peak_memory_mb", round(peak_kb / 1024, 0))
    return figures
