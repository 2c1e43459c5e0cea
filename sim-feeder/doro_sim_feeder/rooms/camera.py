"""One view of a scene: depth, instance ids and a shaded image from the same rays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from doro_schemas.camera import Intrinsics, Pose, intrinsics_from_vertical_fov
from doro_sim_feeder.rooms.raycast import Hits, RayCaster
from doro_sim_feeder.rooms.shading import Shader


@dataclass(frozen=True)
class Picture:
    """A rendered view.

    Attributes:
        depth_m: float32 (h, w), planar along the optical axis, 0 where nothing was hit.
        ids: int32 (h, w) instance ids, 0 where nothing was hit.
        color: uint8 (h, w, 3) RGB; None where only geometry was asked for.
    """

    depth_m: NDArray[np.float32]
    ids: NDArray[np.int32]
    color: NDArray[np.uint8] | None


class Camera:
    """A square pinhole camera with AI2-THOR's vertical field of view."""

    def __init__(self, size_px: int = 300, fov_deg: float = 90.0) -> None:
        self.size_px = size_px
        self.intrinsics: Intrinsics = intrinsics_from_vertical_fov(size_px, size_px, fov_deg)

    def rays(self, pose: Pose, du_px: float = 0.5, dv_px: float = 0.5) -> NDArray[np.float32]:
        """Return ray directions float32 (h*w, 3) with unit length along the optical axis.

        A hit's distance in direction lengths is therefore its planar depth.
        """
        u, v = np.meshgrid(np.arange(self.size_px) + du_px, np.arange(self.size_px) + dv_px)
        k = self.intrinsics
        rays = np.stack([(u - k.cx) / k.fx, (v - k.cy) / k.fy, np.ones_like(u)], axis=-1)
        directions: NDArray[np.float32] = (rays.reshape(-1, 3) @ pose.matrix().T).astype(np.float32)
        return directions

    def take(self, caster: RayCaster, pose: Pose, shader: Shader | None = None) -> Picture:
        """Render a view; without a shader depth and ids only, some 15 ms at 300 px.

        Depth and ids come from the rays through the pixel centres, never from the
        supersampled colour, which would mix objects at their edges.
        """
        shape = (self.size_px, self.size_px)
        origin = np.asarray(pose.position_m, np.float32)
        hits: Hits = caster.cast(origin, self.rays(pose))
        seen = hits.face >= 0
        depth = np.where(seen, hits.distance, np.float32(0)).reshape(shape)
        ids = np.where(seen, caster.soup.face_instance[np.maximum(hits.face, 0)], 0)
        color = None if shader is None else self._color(caster, pose, shader)
        return Picture(depth, ids.astype(np.int32).reshape(shape), color)

    def _color(self, caster: RayCaster, pose: Pose, shader: Shader) -> NDArray[np.uint8]:
        origin = np.asarray(pose.position_m, np.float32)
        total = np.zeros((self.size_px * self.size_px, 3), np.float32)
        samples = ((0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.75, 0.75))
        for number, (du_px, dv_px) in enumerate(samples):
            directions = self.rays(pose, du_px, dv_px)
            hits = caster.cast(origin, directions)
            total += shader.shade(origin, directions, hits, lamp_angle=number * np.pi / 2 + 0.4)
        mean = np.rint(total * (255 / len(samples))).astype(np.uint8)
        color: NDArray[np.uint8] = mean.reshape(self.size_px, self.size_px, 3)
        return color
