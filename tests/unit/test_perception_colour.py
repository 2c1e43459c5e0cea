"""Colour words on painted patches."""

import numpy as np
import pytest

from doro_perception.backend import RgbImage
from doro_perception.colour import COLOURS, central_crop, colour_name, colour_of_box


def patch(rgb: tuple[int, int, int], side_px: int = 40, noise: float = 6.0) -> RgbImage:
    rng = np.random.default_rng(0)
    painted = np.full((side_px, side_px, 3), rgb, dtype=np.float64)
    return np.clip(painted + rng.normal(0, noise, painted.shape), 0, 255).astype(np.uint8)


@pytest.mark.parametrize(
    ("rgb", "name"),
    [
        ((255, 0, 0), "red"),
        ((150, 20, 20), "red"),
        ((0, 0, 255), "blue"),
        ((40, 70, 140), "blue"),
        ((135, 180, 230), "blue"),
        ((0, 200, 0), "green"),
        ((40, 90, 45), "green"),
        ((255, 255, 0), "yellow"),
        ((200, 170, 40), "yellow"),
        ((250, 250, 250), "white"),
        ((215, 213, 208), "white"),
        ((8, 8, 8), "black"),
        ((35, 33, 32), "black"),
        ((255, 140, 0), "orange"),
        ((128, 0, 128), "purple"),
        ((110, 60, 30), "brown"),
        ((150, 105, 65), "brown"),
        ((255, 170, 190), "pink"),
        ((128, 128, 128), "gray"),
        ((95, 95, 97), "gray"),
    ],
)
def test_painted_patches_get_their_name(rgb: tuple[int, int, int], name: str) -> None:
    assert colour_name(patch(rgb)) == name


def test_the_table_covers_all_eleven_words() -> None:
    marks = test_painted_patches_get_their_name.pytestmark  # type: ignore[attr-defined]
    assert {name for _, name in marks[0].args[1]} == set(COLOURS)


def test_a_patch_of_many_colours_has_no_name() -> None:
    tones = [(255, 0, 0), (0, 0, 255), (0, 200, 0), (255, 255, 0)]
    stripes = np.concatenate([patch(rgb)[:10] for rgb in tones])
    assert colour_name(stripes) is None


def test_two_equal_halves_have_no_name() -> None:
    assert colour_name(np.concatenate([patch((255, 0, 0)), patch((0, 0, 255))])) is None


def test_a_coloured_rim_does_not_count() -> None:
    image = patch((255, 0, 0), 100)
    image[20:80, 20:80] = (20, 40, 200)
    assert colour_of_box(image, [10.0, 10.0, 90.0, 90.0]) == "blue"


def test_what_shows_through_does_not_count() -> None:
    """A black frame with thin bars on a brown floor is black, though most pixels are brown."""
    image = patch((110, 60, 30), 120, noise=2.0)
    image[20:100, 20:100:4] = (10, 10, 10)
    box = [20.0, 20.0, 100.0, 100.0]
    assert colour_name(central_crop(image, box)) == "brown"
    assert colour_of_box(image, box) == "black"


def test_a_thing_of_its_backgrounds_colour_keeps_its_name() -> None:
    assert colour_of_box(patch((250, 250, 250), 80), [20.0, 20.0, 60.0, 60.0]) == "white"


@pytest.mark.parametrize(
    "box_px", [[0.0, 0.0, 1.0, 1.0], [39.2, 39.2, 40.0, 40.0], [0.0, 0.0, 40.0, 40.0]]
)
def test_tiny_and_full_boxes_work(box_px: list[float]) -> None:
    assert colour_of_box(patch((255, 0, 0), noise=0.0), box_px) == "red"
