"""Made-up AI2-THOR metadata and events, and where the recorded ones lie."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

import numpy as np
import pytest

SHARED = Path(__file__).resolve().parents[3] / "shared" / "data"
EVENTS = SHARED / "ai2thor_events" / "events"
BOXES = SHARED / "ai2thor_events_boxes" / "boxes.json"
needs_events = pytest.mark.skipif(
    not EVENTS.is_dir(), reason="no recorded events beside the project"
)
needs_ai2thor = pytest.mark.skipif(
    importlib.util.find_spec("ai2thor") is None, reason="the extra 'ai2thor' is not installed"
)
SIDE_PX = 120
KINDS = {"Table": ("Desk",), "Sofa": ("Sofa", "ArmChair")}  # the boxes have COCO's classes


def thing(object_id: str, center: tuple[float, float, float], size: float, **fields: Any) -> Any:
    """Return one object as AI2-THOR's metadata has it."""
    x, y, z = center
    corners = [
        [x + a * size / 2, y + b * size / 2, z + c * size / 2]
        for a in (1, -1)
        for b in (1, -1)
        for c in (1, -1)
    ]
    return {
        "objectId": object_id,
        "objectType": object_id.split("|", maxsplit=1)[0],
        "parentReceptacles": None,
        "salientMaterials": None,
        "pickupable": False,
        "visible": True,
        "isPickedUp": False,
        "axisAlignedBoundingBox": {
            "cornerPoints": corners,
            "center": {"x": x, "y": y, "z": z},
            "size": dict.fromkeys("xyz", size),
        },
        "objectOrientedBoundingBox": None,
        **fields,
    }


TABLE = "DiningTable|1"


def metadata(yaw_deg: float = 0.0, **fields: Any) -> dict[str, Any]:
    """A cup on a table, 2 m ahead of the standing agent; a wall; a far, invisible plate."""
    return {
        "objects": [
            thing(
                "Cup|1",
                (0.0, 1.05, 2.0),
                0.1,
                parentReceptacles=[TABLE],
                salientMaterials=["Food", "Plastic"],
                pickupable=True,
            ),
            thing(TABLE, (0.0, 0.5, 2.0), 1.0, salientMaterials=["Wood"]),
            thing("Plate|1", (0.3, 1.5, 4.0), 0.2, visible=False),
        ],
        "agent": {"rotation": {"x": 0, "y": yaw_deg, "z": 0}, "cameraHorizon": 0.0},
        "fov": 90.0,
        "cameraPosition": {"x": 0.0, "y": 1.576, "z": 0.0},
        "sceneName": "FloorPlan1_physics",
        "lastActionSuccess": True,
        "actionReturn": None,
        **fields,
    }


class Event:
    """What :func:`messages_of_event` needs of an event."""

    def __init__(self, data: dict[str, Any], boxes: Any = None, depth: Any = None) -> None:
        self.metadata = data
        self.frame = np.full((SIDE_PX, SIDE_PX, 3), 90, np.uint8)
        self.depth_frame = depth
        self.instance_detections2D = boxes


DEPTH = np.full((SIDE_PX, SIDE_PX), 2.5, np.float32)
