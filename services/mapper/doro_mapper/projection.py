"""Robust 3-D measurements of a frame's detections: soft Gaussian mask and depth window.

Paper, Section IV-B, with DESIGN's corrections: the mask has peak 1, and of the points
in the box only those of one depth window count. Neither the most frequent depth nor all
points do: background is often the larger part of a box (measured: twice the gross errors).
All detections of a frame are measured together. Samples of all boxes stand in one row, box after
box, so that small boxes and narrow windows cost little, and one sort serves them all.
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
GRAIN_BITS = 22
MIDDLE_GRAIN = 1 << (GRAIN_BITS - 1)
WEIGHTED, PLAIN = np.array([0.05, 0.5, 0.95]), np.array([OUTER_SHARE, 1 - OUTER_SHARE])
SPREAD = (np.arange(KEPT_POINTS) + 0.5) / KEPT_POINTS

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
class _Samples:
    """Samples of all boxes, box after box; those of box ``i`` end before ``stop[i]``.

    Attributes:
        u_px, v_px, depth_m, weight: (k,); the weight is the soft mask.
        row: (k,) which box. start, stop: (n,).
    """

    u_px: Floats
    v_px: Floats
    depth_m: Floats
    weight: Floats
    row: Ints
    start: Ints
    stop: Ints


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
    index, found = _sampled(depth_m, boxes_px, sigma, samples, max_depth_m)
    boxes = boxes_px[index]
    sides = (boxes[:, 2:] - boxes[:, :2]) / (camera.intrinsics.fx, camera.intrinsics.fy)
    return _measured(
        _windows(found, np.sqrt(sides[:, 0] * sides[:, 1])), index, boxes, sides, camera
    )


def _sampled(
    depth_m: NDArray[np.float32], boxes_px: Floats, sigma: float, samples: int, max_depth_m: float
) -> tuple[Ints, _Samples]:
    """Return the boxes with enough usable depth, and their samples on a raster each."""
    height, width = depth_m.shape
    n = len(boxes_px)
    low = np.maximum(boxes_px[:, :2].astype(np.int64), 0)
    high = np.minimum(np.ceil(boxes_px[:, 2:]).astype(np.int64), (width, height))
    step = np.maximum(-(-(high - low) // samples), 1)
    at = low[:, :, None] + step[:, :, None] * np.arange(samples)
    inside = at < high[:, :, None]
    at = np.minimum(at, np.array([[[width - 1], [height - 1]]]))
    line = at[:, 1] * width
    depth = depth_m.ravel().take(line[:, :, None] + at[:, 0, None, :]).astype(np.float64)
    usable = (depth > NEAREST_DEPTH_M) & (depth < max_depth_m)
    usable &= inside[:, 1, :, None] & inside[:, 0, None, :]
    count = np.count_nonzero(usable, axis=(1, 2))
    index = np.flatnonzero(count >= MIN_POINTS)
    if len(index) < n:
        usable[count < MIN_POINTS] = False
    flat = np.flatnonzero(usable)
    of_row, column = np.divmod(flat, samples)
    of_column = of_row // samples * samples + column
    centers = at + 0.5
    mask_u, mask_v = np.moveaxis(mask_by_side(centers, boxes_px, sigma), 1, 0)
    count = count[index]
    stop = np.cumsum(count)
    return index, _Samples(
        u_px=centers[:, 0].ravel().take(of_column),
        v_px=centers[:, 1].ravel().take(of_row),
        depth_m=depth.ravel().take(flat),
        weight=mask_u.ravel().take(of_column) * mask_v.ravel().take(of_row),
        row=np.repeat(np.arange(len(index)), count),
        start=stop - count,
        stop=stop,
    )


def mask_by_side(centers_px: Floats, boxes_px: Floats, sigma: float) -> Floats:
    """Return the soft mask along columns and rows, (n, 2, samples): their product is the mask.

    ``exp(-1/2[(du/(sW))^2 + (dv/(sH))^2])``, peak 1.
    """
    middle = (boxes_px[:, :2] + boxes_px[:, 2:]) / 2
    width = sigma * (boxes_px[:, 2:] - boxes_px[:, :2])
    off = (centers_px - middle[:, :, None]) / width[:, :, None]
    return np.asarray(np.exp(-0.5 * (off * off)))


def _sorted_order(values: Floats, group: Ints) -> tuple[Ints, Ints]:
    """Return (order, grains): the order by group and value, and the values in it.

    Args:
        group: (k,) >= 0, ascending.
    """
    bits = len(values).bit_length()
    grains = (values * GRAIN_PER_M).astype(np.int64) + MIDDLE_GRAIN
    keys = (((group << GRAIN_BITS) + grains) << bits) + np.arange(len(values))
    keys.sort()
    return keys & ((1 << bits) - 1), ((keys >> bits) & ((1 << GRAIN_BITS) - 1)) - MIDDLE_GRAIN


def _windows(all_of: _Samples, side_per_m: Floats) -> _Samples:
    """Choose each detection's depth window; its samples in order of depth.

    Over windows [a, a + max(4 cm, .8 side_per_m a)] that start at a sample, the nearest with at
    least WINDOW_SHARE of the best mass, slid to its local maximum.
    """
    if not len(all_of.row):
        return all_of
    order, grains = _sorted_order(all_of.depth_m, all_of.row)
    end = _window_ends(grains, all_of.row, side_per_m)
    total = np.zeros(len(order) + 1)
    np.cumsum(all_of.weight[order], out=total[1:])
    mass = total[end] - total[:-1]
    enough = WINDOW_SHARE * np.maximum.reduceat(mass, all_of.start)
    good = np.flatnonzero(mass >= enough[all_of.row])
    first = good[np.searchsorted(good, all_of.start)]
    best = [
        i + int(mass[i:j].argmax())
        for i, j in zip(first.tolist(), end[first].tolist(), strict=True)
    ]
    stop = end[best]
    chosen = np.concatenate([order[i:j] for i, j in zip(best, stop.tolist(), strict=True)])
    count = stop - best
    stop = np.cumsum(count)
    return _Samples(
        all_of.u_px[chosen], all_of.v_px[chosen], all_of.depth_m[chosen], all_of.weight[chosen],
        np.repeat(np.arange(len(count)), count), stop - count, stop,
    )  # fmt: skip


def _window_ends(grains: Ints, row: Ints, side_per_m: Floats) -> Ints:
    """Return for each start where the samples up to the window's far end stop, (k,)."""
    length = np.maximum(WINDOW_MIN_M * GRAIN_PER_M, (WINDOW_OF_SIDE * side_per_m)[row] * grains)
    base = row << GRAIN_BITS
    bound = np.minimum(grains + length.astype(np.int64), MIDDLE_GRAIN - 1)
    return np.asarray(np.searchsorted(grains + base, bound + base, side="right"))


def _measured(
    window: _Samples, index: Ints, boxes: Floats, sides: Floats, camera: Camera
) -> Measured:
    lens, n, depth = camera.intrinsics, len(index), window.depth_m
    local = np.empty((3, len(depth)))
    local[0] = (window.u_px - lens.cx) / lens.fx * depth
    local[1] = (window.v_px - lens.cy) / lens.fy * depth
    local[2] = depth
    ahead = camera.rotation.T @ local
    mass = np.bincount(window.row, window.weight, minlength=n)
    share = window.weight / np.maximum(mass, 1e-12)[window.row]
    bounds = _bounds(ahead, share, window) + camera.position_m
    low, middle, high, outer_low, outer_high = bounds
    kept = np.searchsorted(np.cumsum(share), np.arange(n)[:, None] + SPREAD)
    kept = np.minimum(kept, window.stop[:, None] - 1)
    ahead += camera.position_m[:, None]
    range_m: Floats = np.bincount(window.row, depth * share, minlength=n).astype(np.float64)
    width, height = camera.size_px
    touches = np.minimum(boxes[:, :2], (width, height) - boxes[:, 2:]).min(axis=1) <= BORDER_PX
    return Measured(
        index=index,
        box_px=boxes,
        center_m=0.5 * middle + 0.25 * (low + high),
        low_m=low,
        high_m=high,
        outer_low_m=outer_low,
        outer_high_m=outer_high,
        points_m=ahead[:, kept].transpose(1, 2, 0).astype(np.float32),
        range_m=range_m,
        size_m=sides * range_m[:, None],
        area_share=(boxes[:, 2] - boxes[:, 0]) * (boxes[:, 3] - boxes[:, 1]) / (width * height),
        at_border=touches,
        sample_points_m=ahead.T,
        sample_weights=window.weight,
        sample_of=window.row,
    )


def _bounds(points: Floats, share: Floats, window: _Samples) -> Floats:
    """Return per axis the weighted 5, 50, 95 % and plain 1, 99 % quantiles, (5, n, 3).

    Args:
        points: (3, k).
        share: (k,) of the detection's weight; sums to 1 in each.
    """
    n, k = len(window.stop), points.shape[1]
    group = (np.arange(3)[:, None] * n + window.row).ravel()
    order, grains = _sorted_order(points.ravel(), group)
    mass = np.cumsum(np.concatenate([share] * 3)[order])
    begin = (np.arange(3)[:, None] * k + window.start).ravel()
    last = (np.arange(3)[:, None] * k + window.stop).ravel() - 1
    # Each group's mass is 1, so that all before it sum to its number.
    at = np.searchsorted(mass, np.arange(3 * n) + WEIGHTED[:, None])
    out = np.empty((5, 3 * n))
    out[:3] = grains[np.minimum(at, last)]
    place = PLAIN[:, None] * (last - begin)
    below = np.floor(place).astype(np.int64)
    lower = grains[begin + below]
    upper = grains[np.minimum(begin + below + 1, last)]
    out[3:] = lower + (place - below) * (upper - lower)
    return np.asarray((out / GRAIN_PER_M).reshape(5, 3, n).transpose(0, 2, 1))
