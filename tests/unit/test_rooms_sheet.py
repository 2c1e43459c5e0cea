"""Contact sheets, and what looking at them brought to light."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import cv2
import numpy as np
import pytest
from click.testing import CliRunner

from doro_console.sheets import sheet
from doro_sim_feeder.rooms.episode import RoomEpisode
from doro_sim_feeder.rooms.layout import load_layout
from doro_sim_feeder.rooms.scene import build_scene
from doro_sim_feeder.rooms.sheet import some_rooms

pytestmark = pytest.mark.skipif(
    any(importlib.util.find_spec(name) is None for name in ("embreex", "procthor", "PIL")),
    reason="the extra 'render' is not installed",
)


def test_a_sheet_has_colour_depth_and_ids_of_each_room(tmp_path: Path):
    path = tmp_path / "rooms.png"
    result = CliRunner().invoke(sheet, ["FloorPlan19", "FloorPlan310", "--out", str(path)])
    assert result.exit_code == 0, result.output
    image = cv2.imread(str(path))
    assert image is not None
    assert image.shape == (300, 2700, 3)
    for room in (image[:, :900], image[:, 900:1800]):
        color, depth, ids = room[:, :300], room[:, 300:600], room[:, 600:]
        assert color[20:].std() > 20
        assert depth.std() > 20
        assert len(np.unique(ids.reshape(-1, 3), axis=0)) > 5
    assert image[:, 1800:].max() == 0


def test_nine_rooms_are_chosen_by_the_seed():
    rooms = some_rooms(0)
    assert len(set(rooms)) == 9
    numbers = [int(name.removeprefix("FloorPlan")) for name in rooms]
    assert [sum(low < n < low + 100 for n in numbers) for low in (0, 200, 300)] == [3, 3, 3]
    assert some_rooms(0) == rooms
    assert some_rooms(1) != rooms


def test_an_unwritable_sheet_is_one_sentence(tmp_path: Path):
    path = tmp_path / "nowhere" / "rooms.png"
    result = CliRunner().invoke(sheet, ["FloorPlan19", "--out", str(path)])
    assert result.exit_code == 1


@pytest.mark.parametrize("room", ["FloorPlan3", "FloorPlan221", "FloorPlan21", "FloorPlan19"])
def test_the_floor_is_at_zero_and_things_stand_on_it(room: str):
    """FloorPlan3's floor lies 22 cm up in iTHOR: its stools floated."""
    floor = load_layout(room).of_type("Floor")[0]
    assert abs(floor.high_m[1]) < 0.01
    standing = ("Chair", "Stool", "Fridge", "Sofa", "ArmChair", "GarbageCan")
    lows = [i.corners[0][1] for i in build_scene(room).instances if i.object_type in standing]
    assert lows
    assert max(abs(float(low)) for low in lows) < 0.03


def test_what_stands_on_a_shelf_is_seen():
    """iTHOR's box of a shelf is the room above its board: as a solid block it hid what it held."""
    scene = build_scene("FloorPlan301")
    shelves = {item.object_id: item for item in scene.instances if item.object_type == "Shelf"}
    assert shelves
    for shelf in shelves.values():
        low, high = shelf.corners
        assert high[1] - low[1] < 0.03
    held = [
        number
        for number, item in enumerate(scene.instances, start=1)
        if any(name in shelves for name in item.receptacles)
    ]
    assert held
    episode = RoomEpisode("FloorPlan301", seed=0, color=False)
    seen = set()
    for view in episode.views:
        seen |= set(np.unique(episode.picture(view).ids))
    assert seen & set(held)


def test_no_picture_burns_out_or_drowns():
    """The lamp burnt a white spot into the ceiling."""
    for room in ("FloorPlan23", "FloorPlan211"):
        episode = RoomEpisode(room, seed=0, views=6, size_px=100)
        for view in episode.views:
            color = episode.picture(view).color
            assert color is not None
            assert (color.min(axis=2) >= 254).mean() < 0.03
            assert (color.max(axis=2) <= 8).mean() < 0.2
