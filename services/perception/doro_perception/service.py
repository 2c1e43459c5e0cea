"""The shell of perception: subscribes to what the chosen backend needs."""

from __future__ import annotations

from pathlib import Path

from doro_perception.core import Perception
from doro_perception.onnx_ssd import OnnxSsd
from doro_perception.settings import PerceptionSettings
from doro_schemas.detector_errors import read_pool
from doro_schemas.messages import ColorFrame, SimDetections
from doro_schemas.runner import Shell, run_service


def wire(shell: Shell, settings: PerceptionSettings) -> None:
    """Connect the core to its topics; a detector is loaded and warmed up before this returns."""
    if settings.backend == "oracle":
        pool = read_pool(Path(settings.fp_pool)) if settings.fp_pool else None
        core = Perception(settings, pool=pool)
        shell.on(SimDetections, core.sim_detections)
    else:
        detector = OnnxSsd(settings)
        detector.warm_up()
        core = Perception(settings, detector)
        shell.on(ColorFrame, core.color_frame)
    shell.counters(lambda: core.counters)


def main() -> None:
    """Run the service until SIGTERM."""
    run_service("perception", PerceptionSettings, wire)
