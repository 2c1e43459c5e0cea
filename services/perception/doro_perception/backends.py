"""The backends that look at images, by their names in the settings."""

from __future__ import annotations

from collections.abc import Callable

from doro_perception.backend import DetectionBackend
from doro_perception.captioner import Captioner
from doro_perception.coco import CocoSsd
from doro_perception.own import OwnDetector
from doro_perception.settings import PerceptionSettings
from doro_perception.stages import Stages

LOOKING: dict[str, Callable[[PerceptionSettings, Stages], DetectionBackend]] = {
    "captioner": Captioner,
    "coco": CocoSsd,
    "onnx": OwnDetector,
}


def make_backend(settings: PerceptionSettings, stages: Stages) -> DetectionBackend | None:
    """Return the backend of the settings; None for the oracle, which looks at no image.

    Raises:
        Refused: its model cannot be used.
    """
    make = LOOKING.get(settings.backend)
    return None if make is None else make(settings, stages)
