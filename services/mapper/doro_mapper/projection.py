"""Robust 3-D measurements of a frame's detections: soft Gaussian mask and depth window.

Paper, Section IV-B, with DESIGN's corrections: the mask has peak 1, and of the points
in the box only those of one depth window count. Neither the most frequent depth nor all
points do: background is often the larger part of a box (measured: twice the gross errors).
All detections of a frame are measured together: one raster per box, padded to one shape.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from doro_mapper.views import Bools, Camera, Floats

KEPT_POINTS = 24
WINDOW_SHARE = 0.4
"""The nearest window with this share of the best window's mass is the object's."""
WINDOW_OF_SIDE = 0.8
WINDOW_MIN_M = 0.04
NEAREST_DEPTH_M = 0.05
MIN_POINTS = 3
BORDER_PX = 1.0
OUTER_SHARE = 0.01
GRAIN_PER_M = 10_000
"""Values are sorted as integers of 0.1 mm, with their index in the low bits: ties are equal on
every machine, and numpy sorts integers fastest."""
LAST_GRAIN = (1 << 21) - 1

Ints = NDArray[Any]


@dataclass(frozen=True, slots=True)
class Measured:
    """n measured detections of one frame; map axes, metres.

    Attributes:
        index: (n,) which of the boxes given.
        box_px: (n, 4) edges.
        center_m, low_m, high_m: (n, 3) centre and weighted 5 % / 95 % bounds.
        outer_low_m, outer_high_m: (n, 3) bounds without weights. The mask shrinks the weighted
            ones to about .73 of the thing: right for association, wrong as an extent.
        points_m: (n, KEPT_POINTS, 3) float32, spread evenly over the weight.
        range_m: (n,) weighted mean depth.
        size_m: (n, 2) width and height of the box at that depth.
        area_share: (n,) the box's share of the image.
        at_border: (n,) the box touches the image's border, the thing may be cut off.
        sample_points_m, sample_weights, sample_of: (k, 3), (k,), (k,) every sample in the
            windows, its mask 0..1, and its row among the n.
    """

    index: Ints
    box_px: Floats
    center_m: Floats
    low_m: Floats
    high_m: Floats
    outer_low_m: Floats
    outer_high_m: Floats
    points_m: NDArray[np.float32]
    range_m: Floats
    size_m: Floats
    area_share: Floats
    at_border: Bools
    sample_points_m: Floats
    sample_weights: Floats
    sample_of: Ints

    def __len__(self) -> int:
        return len(self.index)


@dataclass(frozen=True, slots=True)
class _Windows:
    """Samples of each detection's depth window, in order of depth, padded to (n, m)."""

    u_px: Floats
    v_px: Floats
    depth_m: Floats
    weight: Floats
    inside: Bools


def measure(
    depth_m: NDArray[np.float32],
    boxes_px: Floats,
    camera: Camera,
    *,
    sigma: float,
    samples: int,
    max_depth_m: float,
) -> Measured:
    """Measure all detections of a frame; those without usable depth are left out.

    Args:
        depth_m: (height, width) float32, 0 is a hole.
        boxes_px: (n, 4) edges ``[xmin, ymin, xmax, ymax]``, inside the image.
        camera: the frame's camera, map axes.
        sigma: width of the soft mask as a fraction of the box side.
        samples: largest number of samples per side, at most 32.
    """
    raster = _raster(depth_m, boxes_px, samples)
    usable = raster.inside & (raster.depth_m > NEAREST_DEPTH_M) & (raster.depth_m < max_depth_m)
    index = np.flatnonzero(usable.sum(axis=1) >= MIN_POINTS)
    boxes = boxes_px[index]
    mask = soft_mask(raster.u_px[index], raster.v_px[index], boxes, sigma)
    sides = (boxes[:, 2:] - boxes[:, :2]) / (camera.intrinsics.fx, camera.intrinsics.fy)
    windows = _windows(raster, usable, index, mask, np.sqrt(sides.prod(axis=1)))
    return _measured(windows, index, boxes, sides, camera)


@dataclass(frozen=True, slots=True)
class _Raster:
    """Columns and rows looked at per box, and the depth there; all (n, samples ** 2)."""

    u_px: Floats
    v_px: Floats
    depth_m: Floats
    inside: Bools


def _raster(depth_m: NDArray[np.float32], boxes_px: Floats, samples: int) -> _Raster:
    height, width = depth_m.shape
    low = np.maximum(boxes_px[:, :2].astype(np.int64), 0)
    high = np.minimum(np.ceil(boxes_px[:, 2:]).astype(np.int64), (width, height))
    step = np.maximum(-(-(high - low) // samples), 1)
    at = low[:, :, None] + step[:, :, None] * np.arange(samples)
    inside = at < high[:, :, None]
    at = np.minimum(at, np.array([width - 1, height - 1])[:, None])
    n = len(boxes_px)
    depth = depth_m[at[:, 1, :, None], at[:, 0, None, :]].astype(np.float64)
    both = inside[:, 1, :, None] & inside[:, 0, None, :]
    u = np.broadcast_to(at[:, 0, None, :] + 0.5, depth.shape)
    v = np.broadcast_to(at[:, 1, :, None] + 0.5, depth.shape)
    flat = (n, samples * samples)
    return _Raster(u.reshape(flat), v.reshape(flat), depth.reshape(flat), both.reshape(flat))


def soft_mask(u_px: Floats, v_px: Floats, boxes_px: Floats, sigma: float) -> Floats:
    """Return the mask ``exp(-1/2[(du/(sW))^2 + (dv/(sH))^2])`` with peak 1, (n, k).

    Args:
        u_px, v_px: (n, k) columns and rows of each box's samples.
        boxes_px: (n, 4).
        sigma: width as a fraction of the box side.
    """
    middle = (boxes_px[:, :2] + boxes_px[:, 2:]) / 2
    width = sigma * (boxes_px[:, 2:] - boxes_px[:, :2])
    du = (u_px - middle[:, :1]) / width[:, :1]
    dv = (v_px - middle[:, 1:]) / width[:, 1:]
    mask: Floats = np.exp(-0.5 * (du * du + dv * dv))
    return mask


def _sorted_order(values: Floats, last: Bools) -> tuple[Ints, Ints]:
    """Return (order, grains): the order of each row by value, and the values in it.

    ``last`` marks what goes to the end. Rows have at most 1024 entries.
    """
    grains = np.where(last, LAST_GRAIN, values * GRAIN_PER_M).astype(np.int32)
    keys = np.sort((grains << 10) | np.arange(values.shape[1], dtype=np.int32), axis=1)
    return keys & 1023, keys >> 10


def _along(values: NDArray[Any], at: Ints) -> NDArray[Any]:
    """Return ``values[i, at[i, j]]``, as take_along_axis does for rows but in half the time."""
    rows = np.arange(0, values.size, values.shape[1])[:, None]
    return np.asarray(values.ravel().take(at + rows))


def _windows(
    raster: _Raster, usable: Bools, index: Ints, mask: Floats, side_per_m: Floats
) -> _Windows:
    """Choose each detection's depth window.

    Over windows [a, a + max(4 cm, .8 side_per_m a)] that start at a sample, the nearest with at
    least WINDOW_SHARE of the best mass, slid to its local maximum.
    """
    ok = usable[index]
    order, grains = _sorted_order(raster.depth_m[index], ~ok)
    count = ok.sum(axis=1)[:, None]
    weight = _along(np.where(ok, mask, 0.0), order)
    end = _window_ends(grains, count, side_per_m[:, None])
    total = np.zeros((len(index), grains.shape[1] + 1))
    np.cumsum(weight, axis=1, out=total[:, 1:])
    at = np.arange(grains.shape[1])
    mass = np.where(at < count, _along(total, end) - total[:, :-1], -1.0)
    first = np.argmax(mass >= WINDOW_SHARE * mass.max(axis=1, keepdims=True), axis=1)[:, None]
    near = (at >= first) & (at < _along(end, first))
    best = np.argmax(np.where(near, mass, -1.0), axis=1)[:, None]
    size = _along(end, best) - best
    within = np.arange(int(size.max(initial=1)))
    inside = within < size
    chosen = _along(order, np.minimum(best + within, at[-1]))

    def gathered(values: Floats) -> Floats:
        return _along(values[index], chosen)

    kept = np.where(inside, _along(mask, chosen), 0.0)
    depth = gathered(raster.depth_m)
    return _Windows(gathered(raster.u_px), gathered(raster.v_px), depth, kept, inside)


def _window_ends(grains: Ints, count: Ints, side_per_m: Floats) -> Ints:
    """Return for each start the number of samples up to the window's far end, (n, m)."""
    n, m = grains.shape
    length = np.maximum(WINDOW_MIN_M * GRAIN_PER_M, WINDOW_OF_SIDE * side_per_m * grains)
    row = np.arange(n, dtype=np.int32)[:, None] << 22
    bound = np.minimum(grains + length.astype(np.int32), LAST_GRAIN)
    flat = (grains + row).ravel()
    found = np.searchsorted(flat, (bound + row).ravel(), side="right").reshape(n, m)
    return np.asarray(np.minimum(found - np.arange(n)[:, None] * m, count))


def _measured(
    windows: _Windows, index: Ints, boxes: Floats, sides: Floats, camera: Camera
) -> Measured:
    lens, inside = camera.intrinsics, windows.inside
    local = np.stack(
        [
            (windows.u_px - lens.cx) / lens.fx * windows.depth_m,
            (windows.v_px - lens.cy) / lens.fy * windows.depth_m,
            windows.depth_m,
        ],
        axis=-1,
    )
    ahead = local @ camera.rotation
    share = windows.weight / np.maximum(windows.weight.sum(axis=1, keepdims=True), 1e-12)
    bounds = _bounds(ahead, share, inside) + camera.position_m[:, None]
    low, middle, high, outer_low, outer_high = np.moveaxis(bounds, 2, 0)
    spread = (np.arange(KEPT_POINTS) + 0.5) / KEPT_POINTS
    kept = (np.cumsum(share, axis=1)[:, :, None] < spread).sum(axis=1)
    kept = np.minimum(kept, inside.sum(axis=1)[:, None] - 1)
    points = np.take_along_axis(ahead, kept[:, :, None], 1) + camera.position_m
    range_m = (windows.depth_m * share).sum(axis=1)
    width, height = camera.size_px
    low_edge, high_edge = boxes[:, :2], np.array([width, height]) - boxes[:, 2:]
    touches = np.minimum(low_edge, high_edge).min(axis=1) <= BORDER_PX
    of = np.broadcast_to(np.arange(len(index))[:, None], inside.shape)
    return Measured(
        index=index,
        box_px=boxes,
        center_m=0.5 * middle + 0.25 * (low + high),
        low_m=low,
        high_m=high,
        outer_low_m=outer_low,
        outer_high_m=outer_high,
        points_m=points.astype(np.float32),
        range_m=range_m,
        size_m=sides * range_m[:, None],
        area_share=(boxes[:, 2:] - boxes[:, :2]).prod(axis=1) / (width * height),
        at_border=touches,
        sample_points_m=ahead[inside] + camera.position_m,
        sample_weights=windows.weight[inside],
        sample_of=of[inside],
    )


def _bounds(points: Floats, share: Floats, inside: Bools) -> Floats:
    """Return per axis the weighted 5, 50, 95 % and plain 1, 99 % quantiles, (n, 3, 5)."""
    n, m, _ = points.shape
    columns = points.transpose(0, 2, 1).reshape(3 * n, m)
    outside = np.repeat(~inside, 3, axis=0)
    order, grains = _sorted_order(columns, outside)
    mass = np.cumsum(_along(np.repeat(share, 3, axis=0), order), axis=1)
    last = np.repeat(inside.sum(axis=1) - 1, 3)
    picks: list[NDArray[Any]] = []
    for quantile in (0.05, 0.5, 0.95):
        at = np.minimum((mass < quantile).sum(axis=1), last)
        picks.append(_along(grains, at[:, None])[:, 0].astype(np.float64))
    for quantile in (OUTER_SHARE, 1 - OUTER_SHARE):
        place = quantile * last
        below = np.floor(place).astype(np.int64)
        above = np.minimum(below + 1, last)
        pair = _along(grains, np.stack([below, above], axis=1))
        picks.append(pair[:, 0] + (place - below) * (pair[:, 1] - pair[:, 0]))
    return (np.stack(picks, axis=1) / GRAIN_PER_M).reshape(n, 3, 5)
