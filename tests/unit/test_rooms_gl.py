"""The two renderers give the same pictures: depth, ids, and nearly the same colour."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Iterator

import numpy as np
import pytest

from doro_schemas.camera import pose_from_ai2thor
from doro_schemas.errors import Refused
from doro_sim_feeder.rooms.camera import Camera, Picture
from doro_sim_feeder.rooms.exploration import plan_views
from doro_sim_feeder.rooms.gl import GlRenderer
from doro_sim_feeder.rooms.lighting import Lighting, ceiling_lighting
from doro_sim_feeder.rooms.parts import blob_part, box_part, place
from doro_sim_feeder.rooms.placement import CopySpec, spawn_copies
from doro_sim_feeder.rooms.raycast import RayCaster, make_soup
from doro_sim_feeder.rooms.renderers import EmbreeRenderer, Renderer, make_renderer
from doro_sim_feeder.rooms.scene import Scene, build_scene
from doro_sim_feeder.rooms.variation import random_lighting, random_view

ROOMS = ("FloorPlan5", "FloorPlan19", "FloorPlan210", "FloorPlan301")
VIEWS = 6


def why_not() -> str:
    """Return what is missing for OpenGL here, or nothing."""
    needed = ("moderngl", "embreex", "procthor", "PIL")
    missing = [name for name in needed if importlib.util.find_spec(name) is None]
    if missing:
        return f"the extras 'render' and 'render-gl' are not installed: no {', '.join(missing)}"
    soup = make_soup([(1, (box_part((0, 0, 1), (1, 1, 2), (1, 1, 1)),))])
    try:
        GlRenderer(soup, [None], Lighting(lamp_m=(0, 2, 0)), Camera(8)).close()
    except Refused as refused:
        return refused.reason
    return ""


REASON = why_not()
needs_embree = pytest.mark.skipif(
    any(importlib.util.find_spec(name) is None for name in ("embreex", "procthor", "PIL")),
    reason="the extra 'render' is not installed",
)
needs_gl = pytest.mark.skipif(bool(REASON), reason=REASON)


@pytest.fixture(scope="module", params=ROOMS)
def pairs(request: pytest.FixtureRequest) -> Iterator[list[tuple[Picture, Picture]]]:
    """Views of a room with copies, by Embree and by OpenGL."""
    scene = spawn_copies(build_scene(request.param), CopySpec("Cup", 3, ("red", "red", "blue")), 1)
    embree, opengl = make_renderer("embree", scene), make_renderer("gl", scene)
    views = [view.pose() for view in plan_views(scene.cells, VIEWS, 2)]
    yield [(embree.take(pose), opengl.take(pose)) for pose in views]
    opengl.close()


def away_from_silhouettes(ids: np.ndarray) -> np.ndarray:
    """True where the 3 x 3 pixels around belong to one instance."""
    inside = np.zeros(ids.shape, bool)
    around = [
        ids[1 + dv : ids.shape[0] - 1 + dv, 1 + du : ids.shape[1] - 1 + du]
        for dv in (-1, 0, 1)
        for du in (-1, 0, 1)
    ]
    inside[1:-1, 1:-1] = np.all([other == around[4] for other in around], axis=0)
    return inside


@needs_gl
def test_depth_agrees_within_a_millimetre(pairs: list[tuple[Picture, Picture]]):
    for embree, opengl in pairs:
        inside = away_from_silhouettes(embree.ids)
        assert inside.mean() > 0.5
        off_m = np.abs(embree.depth_m - opengl.depth_m)[inside]
        assert np.percentile(off_m, 99) < 0.001
        assert opengl.depth_m.dtype == np.float32


@needs_gl
def test_ids_agree(pairs: list[tuple[Picture, Picture]]):
    shares = [float((embree.ids == opengl.ids).mean()) for embree, opengl in pairs]
    assert min(shares) >= 0.995, shares
    assert pairs[0][1].ids.dtype == np.int32


@needs_gl
def test_colours_nearly_agree(pairs: list[tuple[Picture, Picture]]):
    for embree, opengl in pairs:
        assert embree.color is not None
        assert opengl.color is not None
        off = np.abs(embree.color.astype(int) - opengl.color)
        assert off.mean() < 3
        assert opengl.color.std() > 10


@pytest.fixture(scope="module")
def scene() -> Scene:
    return build_scene("FloorPlan19")


@needs_gl
def test_pictures_are_deterministic_and_do_not_depend_on_the_views_before(scene: Scene):
    poses = [view.pose() for view in plan_views(scene.cells, 3, 5)]

    def bytes_of(renderer: Renderer, index: int) -> bytes:
        picture = renderer.take(poses[index])
        assert picture.color is not None
        return picture.color.tobytes() + picture.ids.tobytes() + picture.depth_m.tobytes()

    first, second = make_renderer("gl", scene, 128), make_renderer("gl", scene, 128)
    forwards = [bytes_of(first, k) for k in (0, 1, 2)]
    backwards = [bytes_of(second, k) for k in (2, 1, 0)]
    assert forwards == backwards[::-1]
    assert len(set(forwards)) == 3
    first.close()
    second.close()


@needs_gl
def test_smooth_colour_leaves_depth_and_ids_alone(scene: Scene):
    soup = make_soup([(k, item.parts) for k, item in enumerate(scene.instances, start=1)])
    pose = plan_views(scene.cells, 1, 5)[0].pose()
    light = ceiling_lighting(scene.room)
    pictures = []
    for smooth in (True, False):
        with GlRenderer(soup, scene.part_materials(), light, Camera(200), smooth=smooth) as one:
            pictures.append(one.take(pose))
    soft, hard = pictures
    assert (soft.ids == hard.ids).all()
    assert (soft.depth_m == hard.depth_m).all()
    assert (soft.color != hard.color).any()


@needs_gl
@pytest.mark.parametrize("seed", [1, 2])
def test_other_light_is_the_same_in_both_renderers_and_no_other_geometry(scene: Scene, seed: int):
    view = random_view(plan_views(scene.cells, 2, 5)[1], seed)
    light = random_lighting(scene.room, seed)
    usual = make_renderer("gl", scene)
    before = usual.take(view.pose())
    assert isinstance(usual, GlRenderer)
    usual.light(light)
    after = usual.take(view.pose())
    other = make_renderer("embree", scene, lighting=light).take(view.pose())
    assert after.color is not None
    assert before.color is not None
    assert other.color is not None
    assert np.abs(after.color.astype(int) - before.color).mean() > 4
    assert np.abs(after.color.astype(int) - other.color).mean() < 4
    assert (after.ids == before.ids).all()
    assert (after.depth_m == before.depth_m).all()
    usual.close()


@needs_gl
def test_image_axes_and_holes():
    """Yaw 90 faces +x: what lies at -z is on the right, what is high at the top."""
    right = place((blob_part((0.4, 0.4, 0.4), (1, 0, 0)),), 0, (2.0, 1.4, -1.0))
    above = (box_part((2, 2.4, -0.2), (2.2, 2.7, 0.2), (1, 0, 0)),)
    soup = make_soup([(7, right), (9, above)])
    pose = pose_from_ai2thor((0.0, 1.576, 0.0), 90, 0)
    with GlRenderer(soup, [None, None], Lighting(lamp_m=(0, 2, 0)), Camera(100)) as renderer:
        picture = renderer.take(pose)
    rows, columns = np.nonzero(picture.ids == 7)
    assert columns.min() > 60
    assert abs(rows.mean() - 50) < 5
    rows, columns = np.nonzero(picture.ids == 9)
    assert rows.max() < 40
    assert abs(columns.mean() - 50) < 3
    assert set(np.unique(picture.ids)) == {0, 7, 9}
    assert (picture.depth_m[picture.ids == 0] == 0).all()
    exact = Camera(100).take(RayCaster(soup), pose)
    assert (exact.ids == picture.ids).mean() > 0.999


@needs_gl
def test_variations_are_seeded(scene: Scene):
    view = plan_views(scene.cells, 1, 5)[0]
    assert random_lighting(scene.room, 4) == random_lighting(scene.room, 4)
    assert random_lighting(scene.room, 4) != random_lighting(scene.room, 5)
    assert random_view(view, 4) == random_view(view, 4)
    horizons = [random_view(view, seed).horizon_deg for seed in range(200)]
    assert min(horizons) < -15
    assert max(horizons) > 45


def test_without_moderngl_the_refusal_says_what_to_do(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setitem(sys.modules, "moderngl", None)
    soup = make_soup([(1, (box_part((0, 0, 1), (1, 1, 2), (1, 1, 1)),))])
    with pytest.raises(Refused, match="render-gl"):
        GlRenderer(soup, [None], Lighting(lamp_m=(0, 2, 0)), Camera(8))


@needs_embree
def test_geometry_alone_is_always_cast(scene: Scene):
    assert isinstance(make_renderer("gl", scene, color=False), EmbreeRenderer)
