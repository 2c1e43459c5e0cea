"""Something that a detector could not name: kept as a place, counted as nothing, told as such."""

from __future__ import annotations

import msgspec
import numpy as np
from mapper_scene import Thing, messages, room, shoot, table, walk

from doro_dialogue.readings import Read
from doro_dialogue.settings import DialogueSettings
from doro_dialogue.talk import decide_on, query_of
from doro_mapper.core import Mapper
from doro_mapper.settings import MapperSettings
from doro_nlu.core import Nlu
from doro_nlu.settings import NluSettings
from doro_schemas.graph import ObjectGraph
from doro_schemas.messages import (
    Exploration,
    FrameCaptions,
    FrameGraphs,
    Instances,
    InstancesRequest,
    UnnamedPlace,
    UnnamedRegion,
)
from doro_schemas.messages.language import InstructionGraph

MUG_AT = (0.2, 0.8, 0.1)
THINGS = [*room(), table((0, 0)), Thing("mug", MUG_AT, (0.09, 0.1, 0.09))]
PAIRS = messages(shoot(THINGS, walk(8)))


def nameless(graphs: FrameGraphs, kept: bool) -> FrameGraphs:
    """The mug's boxes without a name; with ``kept`` beside the named ones."""
    mugs = [item for item in graphs.detections if item.graph.name == "mug"]
    others = [item for item in graphs.detections if kept or item.graph.name != "mug"]
    regions = [UnnamedRegion(box_px=item.box_px, score=0.8) for item in mugs]
    return msgspec.structs.replace(graphs, detections=others, unnamed=regions)


def mapped(kept: bool) -> Instances:
    mapper = Mapper(MapperSettings())
    mapper.exploration(Exploration(episode="e", state="started"))
    for depth, graphs in PAIRS:
        mapper.depth_frame(depth)
        mapper.frame_graphs(nameless(graphs, kept))
    return mapper.instances(InstancesRequest())


def test_what_has_no_name_is_a_place_and_no_instance() -> None:
    reply = mapped(kept=False)
    assert all(one.graph.name != "mug" for one in reply.instances)
    (place,) = reply.unnamed
    assert place.views >= 2
    assert np.linalg.norm(np.subtract(place.position_m, MUG_AT)) < 0.15


def test_what_lies_inside_of_a_named_thing_is_a_part_of_it() -> None:
    reply = mapped(kept=True)
    assert any(one.graph.name == "mug" for one in reply.instances)
    assert reply.unnamed == []


def test_the_parser_hands_the_regions_on_and_whether_scores_are_calibrated() -> None:
    region = UnnamedRegion(box_px=[1.0, 2.0, 30.0, 40.0], score=0.7)
    frame = FrameCaptions(frame=0, height_px=100, width_px=100, unnamed=[region], calibrated=True)
    (graphs,) = Nlu(NluSettings()).captions(frame)
    assert isinstance(graphs, FrameGraphs)
    assert graphs.unnamed == [region]
    assert graphs.calibrated


def said(unnamed: list[UnnamedPlace], name: str) -> str:
    wanted = ObjectGraph(name=name)
    reply = Instances(name=name, frames_merged=5, last_frame=4, unnamed=unnamed)
    settings = DialogueSettings()
    read: Read = decide_on([wanted], reply, settings)
    instruction = InstructionGraph(text="bring it", task="bring")
    return query_of(read, instruction, reply, settings, dialogue_id="d", episode="e").text


def test_missing_says_that_there_was_something_without_a_name() -> None:
    place = UnnamedPlace(position_m=[0.0, 1.0, 2.0], views=3)
    plain = said([], "cup")
    assert "cannot name" not in plain
    assert said([place], "cup") == plain + " I also saw something that I cannot name."
    assert said([place, place], "cup").endswith(" I also saw 2 things that I cannot name.")
