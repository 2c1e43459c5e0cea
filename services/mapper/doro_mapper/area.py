"""All that is known of one episode's area: views, hash maps, coverage, instances."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from doro_mapper.boxes import Boxes, distance, iou
from doro_mapper.coverage import Coverage
from doro_mapper.finder import Found, InstanceFinder, Sighting, names_agree
from doro_mapper.hashmaps import HashMaps
from doro_mapper.projection import Samples, measure
from doro_mapper.regions import RegionFinder
from doro_mapper.settings import MapperSettings
from doro_mapper.tracks import TrackFinder
from doro_mapper.views import Camera, Views, camera_of
from doro_schemas.messages import DepthFrame, FrameGraphs, GraphBox, GraphEntry
from doro_schemas.vocabulary import name_satisfies

SAME_PLACE = 0.5


@dataclass(frozen=True, slots=True)
class Change:
    """What one frame changed, as :class:`GridDelta` has it."""

    new_graphs: list[GraphEntry]
    cells: NDArray[np.int32]
    weights: NDArray[np.float32]


class Area:
    """The map of one episode."""

    def __init__(self, settings: MapperSettings) -> None:
        self._settings = settings
        self.views = Views(settings.max_views)
        self.maps = HashMaps(settings.cell_m, settings.band_m, settings.max_cells)
        self.coverage = Coverage(settings.cell_m, settings.coverage_cell_m, settings.max_depth_m)
        self.finder: InstanceFinder = (
            TrackFinder(settings, self.views)
            if settings.finder == "tracks"
            else RegionFinder(settings, self.views, self.maps)
        )
        self._digest: str | None = None

    def merge(self, depth: DepthFrame, graphs: FrameGraphs, counters: dict[str, int]) -> Change:
        """Merge one frame: measure its detections, fill the hash maps, tell the finder."""
        self._digest = None
        depth_m = depth.depth_m()
        camera = _camera(depth)
        serial = self.views.add(camera, depth_m)
        self.coverage.add(depth_m, camera, depth.pose)
        measured = self._measured(depth, depth_m, graphs, serial, counters)
        kept = without_duplicates(measured, self._settings.duplicate_iou)
        counters["detections_duplicate"] += len(measured) - len(kept)
        counters["detections_merged"] += len(kept)
        first_new = len(self.maps.graphs)
        cells = [(self.maps.graph_id(sighting.graph)[0], samples) for sighting, samples in kept]
        rows = self.maps.merge(cells, self.views, serial)
        self.finder.add(serial, [sighting for sighting, _ in kept])
        counters["cells_dropped"] = self.maps.cells_dropped
        return Change(self.maps.entries(first_new), *self.maps.published(rows))

    def _measured(
        self,
        depth: DepthFrame,
        depth_m: NDArray[np.float32],
        graphs: FrameGraphs,
        serial: int,
        counters: dict[str, int],
    ) -> list[tuple[Sighting, Samples]]:
        """Measure all detections; count those that cannot be."""
        options = self._settings
        camera = _camera(depth)
        out = []
        for box in graphs.detections:
            edges = _clipped(box, depth.width_px, depth.height_px)
            if min(edges[2] - edges[0], edges[3] - edges[1]) < options.min_box_px:
                counters["detections_too_small"] += 1
                continue
            measured = measure(
                depth_m,
                list(edges),
                camera,
                depth.pose,
                sigma=options.sigma,
                samples=options.samples,
                max_depth_m=options.max_depth_m,
            )
            if measured is None:
                counters["detections_without_depth"] += 1
                continue
            place, samples = measured
            sighting = Sighting(
                serial, depth.camera, depth.frame, edges, box.score, box.caption, box.graph, place
            )
            out.append((sighting, samples))
        return out

    def find(self) -> list[Found]:
        """Return all instances as of now."""
        return self.finder.find()

    def digest(self) -> str:
        """Return the digest of graphs and cells."""
        if self._digest is None:
            self._digest = self.maps.digest()
        return self._digest

    def snapshot(
        self, name: str
    ) -> tuple[list[GraphEntry], NDArray[np.int32], NDArray[np.float32]]:
        """Return graphs, cells and weights of a class and its kinds; of all for no name."""
        if not name:
            return self.maps.entries(), *self.maps.published()
        entries = [e for e in self.maps.entries() if name_satisfies(name, e.graph.name)]
        rows = self.maps.rows_of([entry.graph_id for entry in entries])
        return entries, *self.maps.published(rows)


def _camera(depth: DepthFrame) -> Camera:
    return camera_of(depth.intrinsics, depth.pose, (depth.width_px, depth.height_px))


def _clipped(box: GraphBox, width_px: int, height_px: int) -> tuple[float, float, float, float]:
    """Return the box inside the image (the wire tolerates half a pixel)."""
    xmin, ymin, xmax, ymax = box.box_px
    return max(0.0, xmin), max(0.0, ymin), min(float(width_px), xmax), min(float(height_px), ymax)


def without_duplicates(
    measured: list[tuple[Sighting, Any]], most_iou: float
) -> list[tuple[Sighting, Any]]:
    """Drop boxes of one class that nearly coincide in image and space; the higher score stays.

    Detections of one frame are different things to the finder (cannot-link), so a detector's
    double boxes would become double instances. Order is kept.
    """
    ranking = sorted(range(len(measured)), key=lambda i: (-measured[i][0].score, i))
    kept: list[int] = []
    for i in ranking:
        if not any(_same(measured[i][0], measured[j][0], most_iou) for j in kept):
            kept.append(i)
    return [measured[i] for i in sorted(kept)]


def _same(a: Sighting, b: Sighting, most_iou: float) -> bool:
    if not names_agree(a.graph.name, b.graph.name) or iou(a.box_px, b.box_px) < most_iou:
        return False
    boxes = [Boxes(p.center_m[None], p.low_m[None], p.high_m[None]) for p in (a.place, b.place)]
    gap = distance(boxes[0], boxes[1], np.array([a.place.range_m]))
    return bool(gap[0, 0] < SAME_PLACE)
