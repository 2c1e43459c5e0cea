"""What the map holds after a recording seen by a detector, as a sheet of pictures for the eye."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import cv2
import msgspec
import numpy as np
from numpy.typing import NDArray

from doro_mapper.core import Mapper
from doro_mapper.settings import MapperSettings
from doro_nlu.core import Nlu
from doro_nlu.settings import NluSettings
from doro_perception.backend import DetectionBackend
from doro_perception.caption import noun_phrase
from doro_perception.core import Perception
from doro_perception.draw import write_png
from doro_perception.image import decode
from doro_perception.settings import PerceptionSettings
from doro_schemas.messages import (
    ColorFrame,
    DepthFrame,
    Exploration,
    FrameCaptions,
    FrameGraphs,
    Instance,
    InstancesRequest,
)
from doro_schemas.messages.base import Message

TILE_PX, TEXT_PX, COLUMNS, MARGIN = 200, 34, 6, 0.6


def map_of(
    messages: Iterable[Message], detector: DetectionBackend, settings: PerceptionSettings
) -> tuple[list[Instance], dict[int, ColorFrame]]:
    """Return the instances after a recording's colour and depth frames, and the colour frames."""
    core, nlu = Perception(settings, detector), Nlu(NluSettings())
    mapper = Mapper(MapperSettings())
    colors: dict[int, ColorFrame] = {}
    for message in messages:
        if isinstance(message, Exploration) and message.state == "started":
            mapper.exploration(message)
        elif isinstance(message, DepthFrame):
            mapper.depth_frame(message)
        elif isinstance(message, ColorFrame):
            colors[message.frame] = message
            for said in core.color_frame(message):
                assert isinstance(said, FrameCaptions)
                for parsed in nlu.captions(said):
                    if isinstance(parsed, FrameGraphs):
                        mapper.frame_graphs(parsed)
    found = mapper.instances(InstancesRequest()).instances
    return sorted(found, key=lambda item: (item.graph.name, item.instance_id)), colors


def draw_sheet(path: Path, found: list[Instance], colors: dict[int, ColorFrame]) -> None:
    """Write a PNG with the strongest view of each instance."""
    tiles = [_tile(number, item, colors) for number, item in enumerate(found)]
    while len(tiles) % COLUMNS or not tiles:
        tiles.append(np.zeros((TILE_PX + TEXT_PX, TILE_PX, 3), np.uint8))
    rows = [np.hstack(tiles[k : k + COLUMNS]) for k in range(0, len(tiles), COLUMNS)]
    path.parent.mkdir(parents=True, exist_ok=True)
    write_png(path, np.vstack(rows))


def _tile(number: int, item: Instance, colors: dict[int, ColorFrame]) -> NDArray[np.uint8]:
    best = item.evidence[0]
    rgb = decode(colors[best.frame])
    height, width = rgb.shape[:2]
    x0, y0, x1, y1 = best.box_px
    half = max(x1 - x0, y1 - y0) * (1 + MARGIN) / 2
    half = min(max(half, 40.0), height / 2, width / 2)
    left = round(min(max((x0 + x1) / 2 - half, 0), width - 2 * half))
    top = round(min(max((y0 + y1) / 2 - half, 0), height - 2 * half))
    side = max(1, round(2 * half))
    part = np.ascontiguousarray(rgb[top : top + side, left : left + side])
    scale = TILE_PX / max(part.shape[0], 1)
    picture = cv2.resize(part, (TILE_PX, TILE_PX), interpolation=cv2.INTER_AREA)
    corners = [round((a - b) * scale) for a, b in zip(best.box_px, (left, top) * 2, strict=True)]
    cv2.rectangle(picture, corners[:2], corners[2:], (255, 0, 0), 2)
    text = np.full((TEXT_PX, TILE_PX, 3), 255, np.uint8)
    lines = (f"{number} {noun_phrase(item.graph)}", f"{item.hits} hits {item.misses} misses")
    for row, line in enumerate(lines):
        at = (3, 14 + 15 * row)
        cv2.putText(text, line, at, cv2.FONT_HERSHEY_SIMPLEX, 0.42, (0, 0, 0), 1, cv2.LINE_AA)
    return np.vstack([text, picture]).astype(np.uint8)


def listed(found: list[Instance]) -> list[dict[str, object]]:
    """Return the instances as plain rows for JSON."""
    return [
        {
            "number": number,
            "id": item.instance_id,
            "name": item.graph.name,
            "attributes": item.graph.attributes,
            "hits": item.hits,
            "misses": item.misses,
            "position_m": [round(value, 2) for value in item.position_m],
            "classes": [msgspec.to_builtins(one) for one in (item.classes or [])[:3]],
            "frame": item.evidence[0].frame,
        }
        for number, item in enumerate(found)
    ]
