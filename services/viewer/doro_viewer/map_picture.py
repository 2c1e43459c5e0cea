"""The final map as a picture for people: what was seen, what was meant, what is asked."""

from __future__ import annotations

import msgspec
import numpy as np
from numpy.typing import NDArray

from doro_schemas.camera import World
from doro_schemas.graph import ObjectGraph, walk
from doro_schemas.messages import GridSnapshot, Instance, Query
from doro_schemas.vocabulary import name_satisfies
from doro_viewer import map_panel as panel
from doro_viewer.colors import Rgb, graph_color, mix
from doro_viewer.labels import Box, Label, leader, place
from doro_viewer.legend import LANDMARK_SHARE, LEGEND_PX, draw_legend
from doro_viewer.lettering import (
    Canvas,
    Style,
    line,
    rectangle,
    text_width_px,
    wrap,
    write_lines,
)
from doro_viewer.words import short_description

MIN_WIDTH_PX = 900
MAP_HEIGHT_PX = 640
EDGE_PX = 24
AXIS_PX = 46
LABEL_PX = 210
LABEL_RELATIONS = 1
WHITE: Rgb = (255, 255, 255)
BODY = Style(scale=0.5, color=panel.INK)
TITLE = Style(scale=0.66, color=panel.INK, stroke_px=2)
LABEL = Style(scale=0.44, color=panel.INK)
LABEL_HEAD = Style(scale=0.46, color=panel.INK, stroke_px=2)
NOTE = Style(scale=0.42, color=(110, 110, 110))


def draw_map(
    snapshot: GridSnapshot,
    instances: list[Instance],
    query: Query | None,
    *,
    world: World = "unity",
    width_px: int = 1200,
) -> NDArray[np.uint8]:
    """Return the map as an RGB picture, uint8 (height, width_px, 3).

    Equal arguments give equal bytes. The height follows from the texts.

    Args:
        snapshot: the whole map.
        instances: instances to mark, of the class asked for.
        query: what is asked; None draws all classes without a question.
        world: axes of the instances' positions.
        width_px: at least 900.

    Raises:
        ValueError: the picture would be too narrow to read.
    """
    if width_px < MIN_WIDTH_PX:
        raise ValueError(f"a map picture needs at least {MIN_WIDTH_PX} px, got {width_px}")
    lines = _text_below(query, snapshot, width_px - 2 * EDGE_PX)
    top = EDGE_PX + 24
    map_box = (EDGE_PX + AXIS_PX, top, width_px - LEGEND_PX - EDGE_PX, top + MAP_HEIGHT_PX)
    text_top = map_box[3] + 48
    height = text_top + sum(style.line_px for style, _ in lines) + EDGE_PX
    canvas: Canvas = np.full((height, width_px, 3), 255, dtype=np.uint8)
    asked, landmarks = _classes(snapshot, instances, query)
    frame = panel.frame_for(snapshot, instances, world, map_box[2] - map_box[0], map_box)
    asked_regions = panel.regions(snapshot, asked)
    landmark_regions = panel.regions(snapshot, landmarks, by_class=True)
    _draw_panel(canvas, frame, snapshot, landmark_regions, asked_regions)
    panel.draw_axes(canvas, frame, world)
    _draw_instances(canvas, frame, instances, query.matches if query else [], world)
    asks = query is not None
    draw_legend(canvas, (map_box[2] + 22, top), asked_regions, landmark_regions, matches=asks)
    for style, text in lines:
        text_top = write_lines(canvas, [text], EDGE_PX, text_top, style)
    return canvas


def _classes(
    snapshot: GridSnapshot, instances: list[Instance], query: Query | None
) -> tuple[set[str], set[str]]:
    """Return the classes asked for and the landmarks that the picture's words refer to."""
    names = [entry.graph.name for entry in snapshot.graphs]
    if query is None:
        return set(names), set()
    said = query.input_graph.name
    asked = {name for name in names if name_satisfies(said, name)}
    graphs: list[ObjectGraph] = [query.input_graph, *(clause.graph for clause in query.clauses)]
    referred = {node.name for graph in graphs for node in list(walk(graph))[1:]}
    shown = [instance.graph.relations[:LABEL_RELATIONS] for instance in instances]
    referred |= {relation.target.name for relations in shown for relation in relations}
    landmarks = {name for name in names if any(name_satisfies(word, name) for word in referred)}
    return asked, landmarks - asked


def _draw_panel(
    canvas: Canvas,
    frame: panel.Frame,
    snapshot: GridSnapshot,
    landmarks: list[panel.Region],
    asked: list[panel.Region],
) -> None:
    panel.draw_ground(canvas, frame, snapshot)
    for region in landmarks:
        panel.draw_region(canvas, frame, region, snapshot.cell_m, LANDMARK_SHARE)
    panel.draw_path(canvas, frame, snapshot.path_m)
    for region in asked:
        panel.draw_region(canvas, frame, region, snapshot.cell_m, 1.0)


class _Tag(msgspec.Struct, frozen=True):
    """What is written beside an instance."""

    head: str
    text: list[str]
    color: Rgb
    matched: bool
    anchor: Box

    def label(self) -> Label:
        """Return the space that it takes."""
        widths = [
            text_width_px(self.head, LABEL_HEAD),
            *(text_width_px(one, LABEL) for one in self.text),
        ]
        height = LABEL_HEAD.line_px + len(self.text) * LABEL.line_px + 8
        return Label(width_px=max(widths) + 22, height_px=height, anchor=self.anchor)


def _draw_instances(
    canvas: Canvas, frame: panel.Frame, instances: list[Instance], matches: list[str], world: World
) -> None:
    """Draw boxes, then labels beside them with leader lines."""
    tags = [
        _Tag(
            head=instance.instance_id,
            text=wrap(
                short_description(instance.graph, LABEL_RELATIONS), LABEL_PX, LABEL, max_lines=2
            ),
            color=graph_color(instance.graph),
            matched=instance.instance_id in matches,
            anchor=panel.instance_box(frame, instance, world),
        )
        for instance in instances
    ]
    obstacles = _obstacles(canvas, frame, tags)
    for tag in tags:
        rectangle(canvas, tag.anchor, panel.INK, 2 if tag.matched else 1)
    left, top, right, bottom = frame.box
    inside = (left + 4, top + 4, right - 4, bottom - 4)
    placed = place([tag.label() for tag in tags], obstacles, inside)
    for box, foot in placed:
        line(canvas, leader(foot, box), mix(panel.INK, WHITE, 0.25), 1)
    for (box, _), tag in zip(placed, tags, strict=True):
        _draw_tag(canvas, box, tag)


def _draw_tag(canvas: Canvas, box: Box, tag: _Tag) -> None:
    left, top, _, bottom = box
    rectangle(canvas, box, WHITE, -1)
    rectangle(canvas, (left, top, left + 6, bottom), tag.color, -1)
    rectangle(canvas, box, panel.INK if tag.matched else panel.FAINT, 2 if tag.matched else 1)
    below = write_lines(canvas, [tag.head], left + 12, top + 1, LABEL_HEAD)
    write_lines(canvas, tag.text, left + 12, below, LABEL)


def _obstacles(canvas: Canvas, frame: panel.Frame, tags: list[_Tag]) -> NDArray[np.uint8]:
    """Return how bad it is to hide each pixel: instances most, gray things least."""
    spread = canvas.max(axis=2).astype(np.int16) - canvas.min(axis=2)
    weights = np.where(spread > 24, 2, 0).astype(np.uint8)
    weights[(canvas == panel.OTHER).all(axis=2)] = 1
    for left, top, right, bottom in (tag.anchor for tag in tags):
        weights[max(0, top - 10) : bottom + 11, max(0, left - 10) : right + 11] = 250
    left, top, right, bottom = panel.scale_bar_box(frame)
    weights[top:bottom, left:right] = 250
    return weights


def _text_below(query: Query | None, snapshot: GridSnapshot, width: int) -> list[tuple[Style, str]]:
    lines: list[tuple[Style, str]] = []
    note = f"{snapshot.frames_merged} frames merged, last frame {snapshot.last_frame}"
    if query is not None:
        texts = [
            (BODY, f'Instruction: "{query.instruction}"'),
            (TITLE, query.text),
            (NOTE, f"{query.state}, {query.reason}; {len(query.matches)} of"
                   f" {len(query.instances)} match; {query.unseen_share:.0%} of the area not seen"),
        ]  # fmt: skip
        for style, text in texts:
            lines += [(style, part) for part in wrap(text, width, style, max_lines=12)]
    cell_cm = snapshot.cell_m * 100
    note += f"; cells of {cell_cm:g} cm; map {snapshot.digest[:12] or 'without digest'}"
    return [*lines, (NOTE, note)]
