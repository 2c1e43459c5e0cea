"""The OpenGL renderer: colour, instance ids and depth in one pass, off screen by EGL.

It draws the same triangles with the same light as the ray caster and is meant for pictures.
Ids and depth are rasterised at the pixels' centres; smooth colour comes from a pass of its own
at twice the size, which never touches them. Needs the extra ``render-gl`` and, on Debian,
``apt-get install libegl1 libgl1-mesa-dri``. Equal scenes, light and poses give equal bytes on
one machine.
"""

from __future__ import annotations

from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from doro_schemas.camera import Pose
from doro_schemas.errors import Refused
from doro_sim_feeder.rooms import gl_programs as programs
from doro_sim_feeder.rooms.camera import Camera, Picture
from doro_sim_feeder.rooms.lighting import Lighting
from doro_sim_feeder.rooms.raycast import Soup
from doro_sim_feeder.rooms.shading import make_atlas
from doro_sim_feeder.rooms.surfaces import surface_rows

NEAR_M, FAR_M = 0.02, 40.0
SHADOW_NEAR_M, SHADOW_PX = 0.05, 1024
SMOOTH = 2
AXES = np.eye(3)
# Forward and up of the six views of the lamp: +x, -x, +y, -y, +z, -z.
LAMP_VIEWS = tuple((side * AXES[k], AXES[(k + 1) % 3]) for k in range(3) for side in (1.0, -1.0))


class GlRenderer:
    """One scene in OpenGL; a context manager.

    Args:
        soup: the triangles, with instance ids.
        part_materials: material of each part of the soup, in its order.
        lighting: the light; :meth:`light` changes it.
        camera: size and intrinsics of the pictures.
        smooth: colour is drawn at twice the size and averaged.

    Raises:
        Refused: moderngl or EGL is missing.
    """

    def __init__(
        self,
        soup: Soup,
        part_materials: list[str | None],
        lighting: Lighting,
        camera: Camera,
        *,
        smooth: bool = True,
    ) -> None:
        self.camera = camera
        self._context = _open_context()
        self._ranges = _instance_ranges(soup)
        self._scene = self._context.program(programs.SCENE_VERTEX, programs.SCENE_FRAGMENT)
        self._geometry = self._context.program(programs.SCENE_VERTEX, programs.GEOMETRY_FRAGMENT)
        self._depth = self._context.program(programs.DEPTH_VERTEX, programs.DEPTH_FRAGMENT)
        self._load(soup, part_materials)
        self._targets = self._make_targets(camera.size_px)
        self._smooth = self._make_targets(camera.size_px * SMOOTH) if smooth else None
        self.light(lighting)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Give back the context and all that is in it."""
        self._context.release()

    def light(self, lighting: Lighting) -> None:
        """Set the light and draw its shadows, which hold for all views."""
        lamp = np.asarray(lighting.lamp_m)
        clip = _projection(1.0, SHADOW_NEAR_M)
        views = [clip @ _view(np.cross(up, ahead), up, ahead, lamp) for ahead, up in LAMP_VIEWS]
        self._draw_shadows(views)
        self._scene["shadow_views"].write(np.stack([_gl(view) for view in views]).tobytes())
        values: dict[str, Any] = {
            "lamp": lighting.lamp_m,
            "lamp_color": lighting.lamp_color,
            "ambient_color": lighting.ambient_color,
            "lamp_light": lighting.lamp,
            "ambient": lighting.ambient,
            "sky": lighting.sky,
            "side": lighting.side,
            "head_light": lighting.head,
            "bounce": lighting.bounce,
            "shadow_light": lighting.shadow,
            "exposure": lighting.exposure,
            "gamma": lighting.gamma,
            "shadow_texel": 1.0 / SHADOW_PX,
            "shadow_map": 0,
        }
        for name, value in values.items():
            self._scene[name].value = value

    def take(self, pose: Pose) -> Picture:
        """Render a view."""
        right, down, ahead = pose.matrix().T
        eye = np.asarray(pose.position_m)
        tangent = self.camera.size_px / 2 / self.camera.intrinsics.fx
        clip = _projection(tangent, NEAR_M) @ _view(right, -down, ahead, eye)
        for program in (self._scene, self._geometry, self._depth):
            program["view_to_clip"].write(_gl(clip).tobytes())
        for program in (self._scene, self._geometry):
            program["eye"].value = tuple(eye)
            program["forward"].value = tuple(ahead)
        visible = self._visible(clip)
        color, ids, depth = self._pictures(visible)
        size = self.camera.size_px
        return Picture(
            depth_m=_upright(depth, np.float32, size, 1)[..., 0],
            ids=_upright(ids, np.int32, size, 1)[..., 0],
            color=color,
        )

    def _pictures(self, visible: list[tuple[int, int]]) -> tuple[NDArray[np.uint8], bytes, bytes]:
        """Draw and return colour, and ids and depth as OpenGL has them.

        Where surfaces coincide, the one drawn first stays ("<"), as with the ray caster.
        """
        size = self.camera.size_px
        if self._smooth is None:
            self._draw(self._targets, visible, (self._vao,), "<")
            color, ids, depth = (image.read() for image in self._targets[1])
            return np.ascontiguousarray(_upright(color, np.uint8, size, 4)[..., :3]), ids, depth
        self._draw(self._targets, visible, (self._geometry_vao,), "<")
        _, ids, depth = (image.read() for image in self._targets[1])
        # Depth first, so that only what is seen in the end is shaded.
        self._draw(self._smooth, visible, (self._depth_vao, self._vao), "<=")
        pixels = _upright(self._smooth[1][0].read(), np.uint8, size * SMOOTH, 4)[..., :3]
        blocks = pixels.reshape(size, SMOOTH, size, SMOOTH, 3)
        smooth = np.rint(blocks.mean(axis=(1, 3), dtype=np.float32)).astype(np.uint8)
        return smooth, ids, depth

    def _load(self, soup: Soup, part_materials: list[str | None]) -> None:
        """Put triangles, parts and textures into buffers: one draw call needs no state."""
        context = self._context
        part = np.zeros((len(soup.vertices), 1), np.int32)
        part[soup.faces.ravel(), 0] = np.repeat(soup.face_part, 3)
        table = np.concatenate(
            [soup.vertices, soup.normals, soup.uv, part.view(np.float32)], axis=1
        ).astype(np.float32)
        vertices = context.buffer(table.tobytes())
        faces = context.buffer(np.ascontiguousarray(soup.faces, np.int32).tobytes())
        names = ("in_position", "in_normal", "in_uv", "in_part")
        self._vao = context.vertex_array(self._scene, [(vertices, "3f 3f 2f 1i", *names)], faces)
        self._geometry_vao = context.vertex_array(
            self._geometry, [(vertices, "3f 20x 1i", "in_position", "in_part")], faces
        )
        self._depth_vao = context.vertex_array(
            self._depth, [(vertices, "3f 24x", "in_position")], faces
        )
        parts, texels = _part_buffers(soup, part_materials)
        context.buffer(parts).bind_to_storage_buffer(programs.PARTS_BINDING)
        context.buffer(texels).bind_to_storage_buffer(programs.TEXELS_BINDING)

    def _make_targets(self, side_px: int) -> tuple[Any, list[Any]]:
        """Return a framebuffer and its colour, id and depth images."""
        context, size = self._context, (side_px, side_px)
        images = [
            context.texture(size, 4),
            context.texture(size, 1, dtype="i4"),
            context.texture(size, 1, dtype="f4"),
        ]
        return context.framebuffer(images, context.depth_texture(size)), images

    def _draw_shadows(self, views: list[NDArray[np.float64]]) -> None:
        context = self._context
        size = (SHADOW_PX * programs.SHADOW_COLUMNS, SHADOW_PX * programs.SHADOW_ROWS)
        depth = context.depth_texture(size)
        depth.compare_func = "<="
        depth.filter = (context.LINEAR, context.LINEAR)
        target = context.framebuffer(depth_attachment=depth)
        target.use()
        target.clear()
        context.enable_only(context.DEPTH_TEST)
        for number, view in enumerate(views):
            row, column = divmod(number, programs.SHADOW_COLUMNS)
            target.viewport = (column * SHADOW_PX, row * SHADOW_PX, SHADOW_PX, SHADOW_PX)
            target.use()
            self._depth["view_to_clip"].write(_gl(view).tobytes())
            self._depth_vao.render()
        target.release()
        depth.use(0)
        self._shadow_map = depth

    def _draw(
        self,
        targets: tuple[Any, list[Any]],
        visible: list[tuple[int, int]],
        vaos: tuple[Any, ...],
        depth_func: str,
    ) -> None:
        framebuffer, images = targets
        framebuffer.use()
        framebuffer.clear()
        # clear() writes floats, which an integer image does not take.
        images[1].write(bytes(images[1].width * images[1].height * 4))
        self._context.enable_only(self._context.DEPTH_TEST)
        self._context.depth_func = depth_func
        for vao in vaos:
            for first, count in visible:
                vao.render(vertices=count, first=first)

    def _visible(self, clip: NDArray[np.float64]) -> list[tuple[int, int]]:
        """Return (first index, count) of runs of instances whose boxes reach into the view."""
        firsts, counts, corners = self._ranges
        at = np.concatenate([corners, np.ones((*corners.shape[:2], 1))], axis=2) @ clip.T
        ahead = at[..., 3:]
        beyond = np.concatenate([at[..., :2] > ahead, at[..., :2] < -ahead, ahead < 0], axis=2)
        seen = ~np.any(np.all(beyond, axis=1), axis=1)
        runs: list[tuple[int, int]] = []
        for first, count in zip(firsts[seen].tolist(), counts[seen].tolist(), strict=True):
            if runs and sum(runs[-1]) == first:
                runs[-1] = (runs[-1][0], runs[-1][1] + count)
            else:
                runs.append((first, count))
        return runs


def _open_context() -> Any:
    try:
        import moderngl  # noqa: PLC0415 - optional extra
    except ImportError as error:
        raise Refused(
            "the OpenGL renderer needs moderngl: pip install 'doro-sim-feeder[render-gl]', or"
            " use the renderer 'embree'"
        ) from error
    create: Any = moderngl.create_context  # its stub does not know backends by name
    try:
        return create(standalone=True, backend="egl", require=430)
    except Exception as error:  # glcontext raises no narrower one
        raise Refused(
            f"OpenGL 4.3 by EGL is not available ({error}): apt-get install libegl1"
            " libgl1-mesa-dri, or use the renderer 'embree'"
        ) from error


def _projection(tangent: float, near_m: float) -> NDArray[np.float64]:
    """Return the clip matrix of a square view; axes right, up, ahead."""
    span = FAR_M - near_m
    return np.array(
        [
            [1 / tangent, 0, 0, 0],
            [0, 1 / tangent, 0, 0],
            [0, 0, (FAR_M + near_m) / span, -2 * FAR_M * near_m / span],
            [0, 0, 1, 0],
        ]
    )


def _view(
    right: NDArray[Any], up: NDArray[Any], ahead: NDArray[Any], eye: NDArray[Any]
) -> NDArray[np.float64]:
    matrix = np.eye(4)
    matrix[:3, :3] = right, up, ahead
    matrix[:3, 3] = -matrix[:3, :3] @ eye
    return matrix


def _gl(matrix: NDArray[np.float64]) -> NDArray[np.float32]:
    """Return a matrix as OpenGL takes it: column major, float32."""
    return np.ascontiguousarray(matrix.T, np.float32)


def _upright(data: bytes, dtype: type[Any], side_px: int, channels: int) -> NDArray[Any]:
    """Return an image with row 0 on top; OpenGL's is at the bottom."""
    image = np.frombuffer(data, dtype).reshape(side_px, side_px, channels)
    return np.ascontiguousarray(image[::-1])


def _instance_ranges(
    soup: Soup,
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
    """Return first index, number of indices and the box's corners (n, 8, 3) of each instance."""
    starts = np.flatnonzero(np.diff(soup.face_instance, prepend=soup.face_instance[0] - 1))
    ends = np.append(starts[1:], len(soup.face_instance))
    corners = []
    for start, end in zip(starts, ends, strict=True):
        points = soup.vertices[soup.faces[start:end].ravel()]
        low, high = points.min(axis=0), points.max(axis=0)
        grid = np.meshgrid(*zip(low, high, strict=True), indexing="ij")
        corners.append(np.stack(grid, axis=-1).reshape(8, 3))
    return starts * 3, (ends - starts) * 3, np.asarray(corners, np.float64)


def _part_buffers(soup: Soup, part_materials: list[str | None]) -> tuple[bytes, bytes]:
    """Return the table of parts and the texels, laid out as the fragment program reads them."""
    atlas = make_atlas(soup)
    columns = [("color", "4f4"), ("exponent", "4f4"), ("surface", "4f4"), ("place", "4i4")]
    rows = np.zeros(len(soup.parts), columns)
    look = surface_rows(part_materials)
    rows["color"][:, :3] = atlas.color
    rows["color"][:, 3] = look[:, 0]
    rows["exponent"][:, 0] = look[:, 1]
    rows["exponent"][:, 1] = look[:, 6]
    rows["exponent"][soup.face_part, 2] = soup.face_instance
    rows["exponent"][:, 3] = look[:, 5]
    rows["surface"][:, :3] = look[:, 2:5]
    rows["place"][:, :3] = np.stack([atlas.offset, atlas.width, atlas.height], axis=1)
    texels = np.zeros((len(atlas.texels), 4), np.uint8)
    texels[:, :3] = np.rint(atlas.texels * 255)
    return rows.tobytes(), texels.tobytes()
