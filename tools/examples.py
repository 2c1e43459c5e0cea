"""One filled-in example of every message type: golden bytes and round trips use them."""

from __future__ import annotations

import numpy as np

from doro_schemas import messages as m
from doro_schemas.camera import intrinsics_from_vertical_fov, pose_from_ai2thor
from doro_schemas.graph import ObjectGraph, Relation
from doro_schemas.messages.base import Message
from doro_schemas.viewpoint import Viewpoint

STAMP_NS = 1_700_000_000_000_000_000
TABLE = ObjectGraph(name="table", attributes={"color": "white"})
CUP = ObjectGraph(
    name="cup",
    attributes={"color": "red", "material": "plastic"},
    relations=[Relation(type="is-on", target=TABLE)],
)
BOX = [10.0, 20.0, 60.5, 80.0]
EVIDENCE = m.Evidence(camera="cam0", frame=7, box_px=BOX, caption="a red cup")
FRAME = {
    "stamp_ns": STAMP_NS,
    "episode": "room-1",
    "camera": "cam0",
    "frame": 7,
    "height_px": 120,
    "width_px": 160,
}
OF_EPISODE = {"stamp_ns": STAMP_NS, "episode": "room-1"}


def examples() -> list[Message]:
    """Return one example of each type, in a fixed order."""
    return [*_frames(), *_language(), *_detections(), *_map(), *_talk(), *_control()]


def _frames() -> list[Message]:
    color = (np.arange(2 * 3 * 3, dtype=np.uint8)).reshape(2, 3, 3)
    depth = (np.arange(6, dtype=np.float32) / 4).reshape(2, 3)
    small = {**FRAME, "height_px": 2, "width_px": 3}
    return [
        m.ColorFrame(**small, data=color),
        m.DepthFrame(
            **small,
            intrinsics=intrinsics_from_vertical_fov(2, 3, 90.0),
            pose=pose_from_ai2thor((1.0, 1.5, -2.0), 90.0, 30.0),
            data=depth,
        ),
    ]


def _language() -> list[Message]:
    text = "bring me the red plastic cup"
    tokens = text.split()
    labels = ["O", "O", "O", "B-color", "B-material", "B-object"]
    parsed = {
        "text": text,
        "task": "bring",
        "tokens": tokens,
        "labels": labels,
        "graph": CUP,
        "readings": [ObjectGraph(name="cup")],
        "confidence": 0.875,
    }
    return [
        m.Instruction(stamp_ns=STAMP_NS, text=text),
        m.InstructionGraph(stamp_ns=STAMP_NS, **parsed),
        m.ParseRequest(text=text),
        m.ParseReply(**parsed),
    ]


def _detections() -> list[Message]:
    top = [m.ClassProbability(name="cup", probability=0.75)]
    return [
        m.SimDetections(
            **FRAME,
            detections=[
                m.SimDetection(
                    object_id="Cup|1",
                    object_type="Cup",
                    box_px=BOX,
                    attributes={"color": "red"},
                    relations=[m.SimRelation("is-on", "DiningTable", {"color": "white"})],
                )
            ],
        ),
        m.FrameCaptions(
            **FRAME,
            detections=[m.CaptionedBox(BOX, 0.75, "a red cup on the white table", None, top)],
            timing_us={"detect": 1500.0},
        ),
        m.FrameGraphs(
            **FRAME,
            detections=[m.GraphBox(BOX, 0.75, CUP, "a red cup on the white table", top)],
            not_understood=["and so on"],
        ),
    ]


def _map() -> list[Message]:
    cells = np.array([[0, 4, -3, 7, 2, 5], [0, 5, -3, 7, 1, 5]], dtype=np.int32)
    weights = np.array([1.5, 0.25], dtype=np.float32)
    grid = {"frames_merged": 8, "cell_m": 0.05, "band_m": 0.1, "cells": cells, "weights": weights}
    entry = m.GraphEntry(graph_id=0, graph=CUP)
    instance = m.Instance(
        instance_id="cup-1",
        graph=CUP,
        position_m=[0.25, 0.75, -0.15],
        extent_m=[0.1, 0.12, 0.1],
        confidence=0.9375,
        hits=15,
        misses=1,
        evidence=[EVIDENCE],
        cells=[[4, -3, 7]],
        runner_up={"color": "orange"},
    )
    return [
        m.GridDelta(**OF_EPISODE, seq=8, frame=7, new_graphs=[entry], **grid),
        m.GridRequest(name="cup"),
        m.GridSnapshot(
            **OF_EPISODE,
            last_frame=7,
            graphs=[entry],
            digest="00ff",
            floor=np.array([[1, 2]], dtype=np.int32),
            path_m=np.array([[0.5, 1.5]], dtype=np.float32),
            **grid,
        ),
        m.InstancesRequest(name="cup"),
        m.Instances(
            **OF_EPISODE,
            name="cup",
            frames_merged=8,
            last_frame=7,
            digest="00ff",
            unseen_share=0.125,
            instances=[instance],
        ),
    ]


def _talk() -> list[Message]:
    return [
        m.Query(
            **OF_EPISODE,
            dialogue_id="room-1/1",
            instruction="bring me the cup",
            input_graph=ObjectGraph(name="cup"),
            state="INFORM-AMBIGUITY",
            reason="several_match",
            text="I found one red cup, and one blue cup; which one do you mean?",
            clauses=[m.Clause(["cup-1"], "one red cup", CUP, [EVIDENCE], [[4, -3, 7]])],
            matches=["cup-1", "cup-2"],
            instances=["cup-1", "cup-2"],
            unseen_share=0.125,
            map_digest="00ff",
        ),
        m.Belief(
            **OF_EPISODE,
            dialogue_id="room-1/1",
            state="CONFIRM",
            reason="unique_match",
            matches=["cup-1"],
            instances=["cup-1"],
            frames_merged=5,
        ),
        m.Answer(text="the red one", dialogue_id="room-1/1"),
        m.Target(
            **OF_EPISODE,
            dialogue_id="room-1/1",
            instance_id="cup-1",
            graph=CUP,
            position_m=[0.25, 0.75, -0.15],
            extent_m=[0.1, 0.12, 0.1],
        ),
    ]


def _control() -> list[Message]:
    return [
        m.Exploration(
            **OF_EPISODE, state="finished", frames=8, room="FloorPlan1", covered_area_m2=9.5
        ),
        m.PoseCorrections(
            **OF_EPISODE, frames=[7], poses=[pose_from_ai2thor((1.0, 1.5, 2.0), 90.0, 30.0)]
        ),
        m.ExplorationGoal(
            **OF_EPISODE,
            frame=7,
            frames_merged=8,
            view=Viewpoint([1.0, 1.5, 2.0], 90.0, 30.0),
            pose=pose_from_ai2thor((1.0, 1.5, 2.0), 90.0, 30.0),
            distance_m=1.25,
            gain=2.5,
            parts={"area": 1.5, "tentative": 1.0},
            reason="unseen area, 1 tentative cup",
            unseen_share=0.25,
        ),
        m.Health(
            service="mapper",
            version="0.1.0",
            uptime_s=12.5,
            counters={"received.depth": 8},
            stages={"graphs": m.StageTiming(count=8, p50_us=2000.0, p99_us=4500.0)},
        ),
        m.Rejected(service="mapper", key="doro/graphs", reason="box outside", frame=7),
    ]
