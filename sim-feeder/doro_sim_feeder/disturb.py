"""Error models on recordings: the detections of a play, disturbed before they are sent."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

import msgspec

from doro_schemas import codec
from doro_schemas.detector_errors import ErrorModels, FalsePositivePool, disturb, pool_of
from doro_schemas.messages import SimDetections
from doro_sim_feeder.recording import Recording, Sample
from doro_sim_feeder.steps import Step


def disturbed(
    steps: Iterable[Step], models: ErrorModels, pool: FalsePositivePool | None = None
) -> Iterator[Step]:
    """Yield the steps with the errors of ``models`` in their detections; the rest is as it was.

    Raises:
        Refused: detections that do not fit, or false positives without another room.
    """
    for step in steps:
        samples = [_disturbed(sample, models, pool) for sample in step.samples]
        yield msgspec.structs.replace(step, samples=samples)


def pool_from_recordings(paths: Iterable[Path]) -> FalsePositivePool:
    """Return the false-positive pool of all detections in the given recordings.

    Raises:
        Refused: a recording that cannot be read.
    """
    return pool_of(frame for path in paths for frame in detections_of(Recording(path)))


def detections_of(recording: Recording) -> Iterator[SimDetections]:
    """Yield the simulator's detections of a recording, frame by frame."""
    for sample in recording.samples():
        if sample.topic.name == "sim_detections":
            message = sample.message()
            if isinstance(message, SimDetections):
                yield message


def _disturbed(sample: Sample, models: ErrorModels, pool: FalsePositivePool | None) -> Sample:
    if sample.topic.name != "sim_detections" or not models.errors:
        return sample
    message = sample.message()
    if not isinstance(message, SimDetections):
        return sample
    payload = bytes(codec.encode(disturb(message, models, pool)))
    return msgspec.structs.replace(sample, payload=payload)
