"""The picture of the map: right pixels, right size, readable, the same bytes every time."""

from pathlib import Path

import cv2
import msgspec
import numpy as np
import pytest
import viewer_session as made

from doro_schemas import messages as m
from doro_viewer import map_panel as panel
from doro_viewer.colors import graph_color, named_color, stable_color
from doro_viewer.labels import Box, Label, place
from doro_viewer.lettering import Style, text_width_px, wrap
from doro_viewer.map_picture import draw_map
from doro_viewer.outputs import PngAlbum, png_bytes

RED, NAVY = graph_color(made.RED), graph_color(made.BLUE)


def picture(query: m.Query | None = None, width_px: int = 1200) -> np.ndarray:
    found = made.instances().instances
    return draw_map(made.snapshot(), found, query or made.query(), width_px=width_px)


def count(image: np.ndarray, color: tuple[int, int, int], tolerance: int = 40) -> int:
    return int((np.abs(image.astype(int) - color).max(axis=2) <= tolerance).sum())


def overlap(a: Box, b: Box) -> int:
    wide, high = min(a[2], b[2]) - max(a[0], b[0]), min(a[3], b[3]) - max(a[1], b[1])
    return max(0, wide) * max(0, high)


def test_two_pictures_of_one_map_are_the_same_file() -> None:
    assert png_bytes(picture()) == png_bytes(picture())


def test_the_picture_has_the_width_asked_for() -> None:
    assert picture().shape[1] == 1200
    assert 760 <= picture().shape[0] <= 900
    assert picture(width_px=1000).shape[1] == 1000
    with pytest.raises(ValueError, match="at least 900 px, got 400"):
        picture(width_px=400)


def test_cells_of_the_class_have_the_colour_of_their_graph_where_they_are() -> None:
    image, snapshot = picture(), made.snapshot()
    found = made.instances().instances
    # The panel of a 1200 px picture; the same arithmetic as draw_map's.
    box = (70, 48, 908, 688)
    frame = panel.frame_for(snapshot, found, "unity", box[2] - box[0], box)
    for (graph, x, z), color in zip(made.CUPS, (RED, RED, NAVY), strict=False):
        left, top, right, bottom = frame.rectangle(
            np.array([x - 0.06, z - 0.06]), np.array([x + 0.06, z + 0.06])
        )
        patch = image[top:bottom, left:right]
        assert count(patch, color) >= 0.15 * patch.shape[0] * patch.shape[1], graph
    x, y = frame.pixels(np.array([[-1.0, -0.8]]))[0].astype(int)
    assert tuple(image[y, x]) == panel.FLOOR
    x, y = frame.pixels(np.array([[-1.0, 2.8]]))[0].astype(int)
    assert tuple(image[y, x]) == panel.OTHER
    x, y = frame.pixels(np.array([[2.2, 3.2]]))[0].astype(int)
    assert tuple(image[y, x]) == (255, 255, 255)


def test_the_second_axis_points_up_and_the_bar_is_one_metre() -> None:
    box = (0, 0, 800, 600)
    frame = panel.frame_for(made.snapshot(), [], "unity", 800, box)
    low, high = frame.pixels(np.array([[0.0, 0.0], [1.0, 1.0]]))
    assert high[0] - low[0] == pytest.approx(frame.px_per_m)
    assert low[1] - high[1] == pytest.approx(frame.px_per_m)


def test_another_class_is_gray_when_it_is_not_asked_for() -> None:
    asked = msgspec.structs.replace(made.query(), input_graph=made.GRAPHS[4], clauses=[])
    image = draw_map(made.snapshot(), [], asked)
    assert count(image[:, :908], RED) == 0
    assert count(image[:, :908], stable_color("sofa[]")) > 2000


def test_an_empty_map_and_no_question_still_make_a_picture() -> None:
    nothing = m.GridSnapshot(
        frames_merged=0,
        last_frame=-1,
        cell_m=0.05,
        band_m=0.25,
        cells=np.zeros((0, 6), dtype=np.int32),
        weights=np.zeros(0, dtype=np.float32),
        floor=np.zeros((0, 2), dtype=np.int32),
        path_m=np.zeros((0, 2), dtype=np.float32),
    )
    assert draw_map(nothing, [], None).shape[1] == 1200
    assert draw_map(made.snapshot(), made.instances().instances, None).shape[1] == 1200


def test_the_strongest_graph_owns_a_shared_cell() -> None:
    shared = np.array([[1, 4, 4, 0, 1, 1], [2, 4, 4, 1, 1, 1]], dtype=np.int32)
    snapshot = msgspec.structs.replace(
        made.snapshot(), cells=shared, weights=np.array([0.5, 0.8], dtype=np.float32)
    )
    assert [region.name for region in panel.regions(snapshot, {"cup"})] == ["dark blue cup"]


def test_five_close_labels_keep_off_each_other_and_off_the_marks() -> None:
    anchors = [(400 + 20 * n, 300 + 7 * (n % 3), 410 + 20 * n, 310 + 7 * (n % 3)) for n in range(5)]
    obstacles = np.zeros((640, 840), dtype=np.uint8)
    for left, top, right, bottom in anchors:
        obstacles[top - 4 : bottom + 4, left - 4 : right + 4] = 250
    labels = [Label(width_px=190, height_px=38, anchor=anchor) for anchor in anchors]
    boxes = [box for box, _ in place(labels, obstacles, (0, 0, 840, 640))]
    for number, box in enumerate(boxes):
        assert all(overlap(box, other) == 0 for other in boxes[:number])
        assert all(overlap(box, anchor) == 0 for anchor in anchors)
        assert 0 <= box[0] < box[2] <= 840
        assert 0 <= box[1] < box[3] <= 640


def test_long_text_is_wrapped_inside_its_width() -> None:
    style = Style(scale=0.5)
    lines = wrap("please bring " * 60 + "x" * 300, 400, style)
    assert len(lines) > 10
    assert all(text_width_px(line, style) <= 400 for line in lines)
    assert wrap("one two three four five", 60, style, max_lines=1)[0].endswith("...")
    long = msgspec.structs.replace(made.query(), instruction="bring the cup " * 100)
    assert picture(long).shape[0] > picture().shape[0] + 50


def test_colours_are_named_ones_where_there_is_a_name() -> None:
    assert named_color("Grey") == named_color("gray")
    assert named_color("dark blue") != named_color("blue")
    assert named_color("striped") is None
    assert stable_color("cup") == (57, 153, 46)


def test_the_album_writes_a_whole_file(tmp_path: Path) -> None:
    path = tmp_path / "map.png"
    album = PngAlbum(str(path))
    for dialogue in ("1", "2", "../3"):
        album.keep(picture(), dialogue)
    image = cv2.imread(str(path))
    assert np.array_equal(cv2.cvtColor(image, cv2.COLOR_BGR2RGB), picture())
    assert sorted(file.name for file in tmp_path.iterdir()) == ["map-2.png", "map.png"]
