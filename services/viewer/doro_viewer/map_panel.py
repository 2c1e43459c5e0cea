"""The map itself: cells, path, instances, axes and scale bar on a canvas."""

from __future__ import annotations

import math
from collections.abc import Iterator

import cv2
import msgspec
import numpy as np
from numpy.typing import NDArray

from doro_schemas.camera import World, bev_axes
from doro_schemas.graph import identity
from doro_schemas.messages import GridSnapshot, Instance
from doro_viewer.colors import Rgb, graph_color, mix, stable_color
from doro_viewer.grid_state import solid
from doro_viewer.labels import Box
from doro_viewer.lettering import Canvas, Style, line, rectangle, text_width_px, write
from doro_viewer.words import noun_phrase

FLOOR: Rgb = (229, 229, 229)
OTHER: Rgb = (200, 200, 200)
INK: Rgb = (45, 45, 45)
FAINT: Rgb = (150, 150, 150)
PATH: Rgb = (30, 90, 200)
START: Rgb = (0, 130, 60)
AXIS_NAMES = {"unity": ("x", "z"), "ros": ("x", "y")}
MARGIN_M = 0.4
MIN_SPAN_M = 2.0
MIN_BOX_PX = 9
SMALL = Style(scale=0.42, color=(110, 110, 110))


class Frame(msgspec.Struct, frozen=True):
    """Where the ground lies in the picture: the first axis to the right, the second up."""

    box: Box
    low_m: tuple[float, float]
    px_per_m: float

    def pixels(self, ground_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return pixel positions (n, 2) of ground points (n, 2) in metres."""
        x = self.box[0] + (ground_m[:, 0] - self.low_m[0]) * self.px_per_m
        y = self.box[3] - (ground_m[:, 1] - self.low_m[1]) * self.px_per_m
        return np.stack([x, y], axis=1)

    def rectangle(self, low_m: NDArray[np.float64], high_m: NDArray[np.float64]) -> Box:
        """Return the pixel rectangle of a ground rectangle."""
        (left, bottom), (right, top) = self.pixels(np.stack([low_m, high_m])).round().tolist()
        return int(left), int(top), int(right), int(bottom)


class Region(msgspec.Struct, frozen=True):
    """Cells of one kind: int32 (n, 2), their share of the strongest, 0..1, name and colour."""

    name: str
    color: Rgb
    cells: NDArray[np.int32]
    strength: NDArray[np.float64]


def ground_box(instance: Instance, world: World) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return (low, high) of an instance on the ground, metres."""
    axes = list(bev_axes(world)[:2])
    center = np.asarray(instance.position_m, dtype=np.float64)[axes]
    half = np.asarray(instance.extent_m, dtype=np.float64)[axes] / 2
    return center - half, center + half


def frame_for(
    snapshot: GridSnapshot, instances: list[Instance], world: World, width: int, limit: Box
) -> Frame:
    """Return the frame that shows everything, as large as fits ``limit``, centred.

    ``width`` is the width that the map may take inside ``limit``.
    """
    cell_m = snapshot.cell_m
    ground = np.concatenate([snapshot.floor[:, :2], snapshot.cells[:, 1:3]]).astype(np.float64)
    points = [ground * cell_m, (ground + 1) * cell_m, snapshot.path_m.astype(np.float64)]
    for instance in instances:
        points.append(np.stack(ground_box(instance, world)))
    every = np.concatenate([part.reshape(-1, 2) for part in points])
    if not len(every):
        every = np.zeros((1, 2))
    low, high = every.min(axis=0) - MARGIN_M, every.max(axis=0) + MARGIN_M
    slack = np.maximum(0.0, MIN_SPAN_M - (high - low)) / 2
    low, high = low - slack, high + slack
    span = high - low
    px_per_m = float(min(width / span[0], (limit[3] - limit[1]) / span[1]))
    extra = (np.array([limit[2] - limit[0], limit[3] - limit[1]]) / px_per_m - span) / 2
    low -= extra
    return Frame(box=limit, low_m=(float(low[0]), float(low[1])), px_per_m=px_per_m)


def regions(snapshot: GridSnapshot, wanted: set[str], *, by_class: bool = False) -> list[Region]:
    """Return the cells of each kind of graph whose class is wanted, height bands added up.

    A kind is class and self attributes, or, ``by_class``, the class alone. Where several
    kinds share a cell, it belongs to the one with the most weight there. Cells that were
    seldom seen are left out. In the order of their text.
    """
    graphs = {entry.graph_id: entry.graph for entry in snapshot.graphs}
    often = solid(snapshot.cells)
    looks: dict[str, tuple[str, Rgb]] = {}
    sums: dict[tuple[int, int], dict[str, float]] = {}
    cells, weights = snapshot.cells[often].tolist(), snapshot.weights[often].tolist()
    for (graph_id, a, b, *_), weight in zip(cells, weights, strict=True):
        graph = graphs.get(graph_id)
        if graph is None or graph.name not in wanted:
            continue
        key = graph.name if by_class else identity(graph)
        if key not in looks:
            color = stable_color(key) if by_class else graph_color(graph)
            looks[key] = (graph.name if by_class else noun_phrase(graph), color)
        shares = sums.setdefault((a, b), {})
        shares[key] = shares.get(key, 0.0) + weight
    owned: dict[str, dict[tuple[int, int], float]] = {}
    for cell in sorted(sums):
        key, weight = max(sorted(sums[cell].items()), key=lambda item: item[1])
        owned.setdefault(key, {})[cell] = weight
    return [_region(*looks[key], owned[key]) for key in sorted(owned)]


def _region(name: str, color: Rgb, owned: dict[tuple[int, int], float]) -> Region:
    strength = np.array(list(owned.values()), dtype=np.float64)
    strength = (strength / max(float(strength.max()), 1e-9)).clip(0, 1)
    return Region(name, color, np.array(list(owned), dtype=np.int32), strength)


def draw_ground(canvas: Canvas, frame: Frame, snapshot: GridSnapshot) -> None:
    """Draw what was observed: floor, and cells of all things, one gray each."""
    fill_cells(canvas, frame, snapshot.floor[:, :2], snapshot.cell_m, FLOOR)
    things = snapshot.cells[solid(snapshot.cells)]
    fill_cells(canvas, frame, things[:, 1:3], snapshot.cell_m, OTHER)


def fill_cells(
    canvas: Canvas, frame: Frame, cells: NDArray[np.int32], cell_m: float, color: Rgb
) -> None:
    """Fill ground cells with one colour."""
    for box in cell_boxes(frame, cells, cell_m):
        rectangle(canvas, box, color, -1)


def cell_boxes(frame: Frame, cells: NDArray[np.int32], cell_m: float) -> Iterator[Box]:
    """Yield the pixel rectangle of each cell, neighbours without a gap."""
    if not len(cells):
        return
    low = frame.pixels(cells.astype(np.float64) * cell_m).round().astype(int)
    high = frame.pixels((cells.astype(np.float64) + 1) * cell_m).round().astype(int)
    for (left, bottom), (right, top) in zip(low.tolist(), high.tolist(), strict=True):
        yield left, top, max(left, right - 1), max(top, bottom - 1)


def draw_region(canvas: Canvas, frame: Frame, region: Region, cell_m: float, share: float) -> None:
    """Draw a region in its colour, weak cells paler.

    ``share`` is how much of the colour the strongest cell shows over gray; a region that is
    shown in full gets an outline.
    """
    color = region.color
    mask = np.zeros(canvas.shape[:2], dtype=np.uint8)
    boxes = cell_boxes(frame, region.cells, cell_m)
    for box, strength in zip(boxes, region.strength.tolist(), strict=True):
        rectangle(canvas, box, mix(OTHER, color, share * (0.4 + 0.6 * strength)), -1)
        left, top, right, bottom = box
        mask[top : bottom + 1, left : right + 1] = 255
    if share < 1.0:
        return
    outlines = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[0]
    cv2.drawContours(canvas, outlines, -1, mix(color, INK, 0.45), 1)


def draw_path(canvas: Canvas, frame: Frame, path_m: NDArray[np.float32]) -> None:
    """Draw the way of the camera and where it began."""
    if not len(path_m):
        return
    points = frame.pixels(path_m.astype(np.float64))
    line(canvas, points, PATH, 1)
    x, y = points[0].round().astype(int).tolist()
    draw_start(canvas, x, y)


def draw_start(canvas: Canvas, x: int, y: int) -> None:
    """Draw the start marker."""
    triangle = np.array([[x - 7, y + 6], [x + 7, y + 6], [x, y - 8]], dtype=np.int32)
    cv2.fillPoly(canvas, [triangle], START, cv2.LINE_AA)
    cv2.polylines(canvas, [triangle], True, (255, 255, 255), 1, cv2.LINE_AA)


def instance_box(frame: Frame, instance: Instance, world: World) -> Box:
    """Return an instance's pixel rectangle, never smaller than can be seen."""
    left, top, right, bottom = frame.rectangle(*ground_box(instance, world))
    wide, high = max(0, MIN_BOX_PX - (right - left)), max(0, MIN_BOX_PX - (bottom - top))
    return left - wide // 2, top - high // 2, right + (wide + 1) // 2, bottom + (high + 1) // 2


def draw_axes(canvas: Canvas, frame: Frame, world: World) -> None:
    """Draw the panel's edge, ticks at round metres, the axes' names and the scale bar."""
    left, top, right, bottom = frame.box
    rectangle(canvas, frame.box, FAINT, 1)
    for axis, start, end in ((0, left, right), (1, bottom, top)):
        low_m = frame.low_m[axis]
        span_m = abs(end - start) / frame.px_per_m
        step_m = _tick_step_m(span_m)
        for number in range(math.ceil(low_m / step_m), math.floor((low_m + span_m) / step_m) + 1):
            away = round((number * step_m - low_m) * frame.px_per_m)
            text = f"{number * step_m:g}"
            half = text_width_px(text, SMALL) // 2
            if axis == 0:
                line(canvas, [(left + away, bottom), (left + away, bottom + 5)], FAINT, 1)
                write(canvas, text, left + away - half, bottom + 18, SMALL)
            else:
                line(canvas, [(left - 5, bottom - away), (left, bottom - away)], FAINT, 1)
                write(canvas, text, left - 9 - 2 * half, bottom - away + 4, SMALL)
    across, up = AXIS_NAMES[world]
    bold = Style(scale=0.5, color=INK)
    write(canvas, f"{across} [m]", (left + right) // 2 - 16, bottom + 36, bold)
    write(canvas, f"{up} [m]", left - 42, top - 8, bold)
    _scale_bar(canvas, frame)


def _scale_bar(canvas: Canvas, frame: Frame) -> None:
    """Draw one metre in the lower right corner."""
    length = round(frame.px_per_m)
    right, y = frame.box[2] - 16, frame.box[3] - 16
    text_px = text_width_px("1 m", Style(color=INK))
    rectangle(canvas, scale_bar_box(frame), (255, 255, 255), -1)
    line(canvas, [(right - length, y), (right, y)], INK, 3)
    for x in (right - length, right):
        line(canvas, [(x, y - 5), (x, y + 5)], INK, 2)
    write(canvas, "1 m", right - length // 2 - text_px // 2, y - 9, Style(color=INK))


def scale_bar_box(frame: Frame) -> Box:
    """Return the area of the scale bar, kept free of labels."""
    width = max(round(frame.px_per_m), 40)
    return frame.box[2] - 24 - width, frame.box[3] - 46, frame.box[2] - 6, frame.box[3] - 6


def _tick_step_m(span_m: float) -> float:
    for step_m in (0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0):
        if span_m / step_m <= 12:
            return step_m
    return 100.0
