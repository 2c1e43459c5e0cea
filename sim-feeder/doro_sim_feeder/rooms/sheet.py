"""A contact sheet: colour, depth and ids of some views, to look at."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from doro_schemas.errors import Refused
from doro_sim_feeder.rooms.camera import Picture
from doro_sim_feeder.rooms.episode import RoomEpisode

FAR_M = 5.0
VIEWS = 9
PER_ROW = 3


def write_sheet(path: Path, episode: RoomEpisode, count: int = VIEWS) -> None:
    """Draw ``count`` views spread over the episode; spawned copies have boxes."""
    step = max(1, len(episode.views) // count)
    tiles = [_tile(episode, index) for index in range(0, len(episode.views), step)][:count]
    blank = np.zeros_like(tiles[0])
    tiles += [blank] * (-len(tiles) % PER_ROW)
    rows = [np.concatenate(tiles[k : k + PER_ROW], axis=1) for k in range(0, len(tiles), PER_ROW)]
    if not cv2.imwrite(str(path), np.concatenate(rows, axis=0)):
        raise Refused(f"cannot write the contact sheet {path}: use a .png in an existing folder")


def _tile(episode: RoomEpisode, index: int) -> NDArray[np.uint8]:
    picture: Picture = episode.picture(episode.views[index])
    color = picture.color if picture.color is not None else np.zeros((*picture.ids.shape, 3))
    image = np.ascontiguousarray(color[..., ::-1]).astype(np.uint8)
    for number, item in enumerate(episode.scene.instances, start=1):
        if item.copy and (picture.ids == number).sum() >= 30:
            rows, columns = np.nonzero(picture.ids == number)
            corners = (int(columns.min()), int(rows.min())), (int(columns.max()), int(rows.max()))
            cv2.rectangle(image, *corners, (0, 255, 255), 1)
    cv2.putText(image, str(index), (4, 14), cv2.FONT_HERSHEY_SIMPLEX, 0.45, (0, 0, 255), 1)
    near = (np.clip(picture.depth_m / FAR_M, 0, 1) * 255).astype(np.uint8)
    depth = cv2.applyColorMap(near, cv2.COLORMAP_TURBO)
    palette = np.random.default_rng(3).integers(40, 255, (len(episode.scene.instances) + 1, 3))
    tile: NDArray[np.uint8] = np.concatenate(
        [image, depth, palette.astype(np.uint8)[picture.ids]], axis=1
    )
    return tile
