"""Relations between the things of one image: from boxes, or in metres where there is depth.

From boxes alone nothing is sure: a thing is said to be on another where its foot lies inside the
box of something that carries things, in something that holds things, and near what is as far
away by the look of it (its foot at about the same height) and at most half its size aside. With
depth the rule of the map decides (:mod:`doro_schemas.spatial`).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from doro_schemas.camera import Intrinsics, Pose, backproject, bev_axes
from doro_schemas.messages import DepthFrame
from doro_schemas.spatial import Box3, relation_between

Boxes = Sequence[Sequence[float]]
Found = list[list[tuple[str, int]]]
"""Of each thing: (relation type, index of the landmark), at most one carrier and one neighbour."""

CARRIERS = frozenset(
    """counter top,dining table,coffee table,side table,desk,dresser,tv stand,shelving unit,bed,
    sofa,arm chair,chair,stool,night stand,table,refrigerator,microwave,safe,box""".replace(
        "\n    ", ""
    ).split(",")
)
HOLDERS = frozenset(["sink", "bathtub", "refrigerator", "microwave", "garbage can"])
LANDMARKS = CARRIERS | HOLDERS | {"television", "toilet", "floor lamp", "house plant", "laptop"}
LARGER = 1.5
FOOT_SHARE = 0.08
NEAR_SHARE, LEVEL_SHARE = 0.5, 0.35
LEAST_POINTS, CORE_SHARE, LAYER_M = 12, 0.8, 0.35
TRIM = (5.0, 95.0)
SEEN_FROM_ABOVE = 0.5


def from_boxes(names: Sequence[str], boxes: Boxes) -> Found:
    """Return the relations of things by their boxes ``[xmin, ymin, xmax, ymax]``, px."""
    return [
        _best(
            [
                (kind, k, distance)
                for k in range(len(boxes))
                if k != number
                for kind, distance in _flat(names, boxes, number, k)
            ]
        )
        for number in range(len(boxes))
    ]


def _flat(names: Sequence[str], boxes: Boxes, a: int, b: int) -> list[tuple[str, float]]:
    """Return how thing ``a`` stands to landmark ``b`` in the image, with a distance."""
    x0, y0, x1, y1 = boxes[a]
    left, top, right, bottom = boxes[b]
    own, other = (x1 - x0) * (y1 - y0), (right - left) * (bottom - top)
    if names[b] not in LANDMARKS or names[a] == names[b]:
        return []
    middle = (x0 + x1) / 2
    if other > LARGER * own and left <= middle <= right:
        slack = FOOT_SHARE * (bottom - top)
        inside = top - slack <= y1 <= bottom - slack
        if inside and names[b] in HOLDERS and y0 >= top - slack:
            return [("is-at", other)]
        if inside and names[b] in CARRIERS:
            return [("is-on", other)]
    if other <= own:
        return []
    aside = max(0.0, left - x1, x0 - right)
    size = max(x1 - x0, y1 - y0)
    beside = aside <= NEAR_SHARE * max(size, 0.5 * (right - left))
    level = abs(bottom - y1) <= LEVEL_SHARE * max(y1 - y0, bottom - top)
    return [("is-near", aside)] if beside and level else []


def _best(rows: list[tuple[str, int, float]]) -> list[tuple[str, int]]:
    """Return one carrier (the smallest) and one neighbour (the nearest)."""
    held = sorted((d, k, kind) for kind, k, d in rows if kind != "is-near")[:1]
    near = sorted((d, k, kind) for kind, k, d in rows if kind == "is-near")[:1]
    return [(kind, k) for _, k, kind in [*held, *near]]


def from_depth(names: Sequence[str], boxes: Boxes, depth: DepthFrame) -> Found:
    """Return the relations of things by their depth points, with the rule of the map."""
    depth_m = depth.depth_m()
    solids = [_solid(box, depth_m, depth.intrinsics, depth.pose) for box in boxes]
    found: Found = []
    for number, own in enumerate(solids):
        rows: list[tuple[str, int, float]] = []
        for k, other in enumerate(solids):
            if k == number or own is None or other is None or names[k] not in LANDMARKS:
                continue
            if names[k] == names[number] or _ground(other) <= _ground(own):
                continue
            kind = relation_between(own, other)
            if kind is not None:
                near = float(np.hypot(*np.subtract(own.center_m, other.center_m)[:2]))
                rows.append((kind, k, near if kind == "is-near" else _ground(other)))
        found.append(_best(rows))
    return found


def _ground(box: Box3) -> float:
    return box.size_m[0] * box.size_m[1]


def _solid(
    box: Sequence[float], depth_m: NDArray[np.float32], lens: Intrinsics, pose: Pose
) -> Box3 | None:
    """Return the world box of a detection's points; None where depth is missing.

    Points of the middle of the box tell how far the thing is; what is much farther or nearer
    is background or something before it.
    """
    x0, y0, x1, y1 = (round(value) for value in box)
    part = depth_m[y0:y1, x0:x1]
    if part.size == 0:
        return None
    dy, dx = (int(side * (1 - CORE_SHARE) / 2) for side in part.shape)
    core = part[dy : part.shape[0] - dy, dx : part.shape[1] - dx]
    core = core[core > 0]
    if core.size < LEAST_POINTS:
        return None
    middle = float(np.median(core))
    reach = max(LAYER_M, (x1 - x0) / lens.fx * middle)
    rows, columns = np.nonzero((part > 0) & (np.abs(part - middle) <= reach))
    z = part[rows, columns]
    world = backproject(columns + x0 + 0.5, rows + y0 + 0.5, z, lens, pose)
    low, high = np.percentile(world, TRIM, axis=0)
    first, second, up = bev_axes(pose.world)
    # From above only the top is seen: it is taken to be half as high as it is wide, at least.
    least = SEEN_FROM_ABOVE * min(high[first] - low[first], high[second] - low[second])
    low[up] = min(low[up], high[up] - least)
    center, size = (low + high) / 2, high - low
    order = (first, second, up)
    return Box3(
        (float(center[order[0]]), float(center[order[1]]), float(center[order[2]])),
        (float(size[order[0]]), float(size[order[1]]), float(size[order[2]])),
    )
