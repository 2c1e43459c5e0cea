"""One interface, two renderers: Embree's rays and OpenGL's triangles give the same pictures."""

from __future__ import annotations

from typing import Literal, Protocol

from doro_schemas.camera import Pose
from doro_sim_feeder.rooms.camera import Camera, Picture
from doro_sim_feeder.rooms.gl import GlRenderer
from doro_sim_feeder.rooms.lighting import Lighting, ceiling_lighting
from doro_sim_feeder.rooms.raycast import make_soup
from doro_sim_feeder.rooms.scene import Scene
from doro_sim_feeder.rooms.shading import Shader

RendererName = Literal["embree", "gl"]


class Renderer(Protocol):
    """Takes pictures of one scene."""

    camera: Camera

    def take(self, pose: Pose) -> Picture:
        """Render a view."""
        ...

    def close(self) -> None:
        """Give back what it holds."""
        ...


class EmbreeRenderer:
    """The ray caster: needs pip packages only; fast for depth and ids, slow for colour.

    Args:
        color: False leaves colour out.
    """

    def __init__(
        self, scene: Scene, camera: Camera, lighting: Lighting, *, color: bool = True
    ) -> None:
        self.camera = camera
        self._caster = scene.caster()
        materials = scene.part_materials()
        self._shader = Shader(self._caster, materials, lighting) if color else None

    def take(self, pose: Pose) -> Picture:
        """Render a view."""
        return self.camera.take(self._caster, pose, self._shader)

    def close(self) -> None:
        """Nothing is held that outlives the object."""


def make_renderer(
    name: RendererName,
    scene: Scene,
    size_px: int = 300,
    *,
    color: bool = True,
    lighting: Lighting | None = None,
) -> Renderer:
    """Return a renderer of a scene.

    Args:
        name: ``embree``, or ``gl`` (extra ``render-gl``, and EGL on the machine).
        lighting: the light; None: one lamp under the middle of the ceiling.

    Raises:
        Refused: what the renderer needs is not installed.
    """
    light = lighting or ceiling_lighting(scene.room)
    camera = Camera(size_px)
    if name == "embree" or not color:
        return EmbreeRenderer(scene, camera, light, color=color)
    pairs = [(number, item.parts) for number, item in enumerate(scene.instances, start=1)]
    return GlRenderer(make_soup(pairs), scene.part_materials(), light, camera)
