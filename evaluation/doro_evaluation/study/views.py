"""Pictures of a study: which views show the candidates, in colour, with letters on them.

Colour comes from the recording, or, where it has none, from rendering the same view again:
then its depth must be that of the recording, so that nobody rates the wrong room.
"""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import cv2
import msgspec
import numpy as np
from numpy.typing import NDArray

from doro_evaluation.chain import Room
from doro_perception.image import decode
from doro_schemas.errors import Refused
from doro_schemas.messages import ColorFrame, DepthFrame, SimDetections
from doro_sim_feeder.recording import Recording
from doro_sim_feeder.rooms.episode import RoomEpisode
from doro_sim_feeder.rooms.evaluation_set import SetRow, plan_set
from doro_sim_feeder.rooms.make_set import MANIFEST
from doro_sim_feeder.rooms.renderers import make_renderer

Image = NDArray[np.uint8]
SIZE_PX = 480
JPEG_QUALITY = 84
MOST_PICTURES = 4
FEWEST_PICTURES = 2
GOOD_SHARE = 0.008
"""Share of the image from which a thing is seen well; larger adds nothing."""
LARGE_SHARE = 0.25
"""A thing that fills more hides where it is."""
ENOUGH = 0.6
"""A candidate is shown once a view is this good for it, of its best."""
SAME_DEPTH_M = 0.02
WANTED, OTHER = (255, 196, 0), (255, 255, 255)
INK = (20, 20, 20)
FONT = cv2.FONT_HERSHEY_DUPLEX


class Shot(msgspec.Struct, frozen=True):
    """A picture of a scene: a JPEG as data URI, and which letters it shows."""

    source: str
    letters: list[str]


def views_for(
    detections: Sequence[SimDetections], landmarks: Mapping[str, Sequence[str]]
) -> list[int]:
    """Return the indices of up to four views that show all things between them.

    Args:
        landmarks: object ids to show, each with those that say where it is; none: the views
            that show most of the room.
    """
    things = dict(landmarks) or dict.fromkeys(_all_things(detections), ())
    quality = np.array(
        [[_quality(frame, one, by) for one, by in things.items()] for frame in detections]
    ).reshape(len(detections), len(things))
    best = quality.max(axis=0, initial=0.0)
    relative = quality / np.where(best > 0, best, 1.0)
    shown = np.zeros(len(things))
    chosen: list[int] = []
    while len(chosen) < MOST_PICTURES and (shown < ENOUGH).any():
        gain = (np.maximum(relative, shown) - shown).sum(axis=1)
        view = int(gain.argmax())
        if gain[view] <= 0:
            break
        chosen.append(view)
        shown = np.maximum(shown, relative[view])
    while 0 < len(chosen) < FEWEST_PICTURES < len(detections):
        rest = np.where(np.isin(np.arange(len(detections)), chosen), -1.0, relative.sum(axis=1))
        chosen.append(int(rest.argmax()))
    return chosen


def _all_things(detections: Sequence[SimDetections]) -> list[str]:
    return sorted({item.object_id for frame in detections for item in frame.detections})


def _quality(frame: SimDetections, object_id: str, landmarks: Sequence[str]) -> float:
    """Return how well a view shows a thing and where it is; 0..1.

    Best is large enough, no close-up, whole, near the middle, with its landmarks in view.
    """
    boxes = {item.object_id: item.box_px for item in frame.detections}
    if object_id not in boxes:
        return 0.0
    left, top, right, bottom = boxes[object_id]
    share = (right - left) * (bottom - top) / (frame.width_px * frame.height_px)
    cut_off = min(left, top) <= 1 or right >= frame.width_px - 1 or bottom >= frame.height_px - 1
    aside = abs((left + right) / frame.width_px - 1), abs((top + bottom) / frame.height_px - 1)
    seen = sum(one in boxes for one in landmarks) / max(1, len(landmarks))
    quality = min(1.0, share / GOOD_SHARE) * (0.4 if cut_off else 1.0)
    quality *= 0.5 if share > LARGE_SHARE else 1.0
    return quality * (1 - 0.4 * max(aside)) * (0.6 + 0.4 * seen)


class Photographer:
    """Gives the colour images of a recording."""

    def __init__(self, path: Path, room: Room) -> None:
        self._path, self._room = path, room
        self._recording = Recording(path)
        self._in_color = any(key.endswith("/color") for key in self._recording.counts)

    def images(self, views: Sequence[int]) -> list[Image]:
        """Return RGB images of views, in order.

        Raises:
            Refused: the recording has no colour and cannot be rendered again.
        """
        if self._in_color:
            return self._recorded(views)
        return self._rendered(views)

    def _recorded(self, views: Sequence[int]) -> list[Image]:
        frames = {(self._room.depths[k].camera, self._room.depths[k].frame): k for k in views}
        found: dict[int, Image] = {}
        for sample in self._recording.samples():
            if ColorFrame not in sample.topic.messages:
                continue
            message = sample.message()
            if isinstance(message, ColorFrame) and (message.camera, message.frame) in frames:
                found[frames[message.camera, message.frame]] = decode(message)
        if missing := [k for k in views if k not in found]:
            raise Refused(f"{self._path} has no colour frame for view {missing[0]}")
        return [found[k] for k in views]

    def _rendered(self, views: Sequence[int]) -> list[Image]:
        row = self._row()
        episode = RoomEpisode(
            row.room,
            seed=row.seed,
            copies=row.spec(),
            views=1,
            color=False,
            allow_missing=True,
            name=row.name,
        )
        renderer = make_renderer("embree", episode.scene, SIZE_PX, color=True)
        try:
            taken = [renderer.take(self._room.depths[k].pose) for k in views]
        finally:
            renderer.close()
        for k, picture in zip(views, taken, strict=True):
            _check_same(self._path, self._room.depths[k], picture.depth_m)
        return [picture.color for picture in taken if picture.color is not None]

    def _row(self) -> SetRow:
        """Return how the recording was made: from the set's manifest, or its plan."""
        name = self._path.stem
        try:
            raw = (self._path.parent / MANIFEST).read_bytes()
            rows = msgspec.json.decode(raw, type=_Manifest).recordings
        except OSError:
            rows = plan_set()
        except msgspec.DecodeError as error:
            raise Refused(f"{self._path.parent / MANIFEST} cannot be read: {error}") from error
        found = [row for row in rows if row.name == name]
        if not found:
            raise Refused(
                f"{self._path} has no colour frames and is no recording of the evaluation set:"
                " record it with colour"
            )
        return found[0]


class _Manifest(msgspec.Struct):
    recordings: list[SetRow]


def _check_same(path: Path, recorded: DepthFrame, depth_m: NDArray[np.float32]) -> None:
    """Raise Refused unless a view that was rendered again is the one that was recorded."""
    was_m = recorded.depth_m()
    now_m = cv2.resize(depth_m, was_m.shape[::-1], interpolation=cv2.INTER_NEAREST)
    if float(np.median(np.abs(now_m - was_m))) > SAME_DEPTH_M:
        raise Refused(
            f"{path} was made by another version of the renderer (its depth is not that of"
            " today's room): make the set again with 'doro rooms set'"
        )


def shot(
    image: Image,
    frame: SimDetections,
    marks: Mapping[str, str],
    wanted: Sequence[str],
) -> Shot:
    """Return an image with a box and a letter on every mark that it shows.

    Args:
        marks: object ids by letter; wanted: letters drawn in yellow, with a star.
    """
    canvas = cv2.resize(image, (SIZE_PX, SIZE_PX), interpolation=cv2.INTER_AREA)
    if image.shape[0] < SIZE_PX:
        canvas = cv2.resize(image, (SIZE_PX, SIZE_PX), interpolation=cv2.INTER_CUBIC)
    scale = (SIZE_PX / frame.width_px, SIZE_PX / frame.height_px)
    shown = []
    taken: list[tuple[int, int, int, int]] = []
    for letter, object_id in marks.items():
        boxes = [item.box_px for item in frame.detections if item.object_id == object_id]
        if boxes:
            box = [int(value * scale[k % 2]) for k, value in enumerate(boxes[0])]
            taken.append(_mark(canvas, box, letter, letter in wanted, taken))
            shown.append(letter)
    done, data = cv2.imencode(".jpg", canvas[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
    if not done:
        raise Refused("OpenCV cannot write JPEG: reinstall opencv-python-headless")
    text = base64.b64encode(np.asarray(data, np.uint8).tobytes()).decode()
    return Shot(f"data:image/jpeg;base64,{text}", shown)


def _mark(
    canvas: NDArray[Any],
    box: list[int],
    letter: str,
    wanted: bool,
    taken: Sequence[tuple[int, int, int, int]],
) -> tuple[int, int, int, int]:
    """Draw a box and its letter beside it; return where the letter stands."""
    left, top, right, bottom = box
    tint = WANTED if wanted else OTHER
    for width, color in ((5, INK), (2, tint)):
        cv2.rectangle(canvas, (left - 3, top - 3), (right + 2, bottom + 2), color, width)
    side = 26
    places = [(left - 4, top - side - 5), (right - side + 4, top - side - 5)]
    places += [(left - 4, bottom + 5), (left - side - 6, top - 4), (right + 6, top - 4)]
    x, y = next(
        (place for place in places if _free(place, side, taken)),
        (min(max(left, 0), SIZE_PX - side), max(top, 0)),
    )
    cv2.rectangle(canvas, (x, y), (x + side, y + side), tint, cv2.FILLED)
    cv2.rectangle(canvas, (x, y), (x + side, y + side), INK, 2)
    (width, height), _ = cv2.getTextSize(letter, FONT, 0.75, 2)
    origin = (x + (side - width) // 2, y + (side + height) // 2)
    cv2.putText(canvas, letter, origin, FONT, 0.75, INK, 2, cv2.LINE_AA)
    return (x, y, x + side, y + side)


def _free(place: tuple[int, int], side: int, taken: Sequence[tuple[int, int, int, int]]) -> bool:
    x, y = place
    inside = x >= 0 and y >= 0 and x + side < SIZE_PX and y + side < SIZE_PX
    return inside and not any(
        x < right and left < x + side and y < bottom and top < y + side
        for left, top, right, bottom in taken
    )
