"""One robust 3-D measurement per detection: soft Gaussian mask and depth window.

Paper, Section IV-B, with DESIGN's corrections: the mask has peak 1, and of the points
in the box only those of one depth window count. Neither the most frequent depth nor all
points do: background is often the larger part of a box (measured: twice the gross errors).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from doro_mapper.views import Camera, Floats
from doro_schemas.camera import Pose, backproject, bev_axes

KEPT_POINTS = 24
WINDOW_SHARE = 0.4
"""The nearest window with this share of the best window's mass is the object's."""
WINDOW_OF_SIDE = 0.8
WINDOW_MIN_M = 0.04
NEAREST_DEPTH_M = 0.05
BORDER_PX = 1.0
OUTER_SHARE = 0.01


@dataclass(frozen=True, slots=True)
class Measurement:
    """Where a detection is; map axes, metres.

    Attributes:
        center_m, low_m, high_m: (3,) centre and weighted 5 % / 95 % bounds.
        outer_low_m, outer_high_m: (3,) bounds without weights. The mask shrinks the weighted
            ones to about .73 of the thing: right for association, wrong as an extent.
        points_m: (KEPT_POINTS, 3) float32, spread evenly over the weight.
        range_m: weighted mean depth.
        size_m: width and height of the box at that depth.
        area_share: the box's share of the image.
        at_border: the box touches the image's border, the thing may be cut off.
    """

    center_m: Floats
    low_m: Floats
    high_m: Floats
    outer_low_m: Floats
    outer_high_m: Floats
    points_m: NDArray[np.float32]
    range_m: float
    size_m: tuple[float, float]
    area_share: float
    at_border: bool


@dataclass(frozen=True, slots=True)
class Samples:
    """Every sample of a detection's window, for the hash maps.

    Attributes:
        points_m: (n, 3) map axes.
        weights: (n,) soft mask, 0..1.
    """

    points_m: Floats
    weights: Floats


def soft_mask(u_px: Floats, v_px: Floats, box_px: list[float], sigma: float) -> Floats:
    """Return the mask ``exp(-1/2[(du/(sW))^2 + (dv/(sH))^2])`` with peak 1, (len(v), len(u)).

    Args:
        u_px, v_px: columns and rows of the sample raster.
        sigma: width as a fraction of the box side.
    """
    xmin, ymin, xmax, ymax = box_px
    du = (u_px - (xmin + xmax) / 2) / (sigma * (xmax - xmin))
    dv = (v_px - (ymin + ymax) / 2) / (sigma * (ymax - ymin))
    mask: Floats = np.exp(-0.5 * dv**2)[:, None] * np.exp(-0.5 * du**2)[None]
    return mask


def depth_window(depth_m: Floats, weights: Floats, length_per_m: float) -> tuple[float, float]:
    """Return the (nearest, farthest) depth of the object's window.

    Over windows [a, a + max(4 cm, length_per_m * a)] that start at a sample, take the nearest
    with at least WINDOW_SHARE of the best mass, and slide it to its local maximum.
    """
    order = np.argsort(depth_m, kind="stable")
    z = depth_m[order]
    cumulated = np.concatenate([[0.0], np.cumsum(weights[order])])
    length = np.maximum(WINDOW_MIN_M, length_per_m * z)
    end = np.searchsorted(z, z + length, side="right")
    mass = cumulated[end] - cumulated[:-1]
    first = int(np.argmax(mass >= WINDOW_SHARE * mass.max()))
    last = int(np.searchsorted(z, z[first] + length[first], side="right"))
    best = first + int(np.argmax(mass[first:last]))
    return float(z[best]), float(z[end[best] - 1])


def weighted_quantiles(values: Floats, weights: Floats, shares: list[float]) -> Floats:
    """Return weighted quantiles per column of ``values`` (n, k): (len(shares), k)."""
    out = np.empty((len(shares), values.shape[1]))
    for column in range(values.shape[1]):
        order = np.argsort(values[:, column], kind="stable")
        at = np.searchsorted(np.cumsum(weights[order]), shares).clip(0, len(values) - 1)
        out[:, column] = values[order[at], column]
    return out


def measure(
    depth_m: NDArray[np.float32],
    box_px: list[float],
    camera: Camera,
    pose: Pose,
    *,
    sigma: float,
    samples: int,
    max_depth_m: float,
) -> tuple[Measurement, Samples] | None:
    """Measure one detection; None where the box has no usable depth.

    Args:
        depth_m: (height, width) float32, 0 is a hole.
        box_px: edges ``[xmin, ymin, xmax, ymax]``.
        pose: the frame's pose, world axes.
        sigma: width of the soft mask as a fraction of the box side.
        samples: largest number of samples per side.
    """
    height, width = depth_m.shape
    xmin, ymin, xmax, ymax = box_px
    left, top = max(0, int(xmin)), max(0, int(ymin))
    right, bottom = min(width, int(np.ceil(xmax))), min(height, int(np.ceil(ymax)))
    step_u, step_v = -(-(right - left) // samples), -(-(bottom - top) // samples)
    if step_u < 1 or step_v < 1:
        return None
    patch = depth_m[top:bottom:step_v, left:right:step_u].astype(np.float64)
    u = np.arange(left, right, step_u) + 0.5
    v = np.arange(top, bottom, step_v) + 0.5
    mask = soft_mask(u, v, box_px, sigma)
    usable = (patch > NEAREST_DEPTH_M) & (patch < max_depth_m)
    if usable.sum() < 3:
        return None
    lens = camera.intrinsics
    side_per_m = float(np.sqrt((xmax - xmin) * (ymax - ymin) / (lens.fx * lens.fy)))
    near, far = depth_window(patch[usable], mask[usable], WINDOW_OF_SIDE * side_per_m)
    chosen = usable & (patch >= near) & (patch <= far)
    rows, columns = np.nonzero(chosen)
    z, weights = patch[chosen], mask[chosen]
    world = backproject(u[columns], v[rows], z, lens, pose)
    points = world[:, list(bev_axes(pose.world))]
    share = weights / weights.sum()
    low, middle, high = weighted_quantiles(points, share, [0.05, 0.5, 0.95])
    outer_low, outer_high = np.quantile(points, [OUTER_SHARE, 1 - OUTER_SHARE], axis=0)
    spread = (np.arange(KEPT_POINTS) + 0.5) / KEPT_POINTS
    kept = np.searchsorted(np.cumsum(share), spread).clip(0, len(points) - 1)
    range_m = float(z @ share)
    touches = xmin <= BORDER_PX or ymin <= BORDER_PX
    measurement = Measurement(
        center_m=0.5 * middle + 0.25 * (low + high),
        low_m=low,
        high_m=high,
        outer_low_m=outer_low,
        outer_high_m=outer_high,
        points_m=points[kept].astype(np.float32),
        range_m=range_m,
        size_m=((xmax - xmin) / lens.fx * range_m, (ymax - ymin) / lens.fy * range_m),
        area_share=(xmax - xmin) * (ymax - ymin) / (width * height),
        at_border=touches or xmax >= width - BORDER_PX or ymax >= height - BORDER_PX,
    )
    return measurement, Samples(points, weights)
