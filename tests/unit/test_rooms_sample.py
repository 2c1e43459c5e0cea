"""The sample that ships with the feeder holds what its ground truth says."""

from __future__ import annotations

import importlib.util
import json
from collections import Counter
from itertools import islice
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

import doro_sim_feeder
from doro_schemas import codec
from doro_schemas.camera import backproject
from doro_schemas.messages import ColorFrame, DepthFrame, Exploration, SimDetections
from doro_schemas.messages.base import Message
from doro_sim_feeder.recording import Recording
from doro_sim_feeder.rooms.copies import CopySpec
from doro_sim_feeder.rooms.episode import render_episode

DATA = Path(doro_sim_feeder.__file__).parent / "data"


@pytest.fixture(scope="module")
def messages() -> list[Message]:
    recording = Recording(DATA / "sample-kitchen.mcap")
    return [sample.message() for sample in recording.samples()]


@pytest.fixture(scope="module")
def truth() -> dict[str, dict[str, Any]]:
    items = json.loads((DATA / "sample-kitchen.truth.json").read_text())["instances"]
    return {item["object_id"]: item for item in items}


def test_the_generator_still_gives_the_sample(messages: list[Message]) -> None:
    """The READMEs say by which command; the first views show whether it still holds."""
    pytest.importorskip("embreex", reason="the extra 'render' is not installed")
    pytest.importorskip("PIL", reason="the extra 'render' is not installed")
    if importlib.util.find_spec("procthor") is None:
        pytest.skip("the extra 'render' is not installed")
    copies = CopySpec("Cup", 4, ("red", "red", "green", "yellow"))
    rendered = render_episode("FloorPlan19", seed=6, copies=copies, views=72)
    for want, have in zip(messages, islice(rendered, 7), strict=False):
        assert codec.encode(have) == codec.encode(want)


def test_the_sample_is_whole_and_small(messages: list[Message]):
    assert (DATA / "sample-kitchen.mcap").stat().st_size < 6_000_000
    counts = Counter(type(message).__name__ for message in messages)
    assert counts == {"Exploration": 2, "ColorFrame": 72, "DepthFrame": 72, "SimDetections": 72}
    assert isinstance(messages[-1], Exploration)
    assert messages[-1].frames == 72


def test_the_cups_are_as_the_demo_needs_them(truth):
    cups = [item for item in truth.values() if item["object_type"] == "Cup"]
    colors = Counter(cup["attributes"]["color"] for cup in cups)
    assert colors == {"red": 2, "blue": 1, "green": 1, "yellow": 1}
    assert min(cup["views"] for cup in cups) >= 6
    twins = [cup for cup in cups if cup["attributes"]["color"] == "red"]
    assert twins[0]["receptacle"] != twins[1]["receptacle"]
    mugs = [item for item in truth.values() if item["object_type"] == "Mug"]
    assert [mug["attributes"]["color"] for mug in mugs] == ["brown"]
    assert mugs[0]["views"] >= 6
    assert not [item for item in truth.values() if item["object_type"] in ("Vase", "Book")]


def test_detections_are_counted_in_the_truth(messages, truth):
    seen = Counter(
        detection.object_id
        for message in messages
        if isinstance(message, SimDetections)
        for detection in message.detections
    )
    assert seen == {name: item["views"] for name, item in truth.items() if item["views"]}


def test_depth_inside_a_cups_box_is_at_the_cup(messages, truth):
    """The nearest depth around the box's middle lies in the cup's 3-D box, but for occluders."""
    depths = {message.frame: message for message in messages if isinstance(message, DepthFrame)}
    hits = total = 0
    for message in messages:
        if not isinstance(message, SimDetections):
            continue
        for detection in message.detections:
            if detection.object_type != "Cup":
                continue
            xmin, ymin, xmax, ymax = detection.box_px
            u, v = (xmin + xmax) / 2, (ymin + ymax) / 2
            frame = depths[message.frame]
            depth_m = frame.depth_m()[int(v), int(u)]
            point = backproject(np.array(u), np.array(v), depth_m, frame.intrinsics, frame.pose)
            item = truth[detection.object_id]
            reach = np.asarray(item["size_m"]) / 2 + 0.02
            hits += bool((np.abs(point - item["center_m"]) <= reach).all())
            total += 1
    assert total >= 60
    assert hits / total > 0.9


def test_the_red_cups_look_red(messages, truth):
    """The median pixel of the inner box of each clearly seen cup has the cup's hue."""
    hue_deg = {"red": 0, "yellow": 50, "green": 125, "blue": 228}
    detections = {m.frame: m.detections for m in messages if isinstance(m, SimDetections)}
    errors = []
    for message in messages:
        if not isinstance(message, ColorFrame):
            continue
        image = cv2.imdecode(message.data, cv2.IMREAD_COLOR)
        assert image.shape == (300, 300, 3)
        for detection in detections[message.frame]:
            xmin, ymin, xmax, ymax = detection.box_px
            if detection.object_type != "Cup" or xmax - xmin < 12 or ymax - ymin < 12:
                continue
            dx, dy = (xmax - xmin) / 3, (ymax - ymin) / 3
            inner = image[int(ymin + dy) : int(ymax - dy), int(xmin + dx) : int(xmax - dx)]
            pixel = np.median(inner.reshape(-1, 3), axis=0).astype(np.uint8)
            hue = 2.0 * cv2.cvtColor(pixel.reshape(1, 1, 3), cv2.COLOR_BGR2HSV)[0, 0, 0]
            away = abs(hue - hue_deg[detection.attributes["color"]]) % 360
            errors.append(min(away, 360 - away))
    assert len(errors) >= 30
    assert np.percentile(errors, 90) < 20
