"""What a thing is made of is seen in the picture, and its colour is still the one it has."""

from __future__ import annotations

import importlib.util
from itertools import combinations

import numpy as np
import pytest
from numpy.typing import NDArray

from doro_schemas.camera import pose_from_ai2thor
from doro_sim_feeder.rooms.appearance import PALETTE
from doro_sim_feeder.rooms.camera import Camera
from doro_sim_feeder.rooms.lighting import Lighting
from doro_sim_feeder.rooms.parts import blob_part, box_part, place
from doro_sim_feeder.rooms.raycast import RayCaster, make_soup
from doro_sim_feeder.rooms.shading import Shader
from doro_sim_feeder.rooms.surfaces import PATTERNS, SURFACES, pattern_tone, room_light

MATERIALS = tuple(sorted(SURFACES))
needs_embree = pytest.mark.skipif(
    importlib.util.find_spec("embreex") is None, reason="the extra 'render' is not installed"
)


def look(color: str, material: str | None) -> NDArray[np.float64]:
    """Return the pixels, float (n, 3), of a blob of a colour and a material on a table."""
    blob = place((blob_part((0.3, 0.3, 0.3), PALETTE[color]),), 0, (0, 0.8, 1.0))
    table = box_part((-1, 0.7, 0.3), (1, 0.8, 2), (0.8, 0.8, 0.8))
    soup = make_soup([(1, blob), (2, (table,))])
    caster = RayCaster(soup)
    materials = [material] * len(blob) + [None]
    shader = Shader(caster, materials, Lighting(lamp_m=(0.3, 2.3, 0.2)))
    pose = pose_from_ai2thor((0, 1.15, 0.5), 0, 20)
    picture = Camera(96).take(caster, pose, shader)
    assert picture.color is not None
    pixels: NDArray[np.float64] = picture.color[picture.ids == 1].astype(np.float64)
    assert len(pixels) > 400
    return pixels


@needs_embree
def test_every_two_materials_look_different() -> None:
    seen = {name: look("gray", name) for name in (*MATERIALS, None)}
    for one, other in combinations(seen, 2):
        assert np.abs(seen[one] - seen[other]).mean() > 1.5, (one, other)


@needs_embree
@pytest.mark.parametrize("color", ["red", "blue", "green", "yellow", "purple", "orange"])
@pytest.mark.parametrize("material", MATERIALS)
def test_a_colour_keeps_its_hue(color: str, material: str) -> None:
    mean = look(color, material).mean(axis=0)
    wanted = np.asarray(PALETTE[color])
    apart, hue = mean - mean.mean(), wanted - wanted.mean()
    likeness = float(apart @ hue / (np.linalg.norm(apart) * np.linalg.norm(hue)))
    assert likeness > 0.9
    assert mean.max() - mean.min() > 25


def test_the_mirrored_room_has_a_dark_floor_a_light_ceiling_and_windows() -> None:
    directions = np.array([[0, -1, 0], [0, 1, 0], [0.8, 0, 0.6], [-0.8, 0, -0.6], [0.6, 0, -0.8]])
    floor, ceiling, window, other, wall = room_light(directions)
    assert floor < wall < ceiling < window
    assert window == pytest.approx(other)


@pytest.mark.parametrize("pattern", PATTERNS)
def test_patterns_change_the_brightness_but_not_its_mean(pattern: float) -> None:
    points = np.random.default_rng(0).uniform(-1, 1, (4000, 3))
    tone = pattern_tone(pattern, points)
    assert abs(tone.mean() - 1) < 0.1
    assert tone.std() > 0.02
    assert tone.min() > 0.4
