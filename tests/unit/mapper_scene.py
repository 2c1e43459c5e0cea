"""A small analytic scene for the mapper's tests: boxes in a room, ray-cast in numpy.

Truth is exact: depth is the planar depth of the nearest box along each pixel's ray, and a
detection is the bounding box of an object's visible pixels.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from doro_schemas.camera import Pose, intrinsics_from_vertical_fov, pose_from_ai2thor
from doro_schemas.graph import ObjectGraph
from doro_schemas.messages import DepthFrame, FrameGraphs, GraphBox

SIZE_PX = 300
LENS = intrinsics_from_vertical_fov(SIZE_PX, SIZE_PX, 90.0)
MIN_VISIBLE_PX = 50
MIN_SIDE_PX = 6


@dataclass(frozen=True)
class Thing:
    """A box in a unity world: centre and size (x, y up, z), metres; no name: only furniture."""

    name: str
    center_m: tuple[float, float, float]
    size_m: tuple[float, float, float]
    attributes: dict[str, str] = field(default_factory=dict)


def room(width_m: float = 5.0, length_m: float = 5.0, height_m: float = 2.5) -> list[Thing]:
    """Return floor and four walls round the origin."""
    w, n, h = width_m, length_m, height_m
    return [
        Thing("", (0, -0.05, 0), (w, 0.1, n)),
        Thing("", (-w / 2, h / 2, 0), (0.1, h, n)),
        Thing("", (w / 2, h / 2, 0), (0.1, h, n)),
        Thing("", (0, h / 2, -n / 2), (w, h, 0.1)),
        Thing("", (0, h / 2, n / 2), (w, h, 0.1)),
    ]


def render(things: list[Thing], pose: Pose) -> tuple[NDArray[np.float32], NDArray[np.int64]]:
    """Return depth (h, w) metres and index of the thing (h, w), -1 for none."""
    v, u = np.mgrid[0:SIZE_PX, 0:SIZE_PX] + 0.5
    local = np.stack([(u - LENS.cx) / LENS.fx, (v - LENS.cy) / LENS.fy, np.ones_like(u)], -1)
    rays = local @ pose.matrix().T  # planar depth 1 along each ray
    inverse = 1 / np.where(np.abs(rays) < 1e-12, 1e-12, rays)
    inverse = np.ascontiguousarray(inverse.transpose(2, 0, 1))
    eye = np.asarray(pose.position_m)
    depth = np.full(u.shape, np.inf)
    index = np.full(u.shape, -1)
    for number, thing in enumerate(things):
        half, center = np.array(thing.size_m) / 2, np.array(thing.center_m)
        enter, leave = np.full(u.shape, 0.02), depth
        for axis in range(3):
            t0 = (center[axis] - half[axis] - eye[axis]) * inverse[axis]
            t1 = (center[axis] + half[axis] - eye[axis]) * inverse[axis]
            enter = np.maximum(enter, np.minimum(t0, t1))
            leave = np.minimum(leave, np.maximum(t0, t1))
        hit = (enter <= leave) & (enter > 0.02) & (enter < depth)
        depth = np.where(hit, enter, depth)
        index[hit] = number
    return np.where(np.isfinite(depth), depth, 0).astype(np.float32), index


@dataclass(frozen=True)
class Seen:
    """A detection with the number of its thing; -1 is false."""

    box_px: tuple[float, float, float, float]
    graph: ObjectGraph
    thing: int
    score: float = 0.9


@dataclass(frozen=True)
class Frame:
    """One observation."""

    pose: Pose
    depth_m: NDArray[np.float32]
    seen: list[Seen]


def observe(things: list[Thing], pose: Pose) -> Frame:
    """Return what a perfect detector sees."""
    depth, index = render(things, pose)
    seen = []
    for number, thing in enumerate(things):
        rows, columns = np.nonzero(index == number)
        if not thing.name or len(rows) < MIN_VISIBLE_PX:
            continue
        box = (columns.min(), rows.min(), columns.max() + 1, rows.max() + 1)
        if min(box[2] - box[0], box[3] - box[1]) < MIN_SIDE_PX:
            continue
        edges = (float(box[0]), float(box[1]), float(box[2]), float(box[3]))
        seen.append(Seen(edges, ObjectGraph(thing.name, thing.attributes), number))
    return Frame(pose, depth, seen)


def walk(count: int, seed: int = 0, radius_m: float = 2.0, height_m: float = 1.5) -> list[Pose]:
    """Return poses on a ring that look about the middle, horizon 0 or 30."""
    rng = np.random.default_rng(seed)
    poses = []
    for step in range(count):
        angle = 2 * math.pi * step / count
        x, z = radius_m * math.sin(angle), radius_m * math.cos(angle)
        yaw = math.degrees(math.atan2(-x, -z)) + float(rng.uniform(-25, 25))
        poses.append(pose_from_ai2thor((x, height_m, z), yaw, float(rng.choice([0.0, 30.0]))))
    return poses


def shoot(things: list[Thing], poses: list[Pose]) -> list[Frame]:
    """Return all observations."""
    return [observe(things, pose) for pose in poses]


def table(
    center: tuple[float, float], size: tuple[float, float, float] = (1.6, 0.75, 1.0)
) -> Thing:
    """Return a massive table on the floor."""
    return Thing(
        "dining table",
        (center[0], size[1] / 2, center[1]),
        size,
        {"color": "brown", "material": "wood"},
    )


def disturb(
    frames: list[Frame],
    seed: int,
    *,
    shift: bool = False,
    scale: bool = False,
    drop: bool = False,
    false: list[ObjectGraph] | None = None,
) -> list[Frame]:
    """Return frames under the paper's error models E_CS, E_SD, E_FN, E_FP (DESIGN, Evaluation)."""
    rng = np.random.default_rng(seed)
    out = []
    for frame in frames:
        kept = []
        for seen in frame.seen:
            if drop and rng.random() < 0.15:
                continue
            x0, y0, x1, y1 = seen.box_px
            w, h, cx, cy = x1 - x0, y1 - y0, (x0 + x1) / 2, (y0 + y1) / 2
            if shift:
                cx += rng.choice([-1, 1]) * rng.normal(0.2, 0.04) * w
                cy += rng.choice([-1, 1]) * rng.normal(0.2, 0.04) * h
            if scale:
                factor = 1 + rng.choice([-1, 1]) * rng.normal(0.2, 0.04)
                w, h = w * factor, h * factor
            box = np.clip([cx - w / 2, cy - h / 2, cx + w / 2, cy + h / 2], 0, SIZE_PX)
            if box[2] - box[0] >= 3 and box[3] - box[1] >= 3:
                edges = (float(box[0]), float(box[1]), float(box[2]), float(box[3]))
                kept.append(replace(seen, box_px=edges))
        if false and rng.random() < 0.15:
            w, h = rng.uniform(15, 80, 2)
            x, y = rng.uniform(0, SIZE_PX - w), rng.uniform(0, SIZE_PX - h)
            graph = false[int(rng.integers(len(false)))]
            kept.append(Seen((float(x), float(y), float(x + w), float(y + h)), graph, -1))
        out.append(Frame(frame.pose, frame.depth_m, kept))
    return out


def messages(
    frames: list[Frame], episode: str = "e", camera: str = "cam0", **depth: Any
) -> list[tuple[DepthFrame, FrameGraphs]]:
    """Return both halves of each frame."""
    out = []
    for number, frame in enumerate(frames):
        head: dict[str, Any] = {
            "stamp_ns": 1000 + number,
            "episode": episode,
            "camera": camera,
            "frame": number,
            "height_px": SIZE_PX,
            "width_px": SIZE_PX,
        }
        boxes = [
            GraphBox(list(s.box_px), s.score, s.graph, f"a {s.graph.name}") for s in frame.seen
        ]
        image = DepthFrame(
            **head, intrinsics=LENS, pose=frame.pose, data=frame.depth_m.copy(), **depth
        )
        out.append((image, FrameGraphs(**head, detections=boxes)))
    return out
