"""A ConceptGraphs-like association, to compare with: time and counts on the same detections.

Written from the published method (Gu et al., "ConceptGraphs: Open-Vocabulary 3D Scene Graphs
for Perception and Planning", 2023, Section III-A): each detection becomes a point cloud, thinned
by voxels and cleaned of what does not hang together; it joins the object of greatest geometric
plus semantic similarity, or founds one; overlapping objects are merged now and then; objects of
too few views are dropped. Geometric similarity is the share of the detection's points with a
point of the object nearby; semantic similarity is that of the graphs (class and attributes)
in place of CLIP's and DINO's, as there are only names here. Masks are boxes, as our detections
have no others.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from doro_evaluation.outcomes import CLASS_OF_NAME, Thing
from doro_schemas.graph import ObjectGraph
from doro_schemas.messages import DepthFrame, FrameGraphs, GraphBox

VOXEL_M = 0.04
"""Size to which clouds are thinned; "nearby" is within one voxel."""
SIMILARITY = 1.1
"""Least sum of geometric (0..1) and semantic (0..1) similarity that joins."""
MERGE_OVERLAP = 0.7
MERGE_EVERY = 20
MIN_VIEWS = 3
SAMPLES = 40
"""Pixels looked at per side of a box."""
OFFSET, BASE = 2048, 4096
Voxels = NDArray[np.int64]
NEIGHBOURS = np.array([(a, b, c) for a in (-1, 0, 1) for b in (-1, 0, 1) for c in (-1, 0, 1)])


@dataclass
class MapObject:
    """An object of the map: voxels with counts, graph votes, frames."""

    graph: ObjectGraph
    voxels: Voxels
    counts: NDArray[np.int64]
    frames: list[int] = field(default_factory=list)
    near: Voxels | None = None

    def add(self, voxels: Voxels, counts: NDArray[np.int64], frames: list[int]) -> None:
        """Take another cloud into this one."""
        both, place = np.unique(np.concatenate([self.voxels, voxels]), return_inverse=True)
        weights = np.concatenate([self.counts, counts]).astype(np.float64)
        self.counts = np.bincount(place, weights=weights).astype(np.int64)
        self.voxels, self.near = both, None
        self.frames += frames

    def overlap(self, voxels: Voxels) -> float:
        """Return the share of voxels that are, or are next to, voxels of this object."""
        if self.near is None:
            grown = decode(self.voxels)[:, None] + NEIGHBOURS[None]
            self.near = np.unique(encode(grown.reshape(-1, 3)))
        place = np.minimum(np.searchsorted(self.near, voxels), len(self.near) - 1)
        return float((self.near[place] == voxels).mean())


class ConceptGraphsLike:
    """Associates detections online; one frame after the other."""

    def __init__(self) -> None:
        self.objects: list[MapObject] = []
        self._frames = 0

    def add(self, depth: DepthFrame, graphs: FrameGraphs) -> None:
        """Take the detections of a frame."""
        image = depth.depth_m()
        for box in graphs.detections:
            voxels = cloud(image, depth, box)
            if len(voxels):
                self._associate(box.graph, voxels)
        self._frames += 1
        if self._frames % MERGE_EVERY == 0:
            self._merge()

    def things(self) -> tuple[Thing, ...]:
        """Return the objects of the evaluated classes that enough frames saw."""
        self._merge()
        found = []
        for item in self.objects:
            kind = CLASS_OF_NAME.get(item.graph.name)
            if kind is not None and len(set(item.frames)) >= MIN_VIEWS:
                low, high = self._box(item)
                center, size = (low + high) / 2, high - low
                found.append(Thing(kind, _three(center), _three(size), len(set(item.frames))))
        return tuple(found)

    def _associate(self, graph: ObjectGraph, voxels: Voxels) -> None:
        best, score = None, SIMILARITY
        for item in self.objects:
            semantic = similarity(item.graph, graph)
            if semantic + 1.0 <= score:
                continue
            total = semantic + item.overlap(voxels)
            if total > score:
                best, score = item, total
        counts = np.ones(len(voxels), np.int64)
        if best is None:
            self.objects.append(MapObject(graph, voxels, counts, [self._frames]))
        else:
            best.add(voxels, counts, [self._frames])

    def _merge(self) -> None:
        """Merge overlapping objects of like meaning, the smaller into the larger."""
        order = sorted(self.objects, key=lambda item: -len(item.voxels))
        kept: list[MapObject] = []
        for item in order:
            for other in kept:
                like = similarity(other.graph, item.graph)
                if like >= SIMILARITY - 0.5 and other.overlap(item.voxels) > MERGE_OVERLAP:
                    other.add(item.voxels, item.counts, item.frames)
                    break
            else:
                kept.append(item)
        self.objects = kept

    @staticmethod
    def _box(item: MapObject) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the box of the voxels that a quarter of the most seen one's views share."""
        often = item.counts >= 0.25 * item.counts.max()
        points = (decode(item.voxels[often]) + 0.5) * VOXEL_M
        return points.min(axis=0), points.max(axis=0)


def count_like_conceptgraphs(
    depths: Sequence[DepthFrame], graphs: Sequence[FrameGraphs]
) -> tuple[Thing, ...]:
    """Return the instances of the evaluated classes after all frames."""
    association = ConceptGraphsLike()
    for depth, graph in zip(depths, graphs, strict=True):
        association.add(depth, graph)
    return association.things()


def similarity(a: ObjectGraph, b: ObjectGraph) -> float:
    """Return 0 for other classes, 1 for equal graphs, less where attributes differ."""
    if a.name != b.name:
        return 0.0
    kinds = sorted(a.attributes.keys() | b.attributes.keys())
    if not kinds:
        return 1.0
    same = sum(a.attributes.get(kind) == b.attributes.get(kind) for kind in kinds)
    return 0.5 + 0.5 * same / len(kinds)


def cloud(image: NDArray[np.float32], depth: DepthFrame, box: GraphBox) -> Voxels:
    """Return the voxels of a box, sorted: its largest piece that hangs together."""
    rows, columns = image.shape
    left, top = max(0, int(box.box_px[0])), max(0, int(box.box_px[1]))
    right = min(columns, int(np.ceil(box.box_px[2])))
    bottom = min(rows, int(np.ceil(box.box_px[3])))
    step_u = max(1, -((left - right) // SAMPLES))
    step_v = max(1, -((top - bottom) // SAMPLES))
    patch = image[top:bottom:step_v, left:right:step_u]
    v, u = np.nonzero(patch > 0)
    if len(v) < 5:
        return np.zeros(0, np.int64)
    z = patch[v, u].astype(np.float64)
    lens = depth.intrinsics
    x = (left + u * step_u + 0.5 - lens.cx) / lens.fx * z
    y = (top + v * step_v + 0.5 - lens.cy) / lens.fy * z
    pose = depth.pose
    points = np.stack([x, y, z], axis=1) @ pose.matrix().T + np.asarray(pose.position_m)
    cells = np.unique(encode(np.floor(points / VOXEL_M).astype(np.int64)))
    return _largest_piece(cells)


def encode(cells: Voxels) -> Voxels:
    """Return one number per voxel (n, 3)."""
    shifted = cells + OFFSET
    numbers: Voxels = (shifted[:, 0] * BASE + shifted[:, 1]) * BASE + shifted[:, 2]
    return numbers


def decode(numbers: Voxels) -> Voxels:
    """Return the voxels (n, 3) of their numbers."""
    first, third = np.divmod(numbers, BASE)
    cells: Voxels = np.stack([first // BASE, first % BASE, third], axis=1) - OFFSET
    return cells


def _largest_piece(numbers: Voxels) -> Voxels:
    """Drop what is not connected in plan: a cheap stand-in for DBSCAN."""
    cells = decode(numbers)
    low = cells.min(axis=0)
    shape = cells.max(axis=0) - low + 3
    if shape[0] * shape[2] > 1 << 22:
        return numbers
    plan = np.zeros((int(shape[0]), int(shape[2])), np.uint8)
    plan[cells[:, 0] - low[0] + 1, cells[:, 2] - low[2] + 1] = 1
    grown = cv2.dilate(plan, np.ones((3, 3), np.uint8))
    _, labels = cv2.connectedComponents(grown, connectivity=8)
    own = labels[cells[:, 0] - low[0] + 1, cells[:, 2] - low[2] + 1]
    kept: Voxels = numbers[own == np.bincount(own).argmax()]
    return kept


def _three(values: NDArray[np.float64]) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in values)
    return (x, y, z)
