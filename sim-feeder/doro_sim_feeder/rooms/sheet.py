"""Contact sheets, to look at: colour, depth and ids, of views of a room or of several rooms."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from doro_schemas.errors import Refused
from doro_sim_feeder.rooms.camera import Picture
from doro_sim_feeder.rooms.episode import RoomEpisode
from doro_sim_feeder.rooms.exploration import View
from doro_sim_feeder.rooms.layout import room_names
from doro_sim_feeder.rooms.renderers import RendererName, make_renderer
from doro_sim_feeder.rooms.scene import Scene

FAR_M = 5.0
VIEWS = 9
PER_ROW = 3
KINDS = ("kitchens", "living_rooms", "bedrooms")
CANDIDATES = 24
MIN_PX = 30
Image = NDArray[np.uint8]


def write_sheet(path: Path, episode: RoomEpisode, count: int = VIEWS) -> None:
    """Draw ``count`` views spread over the episode; spawned copies have boxes.

    Raises:
        Refused: the file cannot be written.
    """
    step = max(1, len(episode.views) // count)
    chosen = range(0, len(episode.views), step)[:count]
    tiles = [
        _tile(episode.picture(episode.views[index]), episode.scene, str(index)) for index in chosen
    ]
    _write(path, tiles)


def write_room_sheet(
    path: Path, rooms: list[str], seed: int, *, renderer: RendererName = "embree"
) -> None:
    """Draw one view of each room, the one of some that shows the most things.

    Raises:
        Refused: no such room, no such renderer here, or the file cannot be written.
    """
    tiles = []
    for room in rooms:
        episode = RoomEpisode(room, seed=seed, views=CANDIDATES, color=False)
        view = max(episode.views, key=lambda one: _things(episode.picture(one)))
        tiles.append(_tile(_picture(episode.scene, view, renderer), episode.scene, room))
    _write(path, tiles)


def some_rooms(seed: int, count: int = VIEWS) -> list[str]:
    """Return ``count`` seeded rooms, as many kitchens as living rooms and bedrooms."""
    rng = np.random.default_rng([seed, 13])
    shuffled = [rng.permutation(room_names(kind)).tolist() for kind in KINDS]
    return [shuffled[number % len(KINDS)][number // len(KINDS)] for number in range(count)]


def _picture(scene: Scene, view: View, renderer: RendererName) -> Picture:
    taker = make_renderer(renderer, scene)
    try:
        return taker.take(view.pose())
    finally:
        taker.close()


def _things(picture: Picture) -> int:
    """Return how many instances a picture shows."""
    return int((np.bincount(picture.ids.ravel())[1:] >= MIN_PX).sum())


def _tile(picture: Picture, scene: Scene, label: str) -> Image:
    """Return colour, depth and ids side by side, BGR; spawned copies have boxes."""
    color: NDArray[Any] = np.zeros((*picture.ids.shape, 3), np.uint8)
    if picture.color is not None:
        color = picture.color[..., ::-1]
    image = np.ascontiguousarray(color, np.uint8)
    for number, item in enumerate(scene.instances, start=1):
        if item.copy and (picture.ids == number).sum() >= MIN_PX:
            rows, columns = np.nonzero(picture.ids == number)
            corners = (int(columns.min()), int(rows.min())), (int(columns.max()), int(rows.max()))
            cv2.rectangle(image, *corners, (0, 255, 255), 1)
    for thickness, tint in ((3, (255, 255, 255)), (1, (0, 0, 200))):
        cv2.putText(image, label, (4, 14), cv2.FONT_HERSHEY_SIMPLEX, 0.45, tint, thickness)
    near = (np.clip(picture.depth_m / FAR_M, 0, 1) * 255).astype(np.uint8)
    depth = cv2.applyColorMap(near, cv2.COLORMAP_TURBO)
    palette = np.random.default_rng(3).integers(40, 255, (len(scene.instances) + 1, 3))
    palette[0] = 0  # nothing was hit
    tile: Image = np.concatenate([image, depth, palette.astype(np.uint8)[picture.ids]], axis=1)
    return tile


def _write(path: Path, tiles: list[Image]) -> None:
    tiles = tiles + [np.zeros_like(tiles[0])] * (-len(tiles) % PER_ROW)
    rows = [np.concatenate(tiles[k : k + PER_ROW], axis=1) for k in range(0, len(tiles), PER_ROW)]
    try:
        written = cv2.imwrite(str(path), np.concatenate(rows, axis=0))
    except cv2.error:
        written = False
    if not written:
        raise Refused(f"cannot write the contact sheet {path}: use a .png in an existing folder")
