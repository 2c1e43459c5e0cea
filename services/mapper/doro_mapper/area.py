"""All that is known of one episode's area: views, hash maps, coverage, instances."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from doro_mapper.boxes import Boxes, distance, ious
from doro_mapper.finder import Found, InstanceFinder, TrackSummary, evidence_weight, names_agree
from doro_mapper.finders import make_finder
from doro_mapper.maps.cells import Ints
from doro_mapper.maps.coverage import Coverage
from doro_mapper.maps.hashmaps import HashMaps
from doro_mapper.naming import NameMemory
from doro_mapper.projection import Measured, measure
from doro_mapper.settings import MapperSettings
from doro_mapper.shots import Shot, shot
from doro_mapper.sightings import FrameSightings, Sighting
from doro_mapper.unnamed import Place, UnnamedPlaces
from doro_mapper.views import Floats, Views, camera_of
from doro_schemas.camera import Pose
from doro_schemas.messages import DepthFrame, FrameGraphs, GraphBox, GraphEntry, UnnamedRegion
from doro_schemas.vocabulary import name_satisfies

SAME_PLACE = 0.5
BY_DETECTION = (
    "index",
    "box_px",
    "center_m",
    "low_m",
    "high_m",
    "outer_low_m",
    "outer_high_m",
    "points_m",
    "range_m",
    "size_m",
    "area_share",
    "at_border",
)


@dataclass(frozen=True, slots=True)
class Change:
    """What one frame changed, as :class:`GridDelta` has it."""

    new_graphs: list[GraphEntry]
    cells: NDArray[np.int32]
    weights: NDArray[np.float32]
    blocks: NDArray[np.int32]


@dataclass(frozen=True, slots=True)
class Snapshot:
    """The map, as :class:`GridSnapshot` has it."""

    graphs: list[GraphEntry]
    cells: NDArray[np.int32]
    weights: NDArray[np.float32]
    blocks: NDArray[np.int32]
    regions: NDArray[np.int32]
    region_scores: NDArray[np.float32]


class Area:
    """The map of one episode."""

    def __init__(self, settings: MapperSettings) -> None:
        self._settings = settings
        self._names = NameMemory()
        self._unnamed = UnnamedPlaces()
        self.views = Views(settings.max_views)
        self.maps = HashMaps(settings.cell_m, settings.band_m, settings.max_cells)
        self.coverage = Coverage(settings.cell_m, settings.coverage_cell_m, settings.max_depth_m)
        self.finder: InstanceFinder = make_finder(settings, self.views, self.maps)
        self._serials: dict[tuple[str, int], int] = {}
        self._shots: dict[int, Shot] = {}
        self._digest: str | None = None

    def merge(self, depth: DepthFrame, graphs: FrameGraphs, counters: dict[str, int]) -> Change:
        """Merge one frame: measure its detections, fill the hash maps, tell the finder."""
        self._digest = None
        depth_m = depth.depth_m()
        camera = camera_of(depth.intrinsics, depth.pose, (depth.width_px, depth.height_px))
        serial = self.views.add(camera, depth_m)
        self._remember(depth.camera, depth.frame, serial)
        self.coverage.add(self.views.thumb_m(serial), camera)
        frame = self._sighted(depth, depth_m, graphs, counters)
        if graphs.unnamed:
            edges = _clipped(graphs.unnamed, depth.width_px, depth.height_px)
            self._unnamed.add(serial, self._measured(depth_m, edges))
        first_new = len(self.maps.graphs)
        ids = [self.maps.graph_id(sighting.graph)[0] for sighting in frame.sightings]
        m = frame.measured
        samples = (m.sample_points_m, m.sample_weights, m.sample_of)
        (cells, weights), blocks = self.maps.merge(ids, samples, self.views, serial)
        self._shots[serial] = shot(ids, m, camera, self.maps.last_mass)
        self._shots.pop(serial - self._settings.max_views, None)
        self.finder.add(frame)
        counters["cells_dropped"] = self.maps.cells_dropped
        return Change(self.maps.entries(first_new), cells, weights, blocks)

    def _remember(self, camera: str, frame: int, serial: int) -> None:
        self._serials[(camera, frame)] = serial
        if len(self._serials) > self._settings.max_views:
            del self._serials[next(iter(self._serials))]

    def _sighted(
        self,
        depth: DepthFrame,
        depth_m: NDArray[np.float32],
        graphs: FrameGraphs,
        counters: dict[str, int],
    ) -> FrameSightings:
        """Measure all detections; count those that cannot be, and those that are double.

        The frame's view has been added.
        """
        options, serial = self._settings, self.views.total - 1
        boxes = _clipped(graphs.detections, depth.width_px, depth.height_px)
        large = np.flatnonzero((boxes[:, 2:] - boxes[:, :2]).min(axis=1) >= options.min_box_px)
        counters["detections_too_small"] += len(boxes) - len(large)
        measured = self._measured(depth_m, boxes[large])
        counters["detections_without_depth"] += len(large) - len(measured)
        own = [graphs.detections[int(large[k])] for k in measured.index.tolist()]
        kept = without_duplicates(own, measured, options.duplicate_iou)
        counters["detections_duplicate"] += len(own) - len(kept)
        counters["detections_merged"] += len(kept)
        if len(kept) < len(own):
            own, measured = [own[k] for k in kept], _chosen(measured, kept)
        if options.fuse_names:
            own = self._names.fused(own, measured)
        sightings = [self._sighting(box, k, measured, serial, depth) for k, box in enumerate(own)]
        if graphs.calibrated:
            sightings = [
                replace(one, doubt=1.0 - one.score) if len(one.classes) > 1 else one
                for one in sightings
            ]
        return FrameSightings(serial, depth.camera, depth.frame, sightings, measured)

    def _measured(self, depth_m: NDArray[np.float32], boxes_px: Floats) -> Measured:
        """Return where boxes of the latest view are."""
        options = self._settings
        return measure(
            depth_m,
            boxes_px,
            self.views.camera(self.views.total - 1),
            sigma=options.sigma,
            samples=options.samples,
            max_depth_m=options.max_depth_m,
        )

    def _sighting(
        self, box: GraphBox, k: int, measured: Measured, serial: int, depth: DepthFrame
    ) -> Sighting:
        weight = evidence_weight(
            box.score,
            float(measured.area_share[k]),
            float(measured.range_m[k]),
            bool(measured.at_border[k]),
        )
        return Sighting(
            serial,
            depth.camera,
            depth.frame,
            tuple(measured.box_px[k].tolist()),
            box.score,
            box.caption,
            box.graph,
            tuple(box.classes),
            weight,
        )

    def correct(
        self, camera: str, frames: list[int], poses: list[Pose]
    ) -> tuple[int, Change | None]:
        """Put frames where corrected poses say that they were taken.

        Instances follow from the measurements kept; the hash maps are built again from
        12 points kept of each detection, coverage from the thumbnails.

        Returns:
            How many of the frames are known, and what that changed in the map.
        """
        known = 0
        for frame, pose in zip(frames, poses, strict=True):
            serial = self._serials.get((camera, frame))
            if serial is not None and serial >= self.views.oldest:
                old = self.views.camera(serial)
                new = camera_of(old.intrinsics, pose, old.size_px)
                self.finder.move(serial, old, new)
                self._unnamed.move(serial, old, new)
                self.views.place(serial, new)
                known += 1
        if not known:
            return 0, None
        self._digest = None
        self.finder.moved()
        options = self._settings
        self.coverage = Coverage(options.cell_m, options.coverage_cell_m, options.max_depth_m)
        for serial in range(self.views.oldest, self.views.total):
            self.coverage.add(self.views.thumb_m(serial), self.views.camera(serial))
        cells, weights = self.maps.rebuild(self._shots, self.views)
        return known, Change([], cells, weights, self.maps.blocks.published())

    def lost(self) -> list[str]:
        """Return ids that were given to things forgotten since."""
        return self.finder.lost()

    def tracks(self) -> list[TrackSummary]:
        """Return what is being tracked."""
        return self.finder.tracks()

    def find(self) -> list[Found]:
        """Return all instances as of now."""
        return self.finder.find()

    def unnamed(self, found: list[Found]) -> list[Place]:
        """Return where something is that has no name and is no part of what was found."""
        return self._unnamed.places(found)

    def digest(self) -> str:
        """Return the digest of graphs and cells."""
        if self._digest is None:
            self._digest = self.maps.digest()
        return self._digest

    def snapshot(self, name: str) -> Snapshot:
        """Return graphs, cells and scores of a class and its kinds; of all for no name."""
        entries = [
            entry
            for entry in self.maps.entries()
            if not name or name_satisfies(name, entry.graph.name)
        ]
        cells, weights = self.maps.published([entry.graph_id for entry in entries])
        side = max(1, round(self._settings.region_m / self._settings.cell_m))
        regions, scores = region_scores(cells, weights, side)
        return Snapshot(entries, cells, weights, self.maps.blocks.published(), regions, scores)


def region_scores(
    cells: NDArray[np.int32], weights: NDArray[np.float32], side: int
) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    """Return regions int32 (k, 3) graph, a, b and the paper's occupancy scores O(R), (k,).

    Sums of weights over the cells of a region, normalised by graph.

    Args:
        side: cells along the edge of a region.
    """
    places = np.column_stack([cells[:, 0], cells[:, 1] // side, cells[:, 2] // side])
    regions, inverse = np.unique(places, axis=0, return_inverse=True)
    sums = np.bincount(inverse.ravel(), weights, minlength=len(regions))
    whole = np.bincount(regions[:, 0], sums) if len(regions) else np.zeros(0)
    scores = sums / np.maximum(whole[regions[:, 0]], 1e-12) if len(regions) else sums
    return regions.astype(np.int32).reshape(-1, 3), scores.astype(np.float32)


def _clipped(
    detections: Sequence[GraphBox | UnnamedRegion], width_px: int, height_px: int
) -> Floats:
    """Return the boxes inside the image (the wire tolerates half a pixel), (n, 4)."""
    boxes = np.array([box.box_px for box in detections], dtype=np.float64).reshape(-1, 4)
    return np.clip(boxes, 0.0, np.array([width_px, height_px, width_px, height_px], float))


def _chosen(measured: Measured, kept: list[int]) -> Measured:
    """Return some of the measurements, in order."""
    rows: Ints = np.array(kept, dtype=np.int64)
    place = np.full(len(measured), -1)
    place[rows] = np.arange(len(rows))
    own = place[measured.sample_of] >= 0
    return replace(
        measured,
        **{name: getattr(measured, name)[rows] for name in BY_DETECTION},
        sample_points_m=measured.sample_points_m[own],
        sample_weights=measured.sample_weights[own],
        sample_of=place[measured.sample_of][own],
    )


def without_duplicates(own: list[GraphBox], measured: Measured, most_iou: float) -> list[int]:
    """Return which detections stay where boxes of one thing nearly coincide in image and space.

    Detections of one frame are different things to the finder (cannot-link), so a detector's
    double boxes would become double instances. The higher score stays. Two boxes are of one
    thing when their classes agree, or when one's class is among those that the other's
    detector thought possible.
    """
    overlap = ious(measured.box_px)
    np.fill_diagonal(overlap, 0.0)
    if not (overlap >= most_iou).any():
        return list(range(len(own)))
    boxes = Boxes(measured.center_m, measured.low_m, measured.high_m)
    same = (overlap >= most_iou) & (distance(boxes, boxes, measured.range_m) < SAME_PLACE)
    kept: list[int] = []
    for i in sorted(range(len(own)), key=lambda i: (-own[i].score, i)):
        if not any(same[i, j] and _one_class(own[i], own[j]) for j in kept):
            kept.append(i)
    return sorted(kept)


def _one_class(a: GraphBox, b: GraphBox) -> bool:
    names = [{box.graph.name, *(one.name for one in box.classes)} for box in (a, b)]
    return names_agree(a.graph.name, b.graph.name) or (
        a.graph.name in names[1] or b.graph.name in names[0]
    )
