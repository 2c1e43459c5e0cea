"""The captioner as it is shipped, on the sample room, which it was never trained on."""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np
import pytest

from doro_console.options import sample_recording
from doro_perception.backend import intersection_over_union
from doro_perception.captioner import PACKAGED_FOLDER, Captioner
from doro_perception.core import Perception
from doro_perception.settings import PerceptionSettings
from doro_schemas.messages import ColorFrame, FrameCaptions, SimDetections
from doro_schemas.vocabulary import canonical_name, split_camel_case
from doro_sim_feeder.recording import Recording

FRAMES = 24
Pair = tuple[ColorFrame, SimDetections]


@pytest.fixture(scope="module")
def frames() -> list[Pair]:
    with sample_recording() as path:
        messages = [sample.message() for sample in Recording(path).samples()]
    colors = [one for one in messages if isinstance(one, ColorFrame)][:FRAMES]
    truth = {one.frame: one for one in messages if isinstance(one, SimDetections)}
    return [(color, truth[color.frame]) for color in colors]


def captions(frames: list[Pair], threads: int = 1) -> list[FrameCaptions]:
    settings = PerceptionSettings(backend="captioner", captioner_threshold=0.5, threads=threads)
    core = Perception(settings, Captioner(settings))
    found = [message for color, _ in frames for message in core.color_frame(color)]
    return [message for message in found if isinstance(message, FrameCaptions)]


def test_most_of_what_it_is_sure_of_is_right(frames: list[Pair]) -> None:
    right = wrong = 0
    for (_, truth), message in zip(frames, captions(frames), strict=True):
        boxes = np.array([item.box_px for item in truth.detections]).reshape(-1, 4)
        names = [canonical_name(split_camel_case(item.object_type)) for item in truth.detections]
        for box in message.detections:
            overlaps = intersection_over_union(np.array(box.box_px), boxes)
            near = [names[k] for k in np.flatnonzero(overlaps >= 0.5)]
            hit = bool(box.classes) and box.classes[0].name in near
            right, wrong = right + hit, wrong + (not hit)
    assert right >= 10
    assert right > wrong


def test_same_bytes_twice(frames: list[Pair]) -> None:
    some = frames[:4]
    first, second = (msgspec.msgpack.encode(captions(some)) for _ in range(2))
    assert first == second


@pytest.mark.parametrize("threads", [2, 3])
def test_same_bytes_on_several_threads(threads: int, frames: list[Pair]) -> None:
    some = frames[:6]
    assert any(len(message.detections) > 3 for message in captions(some))
    one, several = (msgspec.msgpack.encode(captions(some, count)) for count in (1, threads))
    assert one == several


def test_all_models_together_are_small() -> None:
    models = list(Path(PACKAGED_FOLDER).parent.glob("*/*.onnx"))
    assert len(models) == 3
    assert sum(path.stat().st_size for path in models) < 20e6
