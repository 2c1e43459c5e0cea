"""The shell of perception: subscribes to what the chosen backend needs."""

from __future__ import annotations

import time
from pathlib import Path

from doro_perception.backends import make_backend
from doro_perception.core import Perception
from doro_perception.settings import PerceptionSettings
from doro_perception.stages import Stages
from doro_schemas.detector_errors import read_pool
from doro_schemas.messages import ColorFrame, DepthFrame, SimDetections
from doro_schemas.runner import Shell, run_service


def wire(shell: Shell, settings: PerceptionSettings) -> None:
    """Connect the core to its topics; a detector is loaded and warmed up before this returns."""
    if settings.backend == "oracle":
        pool = read_pool(Path(settings.fp_pool)) if settings.fp_pool else None
        core = Perception(settings, pool=pool)
        shell.on(SimDetections, core.sim_detections)
    else:
        stages = Stages(time.perf_counter)
        detector = make_backend(settings, stages)
        if detector is not None:
            detector.warm_up()
        core = Perception(settings, detector, stages=stages)
        shell.on(ColorFrame, core.color_frame, newest=True)
        if settings.relations == "depth":
            shell.on(DepthFrame, core.depth_frame)
    shell.counters(lambda: core.counters)


def main() -> None:
    """Run the service until SIGTERM."""
    run_service("perception", PerceptionSettings, wire)
