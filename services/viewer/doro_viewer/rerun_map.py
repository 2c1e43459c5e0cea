"""The map in Rerun: cells by class, floor, path and camera, instances, target.

Everything is drawn in (ground a, ground b, up): right-handed for both worlds, so that the
left-handed ``unity`` world is not shown mirrored.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from doro_schemas import messages as m
from doro_schemas.camera import World, bev_axes
from doro_viewer.colors import graph_color, mix, stable_color
from doro_viewer.grid_state import GridState
from doro_viewer.labels import Label, place
from doro_viewer.rerun_views import MAP, Bounds
from doro_viewer.words import noun_phrase

MARGIN_M = 0.7
SEE_THROUGH_M = 1.3
FLOOR_HEIGHT_M = -0.02
FLOOR = (228, 228, 228)
INK = (40, 40, 40)
PATH = (30, 90, 200)
ACCENT = (230, 0, 120)
VIEW_PX = 560
"""Size of the view that labels are spread for; in a larger one they only lie farther apart."""
_LETTER_PX, _LINE_PX, _MARK_PX = 8, 24, 12
_LEAVES = ("floor", "path", "instances", "labels", "target")


class RerunMap:
    """Draws the map into a recording.

    Args:
        stream: where to.
        world: axes of positions until a depth frame's pose tells.
    """

    def __init__(self, stream: rr.RecordingStream, world: World) -> None:
        self.bounds = Bounds(low_m=(-2.0, -2.0), high_m=(2.0, 2.0))
        self._stream = stream
        self._world: World = world
        self._grid = GridState()
        self._path: list[list[float]] = []
        self._seen: Bounds | None = None
        stream.log(MAP, rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)

    def camera(self, frame: m.DepthFrame) -> None:
        """Draw where the camera is and where it has been."""
        self._world = frame.pose.world
        axes = self._axes()
        position_m = [frame.pose.position_m[axis] for axis in axes]
        self._path.append(position_m)
        path = rr.LineStrips3D([self._path], colors=[PATH], radii=rr.Radius.ui_points(1.5))
        self._stream.log(f"{MAP}/path", path)
        inner = frame.intrinsics
        self._stream.log(
            f"{MAP}/camera/{frame.camera}",
            rr.Transform3D(translation=position_m, mat3x3=frame.pose.matrix()[axes]),
            rr.Pinhole(
                focal_length=(inner.fx, inner.fy),
                principal_point=(inner.cx, inner.cy),
                resolution=(frame.width_px, frame.height_px),
                image_plane_distance=0.35,
                color=PATH,
            ),
        )

    def delta(self, delta: m.GridDelta) -> bool:
        """Draw what changed; return True where :attr:`bounds` grew."""
        if delta.reset:
            self.forget()
        return self._draw_classes(self._grid.apply(delta))

    def snapshot(self, snapshot: m.GridSnapshot) -> bool:
        """Draw the whole map with its floor; return True where :attr:`bounds` grew."""
        grew = self._draw_classes(self._grid.replace(snapshot))
        if len(snapshot.floor):
            ground_m = (snapshot.floor.astype(np.float32) + 0.5) * np.float32(snapshot.cell_m)
            height_m = np.full(len(ground_m), FLOOR_HEIGHT_M, np.float32)
            points = np.column_stack([ground_m, height_m])
            self._stream.log(f"{MAP}/floor", self._points(points, FLOOR))
            grew = self._widen(points) or grew
        return grew

    def forget(self) -> None:
        """Empty the map: a new episode."""
        for name in self._grid.clear():
            self._stream.log([MAP, "grid", name], rr.Clear(recursive=False))
        for leaf in _LEAVES:
            self._stream.log(f"{MAP}/{leaf}", rr.Clear(recursive=True))
        self._path.clear()
        self._seen = None

    def instances(self, reply: m.Instances, query: m.Query | None) -> None:
        """Draw the instances' boxes; those that match the query have thick edges.

        Labels stand beside the boxes, at the end of a line, so that close things can be read.
        """
        axes, found = self._axes(), reply.instances
        matches = query.matches if query else []
        colors = [mix(graph_color(one.graph), INK, 0.3) for one in found]
        centers = np.array(
            [[one.position_m[axis] for axis in axes] for one in found], dtype=np.float64
        ).reshape(-1, 3)
        names = [f"{one.instance_id}: {noun_phrase(one.graph)}" for one in found]
        self._stream.log(
            f"{MAP}/instances",
            rr.Boxes3D(
                centers=centers,
                half_sizes=[[one.extent_m[axis] / 2 for axis in axes] for one in found],
                labels=names,
                colors=colors,
                radii=[0.02 if one.instance_id in matches else 0.008 for one in found],
                show_labels=False,
            ),
        )
        places = self._spread(centers, names)
        self._stream.log(
            f"{MAP}/labels",
            rr.Points3D(places, labels=names, colors=colors, radii=0.01, show_labels=True),
        )
        self._stream.log(
            f"{MAP}/labels/lines",
            rr.LineStrips3D(
                np.stack([centers, places], axis=1), colors=colors, radii=rr.Radius.ui_points(0.8)
            ),
        )

    def target(self, target: m.Target) -> None:
        """Draw the resolved instance."""
        axes = self._axes()
        self._stream.log(
            f"{MAP}/target",
            rr.Boxes3D(
                centers=[[target.position_m[axis] for axis in axes]],
                half_sizes=[[target.extent_m[axis] / 2 + 0.03 for axis in axes]],
                labels=[f"target: {target.instance_id}"],
                colors=[ACCENT],
                radii=[0.02],
            ),
        )

    def _axes(self) -> list[int]:
        return list(bev_axes(self._world))

    def _points(self, centers: NDArray[Any], color: tuple[int, int, int]) -> rr.Points3D:
        # Discs that overlap a little read as areas; what hangs high is dotted, to see below it.
        high = centers[:, 2] > SEE_THROUGH_M
        radii = np.where(high, 0.15, 0.6).astype(np.float32) * np.float32(self._grid.cell_m)
        flat = rr.components.PointShading.Flat
        return rr.Points3D(centers, radii=radii, colors=[color], point_shading=flat)

    def _draw_classes(self, names: list[str]) -> bool:
        grew = False
        for name in names:
            centers = self._grid.centers_m(name)
            self._stream.log([MAP, "grid", name], self._points(centers, stable_color(name)))
            grew = self._widen(centers) or grew
        return grew

    def _widen(self, points: NDArray[Any]) -> bool:
        """Note what is on the map; return True where the view has to show more.

        That is seldom, because a new view undoes the person's own zooming.
        """
        if not len(points):
            return False
        low, high = points[:, :2].min(axis=0).tolist(), points[:, :2].max(axis=0).tolist()
        first = self._seen is None
        known = self._seen or Bounds(low_m=(low[0], low[1]), high_m=(high[0], high[1]))
        lows = [min(a, b) for a, b in zip(known.low_m, low, strict=True)]
        highs = [max(a, b) for a, b in zip(known.high_m, high, strict=True)]
        self._seen = Bounds(low_m=(lows[0], lows[1]), high_m=(highs[0], highs[1]))
        if not first and self.bounds.covers(self._seen):
            return False
        self.bounds = self._seen.grown(MARGIN_M)
        return True

    def _spread(self, centers: NDArray[np.float64], names: list[str]) -> NDArray[np.float64]:
        """Return where labels stand, (n, 3) metres, so that they do not hide each other."""
        low = np.array(self.bounds.low_m)
        span_m = float((np.array(self.bounds.high_m) - low).max())
        px_per_m = VIEW_PX / span_m
        obstacles = np.zeros((VIEW_PX, VIEW_PX), dtype=np.uint8)
        labels = []
        for center, name in zip(centers, names, strict=True):
            x, y = ((center[:2] - low) * px_per_m).round().clip(0, VIEW_PX).astype(int).tolist()
            half = _MARK_PX // 2
            anchor = (x - half, y - half, x + half, y + half)
            obstacles[max(0, y - half) : y + half, max(0, x - half) : x + half] = 250
            width_px = min(_LETTER_PX * len(name), VIEW_PX - 1)
            labels.append(Label(width_px=width_px, height_px=_LINE_PX, anchor=anchor))
        places = centers.copy()
        area = (0, 0, VIEW_PX, VIEW_PX)
        for number, (box, _) in enumerate(place(labels, obstacles, area)):
            middle = np.array([(box[0] + box[2]) / 2, (box[1] + box[3]) / 2])
            places[number, :2] = low + middle / px_per_m
        return places
