"""Relations between the things of one image, from boxes and from depth."""

from __future__ import annotations

import numpy as np
import pytest

from doro_perception.backend import Detection, RgbImage
from doro_perception.core import Perception
from doro_perception.image_relations import from_boxes
from doro_perception.settings import PerceptionSettings
from doro_schemas.camera import intrinsics_from_vertical_fov, pose_from_ai2thor
from doro_schemas.messages import ColorFrame, DepthFrame, FrameCaptions

TABLE = [50.0, 120.0, 250.0, 240.0]


@pytest.mark.parametrize(
    ("names", "boxes", "wanted"),
    [
        (["cup", "dining table"], [[100, 90, 120, 140], TABLE], [[("is-on", 1)], []]),
        # Its foot is above the table's top: it hangs behind it.
        (["mirror", "dining table"], [[100, 20, 160, 60], TABLE], [[], []]),
        (["plate", "sink"], [[100, 130, 130, 150], TABLE], [[("is-at", 1)], []]),
        (["cup", "toaster"], [[100, 90, 120, 140], TABLE], [[], []]),
        (["chair", "dining table"], [[255, 150, 300, 245], TABLE], [[("is-near", 1)], []]),
        (["chair", "dining table"], [[290, 20, 299, 40], TABLE], [[], []]),
        (["book", "book"], [[100, 90, 120, 140], TABLE], [[], []]),
        # The smallest thing that carries it.
        (
            ["cup", "dining table", "box"],
            [[100, 90, 110, 140], TABLE, [90, 120, 130, 160]],
            [[("is-on", 2)], [], [("is-on", 1)]],
        ),
        ([], [], []),
    ],
)
def test_from_boxes(names: list[str], boxes: list[list[float]], wanted: list[object]) -> None:
    assert from_boxes(names, boxes) == wanted


class FakeBackend:
    def __init__(self, *detections: Detection) -> None:
        self.detections = list(detections)

    def detect(self, rgb: RgbImage) -> list[Detection]:
        return self.detections

    def warm_up(self) -> None:
        pass


def seen(name: str, *box: float) -> Detection:
    return Detection(box_px=(box[0], box[1], box[2], box[3]), score=0.9, name=name)


def color(frame: int, episode: str = "e") -> ColorFrame:
    data = np.full((200, 200, 3), 99, np.uint8)
    return ColorFrame(frame=frame, episode=episode, height_px=200, width_px=200, data=data)


def depth(frame: int) -> DepthFrame:
    """A camera that looks straight down from 3 m on a table of 1 m with a cup on it."""
    metres = np.full((200, 200), 3.0, np.float32)
    metres[50:150, 50:150] = 2.0
    metres[60:80, 60:80] = 1.9
    # A second cup stands on the floor, right beside.
    metres[100:120, 160:180] = 2.9
    return DepthFrame(
        frame=frame,
        episode="e",
        height_px=200,
        width_px=200,
        intrinsics=intrinsics_from_vertical_fov(200, 200, 90.0),
        pose=pose_from_ai2thor((0.0, 3.0, 0.0), 0.0, 90.0),
        data=metres,
    )


def core(relations: str) -> Perception:
    settings = PerceptionSettings(backend="captioner", relations=relations, colour=False)
    things = (
        seen("cup", 60, 60, 80, 80),
        seen("coffee table", 50, 50, 150, 150),
        seen("cup", 160, 100, 180, 120),
    )
    return Perception(settings, FakeBackend(*things))


def texts(outputs: list[object]) -> list[str]:
    (message,) = outputs
    assert isinstance(message, FrameCaptions)
    return [box.caption for box in message.detections]


def test_depth_decides_where_a_frame_has_it() -> None:
    # Side by side in the image, the second cup is 0.8 m away in the room.
    wanted = ["a cup on the coffee table", "a coffee table", "a cup"]
    assert texts(core("boxes").color_frame(color(0)))[2] == "a cup near the coffee table"
    perception = core("depth")
    assert perception.color_frame(color(0)) == []
    assert texts(perception.depth_frame(depth(0))) == wanted
    # In the other order as well.
    assert perception.depth_frame(depth(1)) == []
    assert texts(perception.color_frame(color(1))) == wanted


def test_an_image_whose_depth_never_comes_is_described_all_the_same() -> None:
    perception = core("depth")
    outputs = [perception.color_frame(color(frame)) for frame in range(5)]
    assert [len(output) for output in outputs] == [0, 0, 0, 0, 1]
    assert texts(outputs[-1])[0] == "a cup on the coffee table"  # from the boxes
    # Depth that no image asks for does not pile up.
    other = core("depth")
    for frame in range(20):
        assert other.depth_frame(depth(frame)) == []
    assert other.color_frame(color(0)) == []


def test_off_says_no_relation() -> None:
    assert texts(core("off").color_frame(color(0))) == ["a cup", "a coffee table", "a cup"]
    assert texts(core("boxes").color_frame(color(0)))[0] == "a cup on the coffee table"
