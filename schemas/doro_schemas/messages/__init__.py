"""All messages of the wire, one file per domain; versions are the ``v`` in their schema."""

from doro_schemas.messages.control import (
    Exploration,
    ExplorationGoal,
    Health,
    PoseCorrections,
    Rejected,
    ServiceStatus,
    StageTiming,
)
from doro_schemas.messages.frames import ColorFrame, DepthFrame
from doro_schemas.messages.language import (
    Instruction,
    InstructionGraph,
    ParseReply,
    ParseRequest,
)
from doro_schemas.messages.map import (
    Evidence,
    GoneInstance,
    GraphEntry,
    GridDelta,
    GridRequest,
    GridSnapshot,
    Instance,
    Instances,
    InstancesRequest,
)
from doro_schemas.messages.perception import (
    CaptionedBox,
    ClassProbability,
    FrameCaptions,
    FrameGraphs,
    GraphBox,
    SimDetection,
    SimDetections,
    SimRelation,
)
from doro_schemas.messages.talk import Answer, Belief, Clause, Query, Target

__all__ = [
    "Answer",
    "Belief",
    "CaptionedBox",
    "ClassProbability",
    "Clause",
    "ColorFrame",
    "DepthFrame",
    "Evidence",
    "Exploration",
    "ExplorationGoal",
    "FrameCaptions",
    "FrameGraphs",
    "GoneInstance",
    "GraphBox",
    "GraphEntry",
    "GridDelta",
    "GridRequest",
    "GridSnapshot",
    "Health",
    "Instance",
    "Instances",
    "InstancesRequest",
    "Instruction",
    "InstructionGraph",
    "ParseReply",
    "ParseRequest",
    "PoseCorrections",
    "Query",
    "Rejected",
    "ServiceStatus",
    "SimDetection",
    "SimDetections",
    "SimRelation",
    "StageTiming",
    "Target",
]
