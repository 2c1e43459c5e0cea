"""Images at the edge: decoded exactly, or refused in one sentence."""

import cv2
import numpy as np
import pytest

from doro_perception.backend import Detection, RgbImage
from doro_perception.core import Perception
from doro_perception.draw import draw_captions
from doro_perception.image import decode, jpeg_size
from doro_perception.settings import PerceptionSettings
from doro_schemas.errors import Refused
from doro_schemas.graph import ObjectGraph
from doro_schemas.messages import CaptionedBox, ColorFrame, FrameCaptions


def picture(height_px: int = 48, width_px: int = 64) -> RgbImage:
    rng = np.random.default_rng(3)
    coarse = rng.integers(0, 256, (6, 8, 3)).astype(np.uint8)
    return np.asarray(
        cv2.resize(coarse, (width_px, height_px), interpolation=cv2.INTER_CUBIC), dtype=np.uint8
    )


def file_bytes(rgb: RgbImage, ending: str) -> np.ndarray:
    done, data = cv2.imencode(ending, np.ascontiguousarray(rgb[:, :, ::-1]))
    assert done
    return np.asarray(data, dtype=np.uint8).ravel()


def frame(data: np.ndarray, encoding: str, height_px: int = 48, width_px: int = 64) -> ColorFrame:
    return ColorFrame(
        stamp_ns=9,
        episode="e2",
        camera="cam1",
        frame=4,
        height_px=height_px,
        width_px=width_px,
        encoding=encoding,
        data=data,
    )


class FakeBackend:
    """Returns what it was given and remembers what it saw."""

    def __init__(self, *detections: Detection) -> None:
        self.detections = list(detections)
        self.seen: list[RgbImage] = []

    def detect(self, rgb: RgbImage) -> list[Detection]:
        self.seen.append(rgb)
        return self.detections


def test_png_and_rgb8_give_the_very_pixels() -> None:
    rgb = picture()
    assert np.array_equal(decode(frame(file_bytes(rgb, ".png"), "png")), rgb)
    assert np.array_equal(decode(frame(rgb, "rgb8")), rgb)


def test_jpeg_gives_nearly_the_pixels() -> None:
    rgb = picture()
    decoded = decode(frame(file_bytes(rgb, ".jpg"), "jpeg"))
    assert np.abs(decoded.astype(int) - rgb).mean() < 6


@pytest.mark.parametrize(("encoding", "ending"), [("png", ".png"), ("jpeg", ".jpg")])
def test_another_size_than_declared_is_refused(encoding: str, ending: str) -> None:
    wrong = frame(file_bytes(picture(), ending), encoding, height_px=64, width_px=48)
    with pytest.raises(Refused, match="is 64x48 px but is declared as 48x64:") as caught:
        decode(wrong)
    assert (caught.value.episode, caught.value.frame) == ("e2", 4)


@pytest.mark.parametrize(("encoding", "ending"), [("png", ".png"), ("jpeg", ".jpg")])
def test_a_truncated_file_is_refused(encoding: str, ending: str) -> None:
    data = file_bytes(picture(), ending)
    with pytest.raises(Refused, match="camera 'cam1', frame 4, is cut short"):
        decode(frame(data[: len(data) // 2], encoding))


def test_the_wrong_kind_of_file_is_refused() -> None:
    with pytest.raises(Refused, match="is no jpeg file"):
        decode(frame(file_bytes(picture(), ".png"), "jpeg"))


def test_damaged_content_is_refused() -> None:
    data = file_bytes(picture(), ".png").copy()
    data[40:-40] = 0
    with pytest.raises(Refused, match="cannot be decoded"):
        decode(frame(data, "png"))


def test_a_header_without_size_is_refused() -> None:
    data = np.frombuffer(b"\xff\xd8\xff\xe0\x00\x04ab\xff\xd9", dtype=np.uint8)
    assert jpeg_size(data.tobytes()) is None
    with pytest.raises(Refused, match="no readable header"):
        decode(frame(data, "jpeg"))


def test_boxes_are_clipped_and_what_is_left_of_nothing_goes() -> None:
    backend = FakeBackend(
        Detection(
            box_px=(-8.0, -3.0, 30.0, 60.0), score=0.9, name="chair", classes=(("chair", 0.8),)
        ),
        Detection(box_px=(63.0, 0.0, 90.0, 40.0), score=0.8, name="bed"),
        Detection(box_px=(float("nan"), 0.0, 30.0, 40.0), score=0.8, name="bed"),
    )
    core = Perception(PerceptionSettings(backend="coco", colour=False), backend)
    (output,) = core.color_frame(frame(picture(), "rgb8"))
    assert isinstance(output, FrameCaptions)
    (box,) = output.detections
    assert (box.box_px, box.caption, box.score) == ([0.0, 0.0, 30.0, 48.0], "a chair", 0.9)
    assert [(entry.name, entry.probability) for entry in box.classes] == [("chair", 0.8)]
    assert (output.stamp_ns, output.episode, output.camera, output.frame) == (9, "e2", "cam1", 4)
    assert core.counters == {"frames": 1, "detections": 1, "left_out": 2}


def test_a_coloured_box_is_named_by_its_colour_in_both_forms() -> None:
    rgb = np.full((48, 64, 3), 240, dtype=np.uint8)
    rgb[10:40, 10:50] = (110, 60, 30)
    backend = FakeBackend(Detection(box_px=(10.0, 10.0, 50.0, 40.0), score=0.5, name="chair"))
    (text,) = Perception(PerceptionSettings(), backend).color_frame(frame(rgb, "rgb8"))
    (graph,) = Perception(PerceptionSettings(emit="graphs"), backend).color_frame(
        frame(rgb, "rgb8")
    )
    assert isinstance(text, FrameCaptions)
    assert isinstance(graph, FrameCaptions)
    assert text.detections[0].caption == "a brown chair"
    assert graph.detections[0].graph == ObjectGraph(name="chair", attributes={"color": "brown"})


def test_an_image_without_detections_still_sends() -> None:
    (output,) = Perception(PerceptionSettings(), FakeBackend()).color_frame(
        frame(picture(), "rgb8")
    )
    assert isinstance(output, FrameCaptions)
    assert output.detections == []


def test_the_oracle_refuses_images() -> None:
    with pytest.raises(Refused, match=r"perception.backend is 'oracle'"):
        Perception(PerceptionSettings()).color_frame(frame(picture(), "rgb8"))


def test_drawing_changes_a_copy_at_the_box() -> None:
    rgb = picture(100, 200)
    captions = FrameCaptions(
        frame=0,
        height_px=100,
        width_px=200,
        detections=[CaptionedBox(box_px=[40.0, 40.0, 120.0, 90.0], score=0.5, caption="a bed")],
    )
    before = rgb.copy()
    drawn = draw_captions(rgb, captions)
    assert np.array_equal(rgb, before)
    assert drawn[60, 40].tolist() == [230, 25, 75]
    assert np.array_equal(drawn[95:], before[95:])
    with pytest.raises(ValueError, match="do not belong"):
        draw_captions(rgb[:50], captions)
