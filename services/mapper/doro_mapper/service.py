"""The mapper's shell: which message goes to which method of the core."""

from __future__ import annotations

from doro_mapper.core import Mapper
from doro_mapper.planner.guide import Guide
from doro_mapper.settings import MapperSettings
from doro_schemas.messages import (
    DepthFrame,
    Exploration,
    FrameGraphs,
    GridRequest,
    InstancesRequest,
    InstructionGraph,
    PoseCorrections,
)
from doro_schemas.runner import Shell, run_service


def wire(shell: Shell, settings: MapperSettings) -> None:
    """Connect the core to its messages."""
    core = Mapper(settings)
    guide = Guide(core, settings.planner, settings.max_pending_frames)
    shell.on(DepthFrame, guide.depth_frame)
    shell.on(FrameGraphs, guide.frame_graphs)
    shell.on(Exploration, guide.exploration)
    shell.on(InstructionGraph, guide.instruction)
    shell.on(PoseCorrections, core.pose_corrections)
    shell.answer(InstancesRequest, core.instances)
    shell.answer(GridRequest, core.grid)
    shell.counters(lambda: core.counters)


def main() -> None:
    """Run the service until it is told to stop."""
    run_service("mapper", MapperSettings, wire)
