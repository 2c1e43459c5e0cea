"""Records from the real AI2-THOR: one observation per reachable cell, seeded."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Protocol

import msgspec
import numpy as np
from numpy.typing import NDArray

from doro_schemas.errors import Refused
from doro_schemas.messages import Exploration
from doro_schemas.messages.base import Message
from doro_sim_feeder.events import EPOCH_NS, FRAME_PERIOD_NS, messages_of_event
from doro_sim_feeder.rooms.exploration import plan_views

GRID_M = 0.25
FOV_DEG = 90


class Controller(Protocol):
    """What is used of ``ai2thor.controller.Controller``."""

    def step(self, **action: Any) -> Any:
        """Carry out an action and return its event."""
        ...

    def stop(self) -> None:
        """End the simulator."""
        ...


class SimulatorSettings(msgspec.Struct, frozen=True, kw_only=True):
    """What to record.

    Attributes:
        room: AI2-THOR scene ("FloorPlan1").
        seed: of order, yaws and horizons.
        views: how many observations at most; None: one per reachable cell (paper, Section V).
        order: a name of :data:`doro_sim_feeder.rooms.exploration.ORDERS`.
        size_px: side of the images.
    """

    room: str
    seed: int = 0
    views: int | None = None
    order: str = "random"
    size_px: int = 300

    @property
    def episode(self) -> str:
        """Name of the episode."""
        return f"{self.room}-thor-seed{self.seed}"

    def recording_metadata(self) -> dict[str, str]:
        """Return what the recording says about itself."""
        return {
            "source": "ai2thor",
            "room": self.room,
            "seed": str(self.seed),
            "order": self.order,
            "depth": "f32_m",
        }


def open_controller(settings: SimulatorSettings) -> Controller:
    """Start AI2-THOR; its Unity build is fetched at the first start.

    Raises:
        Refused: not installed, or it does not start.
    """
    try:
        from ai2thor.controller import Controller as Thor  # noqa: PLC0415 - optional extra
    except ImportError as error:
        raise Refused(
            "recording from AI2-THOR needs the package ai2thor: pip install"
            " 'doro-sim-feeder[ai2thor]'; 'doro rooms render' makes rooms without it"
        ) from error
    try:
        controller: Controller = Thor(
            scene=settings.room,
            gridSize=GRID_M,
            width=settings.size_px,
            height=settings.size_px,
            fieldOfView=FOV_DEG,
            renderDepthImage=True,
            renderInstanceSegmentation=True,
            snapToGrid=True,
        )
    except Exception as error:
        raise Refused(
            f"AI2-THOR did not start with {settings.room}: {error}; it needs its Unity build"
            " (fetched at the first start) and a display, or 'doro rooms render' instead"
        ) from error
    return controller


def explore(controller: Controller, settings: SimulatorSettings) -> Iterator[Message]:
    """Yield an exploration: started, the messages of each observation, finished.

    A cell that the agent cannot be put on is left out.

    Raises:
        Refused: no reachable cell, or events without depth or segmentation.
    """
    positions = _reachable(controller, settings.room)
    cells = np.array([(at["x"], at["z"]) for at in positions], np.float64)
    views = plan_views(cells, settings.views, settings.seed, settings.order)
    episode, frame = settings.episode, 0
    yield Exploration(
        state="started",
        stamp_ns=EPOCH_NS,
        episode=episode,
        frames=len(views),
        room=settings.room,
    )
    for view in views:
        event = controller.step(
            action="Teleport",
            position=positions[_nearest(cells, view.position_m)],
            rotation={"x": 0, "y": view.yaw_deg, "z": 0},
            horizon=view.horizon_deg,
            standing=True,
        )
        if not event.metadata["lastActionSuccess"]:
            continue
        if event.depth_frame is None or event.instance_detections2D is None:
            raise Refused(
                "AI2-THOR gave an event without depth or instance segmentation: start it with"
                " renderDepthImage and renderInstanceSegmentation"
            )
        yield from messages_of_event(event, frame, episode)
        frame += 1
    if frame == 0:
        raise Refused(
            f"AI2-THOR put the agent on none of the {len(views)} cells of {settings.room}"
        )
    yield Exploration(
        state="finished",
        stamp_ns=EPOCH_NS + frame * FRAME_PERIOD_NS,
        episode=episode,
        frames=frame,
        room=settings.room,
        covered_area_m2=round(len(cells) * GRID_M**2, 4),
    )


def _reachable(controller: Controller, room: str) -> list[dict[str, float]]:
    event = controller.step(action="GetReachablePositions")
    positions: list[dict[str, float]] = event.metadata["actionReturn"] or []
    if not event.metadata["lastActionSuccess"] or not positions:
        raise Refused(f"AI2-THOR knows no reachable position in {room}")
    return sorted(positions, key=lambda at: (at["x"], at["z"]))


def _nearest(cells: NDArray[np.float64], position_m: tuple[float, float, float]) -> int:
    offsets = cells - (position_m[0], position_m[2])
    return int(np.hypot(offsets[:, 0], offsets[:, 1]).argmin())
