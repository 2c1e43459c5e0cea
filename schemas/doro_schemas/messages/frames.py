"""Images of the robot: colour, and depth with pose and intrinsics."""

from __future__ import annotations

from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from doro_schemas.camera import Intrinsics, Pose
from doro_schemas.messages.base import FrameMessage


class ColorFrame(FrameMessage, kw_only=True):
    """A colour image.

    Attributes:
        encoding: ``rgb8``: data is uint8 (height, width, 3); ``jpeg``, ``png``: data is the
            file's bytes, uint8 (n,).
        data: the segment.
    """

    SEGMENTS: ClassVar[tuple[str, ...]] = ("data",)

    encoding: Literal["rgb8", "jpeg", "png"] = "rgb8"
    data: np.ndarray[Any, Any]

    def __post_init__(self) -> None:
        super().__post_init__()
        shape = (self.height_px, self.width_px, 3)
        if self.data.dtype != np.uint8:
            raise ValueError(f"colour data must be uint8, got {self.data.dtype}")
        if self.encoding == "rgb8" and self.data.shape != shape:
            raise ValueError(f"rgb8 data must have shape {shape}, got {self.data.shape}")
        if self.encoding != "rgb8" and (self.data.ndim != 1 or self.data.size == 0):
            raise ValueError(
                f"{self.encoding} data must be the file's bytes, got {self.data.shape}"
            )


class DepthFrame(FrameMessage, kw_only=True):
    """A depth image with the camera's absolute pose.

    Attributes:
        encoding: ``f32_m``: float32 metres; ``u16_mm``: uint16 millimetres. Planar depth
            along the optical axis; 0 (and, in f32_m, any value that is not finite) is a hole.
        max_depth_m: depths at or beyond it are clipped and count as unknown; 0 = no limit.
        intrinsics, pose: camera model of this frame (:mod:`doro_schemas.camera`).
        data: the segment, (height, width).
    """

    SEGMENTS: ClassVar[tuple[str, ...]] = ("data",)

    encoding: Literal["f32_m", "u16_mm"] = "f32_m"
    max_depth_m: float = 0.0
    intrinsics: Intrinsics
    pose: Pose
    data: np.ndarray[Any, Any]

    def __post_init__(self) -> None:
        super().__post_init__()
        dtype = np.float32 if self.encoding == "f32_m" else np.uint16
        shape = (self.height_px, self.width_px)
        if self.data.dtype != dtype or self.data.shape != shape:
            raise ValueError(
                f"{self.encoding} depth must be {np.dtype(dtype)} of shape {shape},"
                f" got {self.data.dtype} {self.data.shape}"
            )

    def depth_m(self) -> NDArray[np.float32]:
        """Return the depth as float32 (height, width) metres; holes and clipped values are 0."""
        if self.encoding == "u16_mm":
            depth = self.data.astype(np.float32) * np.float32(0.001)
        else:
            depth = np.where(np.isfinite(self.data) & (self.data > 0), self.data, np.float32(0))
        if self.max_depth_m > 0:
            depth = np.where(depth < self.max_depth_m, depth, np.float32(0))
        return depth
