"""The mapper on the packaged recording: a rendered kitchen with four spawned cups."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

import doro_sim_feeder
from doro_mapper.core import Mapper
from doro_mapper.settings import MapperSettings
from doro_schemas.graph import ObjectGraph
from doro_schemas.messages import (
    DepthFrame,
    Exploration,
    FrameGraphs,
    GraphBox,
    Instance,
    InstancesRequest,
    SimDetections,
)
from doro_schemas.vocabulary import canonical_name, split_camel_case
from doro_sim_feeder.recording import Recording

DATA = Path(doro_sim_feeder.__file__).parent / "data"
MIN_SIDE_PX = 6
SEEN_WELL = 4
"""What fewer frames show cannot be told from a false positive."""


def as_graphs(frame: SimDetections) -> FrameGraphs:
    boxes = []
    for item in frame.detections:
        xmin, ymin, xmax, ymax = item.box_px
        if min(xmax - xmin, ymax - ymin) >= MIN_SIDE_PX:
            graph = ObjectGraph(split_camel_case(item.object_type), item.attributes)
            boxes.append(GraphBox(item.box_px, 1.0, graph))
    return FrameGraphs(
        stamp_ns=frame.stamp_ns,
        episode=frame.episode,
        camera=frame.camera,
        frame=frame.frame,
        height_px=frame.height_px,
        width_px=frame.width_px,
        detections=boxes,
    )


@pytest.fixture(scope="module")
def instances() -> list[Instance]:
    mapper = Mapper(MapperSettings())
    for sample in Recording(DATA / "sample-kitchen.mcap").samples():
        message = sample.message()
        if isinstance(message, Exploration):
            mapper.exploration(message)
        elif isinstance(message, DepthFrame):
            mapper.depth_frame(message)
        elif isinstance(message, SimDetections):
            mapper.frame_graphs(as_graphs(message))
    assert mapper.pending == 0
    return mapper.instances(InstancesRequest()).instances


@pytest.fixture(scope="module")
def truth() -> list[dict[str, object]]:
    text = (DATA / "sample-kitchen.truth.json").read_text(encoding="utf-8")
    things: list[dict[str, object]] = json.loads(text)["instances"]
    return things


def name(thing: dict[str, object]) -> str:
    return canonical_name(split_camel_case(str(thing["object_type"])))


def test_every_class_seen_well_is_counted_exactly(
    instances: list[Instance], truth: list[dict[str, object]]
) -> None:
    well = Counter(name(t) for t in truth if int(str(t["views"])) >= SEEN_WELL)
    least = Counter(name(t) for t in truth if int(str(t["views"])) >= 1)
    found = Counter(i.graph.name for i in instances)
    assert sum(well.values()) > 40
    for kind in sorted(least):
        assert well[kind] <= found[kind] <= least[kind], kind
    assert set(found) <= set(least)


def test_cups_have_their_places_and_attributes(
    instances: list[Instance], truth: list[dict[str, object]]
) -> None:
    cups = [t for t in truth if t["object_type"] == "Cup" and int(str(t["views"])) >= SEEN_WELL]
    found = [i for i in instances if i.graph.name == "cup"]
    assert len(cups) == len(found) == 5
    for cup in cups:
        gaps = [np.linalg.norm(np.subtract(i.position_m, cup["center_m"])) for i in found]
        nearest = found[int(np.argmin(gaps))]
        assert min(gaps) < 0.04
        assert nearest.graph.attributes == cup["attributes"]
