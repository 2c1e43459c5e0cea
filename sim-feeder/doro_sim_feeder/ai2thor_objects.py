"""AI2-THOR's object metadata as detections: attributes, relations, boxes.

``metadata`` is ``event.metadata`` of AI2-THOR 5.0 (world: Unity, metres). It has no colours, and
``salientMaterials`` for about half of the objects; what it does not say is not made up.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from doro_schemas.camera import Intrinsics, Pose, intrinsics_from_vertical_fov, pose_from_ai2thor
from doro_schemas.errors import Refused
from doro_schemas.messages import SimDetection, SimRelation
from doro_schemas.spatial import Box3
from doro_sim_feeder.rooms.appearance import NO_MATERIAL
from doro_sim_feeder.rooms.instances import BACKGROUND
from doro_sim_feeder.rooms.truth import relations_of

MIN_SIDE_PX = 3.0
NEAR_M = 0.1
# The edges of a box whose corners are numbered by bits: x low/high, y low/high, z low/high.
EDGES = [(a, a | bit) for a in range(8) for bit in (1, 2, 4) if not a & bit]
Corners = NDArray[np.float64]
InclusiveBoxes = Mapping[str, tuple[int, int, int, int]]


@dataclass(frozen=True)
class SimObject:
    """One object of the metadata, as the rule of the relations takes it."""

    object_id: str
    object_type: str
    receptacles: tuple[str, ...]
    pickupable: bool
    visible: bool
    held: bool
    material: str | None
    box: Box3
    corners: Corners

    def attributes(self) -> dict[str, str]:
        """Return the true self attributes by type; colour is not in the metadata."""
        return {} if self.material is None else {"material": self.material}


def objects_of(metadata: Mapping[str, Any]) -> list[SimObject]:
    """Return the objects of an event that have a box, in order of their ids.

    Raises:
        Refused: the metadata is not AI2-THOR's.
    """
    try:
        found = [
            _object(item)
            for item in metadata["objects"]
            if item["axisAlignedBoundingBox"]["cornerPoints"]
        ]
    except (KeyError, TypeError, ValueError) as error:
        raise Refused(f"the event's object metadata lacks or has a wrong {error!r}") from error
    return sorted(found, key=lambda item: item.object_id)


def camera_of(
    metadata: Mapping[str, Any], height_px: int, width_px: int
) -> tuple[Intrinsics, Pose]:
    """Return the camera model of an event: vertical fov, ``cameraPosition``, yaw, horizon.

    Raises:
        Refused: a value is missing or impossible.
    """
    try:
        agent = metadata["agent"]
        intrinsics = intrinsics_from_vertical_fov(height_px, width_px, float(metadata["fov"]))
        pose = pose_from_ai2thor(
            metadata["cameraPosition"],
            float(agent["rotation"]["y"]),
            float(agent["cameraHorizon"]),
        )
    except (KeyError, TypeError, ValueError, ZeroDivisionError) as error:
        raise Refused(f"the event's camera metadata lacks or has a wrong {error!r}") from error
    return intrinsics, pose


def detections_from_boxes(objects: list[SimObject], boxes: InclusiveBoxes) -> list[SimDetection]:
    """Return detections of AI2-THOR's own 2-D boxes, whose last pixel is inclusive.

    Names without an object in the metadata (structure) are left out.
    """
    edges = {
        item.object_id: [float(box[0]), float(box[1]), float(box[2]) + 1.0, float(box[3]) + 1.0]
        for item in objects
        if item.object_id in boxes and (box := boxes[item.object_id]) is not None
    }
    return _detections(objects, edges)


def projected_detections(
    objects: list[SimObject], intrinsics: Intrinsics, pose: Pose, height_px: int, width_px: int
) -> list[SimDetection]:
    """Return detections of projected 3-D boxes, where the simulator recorded no 2-D ones.

    Only what the simulator calls visible (within 1.5 m and unobstructed): nothing says
    whether a thing farther away is hidden. Boxes of turned or hollow things are loose.
    """
    edges = {}
    for item in objects:
        if not item.visible or item.object_type in BACKGROUND:
            continue
        box = projected_box(item.corners, intrinsics, pose, height_px, width_px)
        if box is not None:
            edges[item.object_id] = box
    return _detections(objects, edges)


def projected_box(
    corners: Corners, intrinsics: Intrinsics, pose: Pose, height_px: int, width_px: int
) -> list[float] | None:
    """Return ``[xmin, ymin, xmax, ymax]`` around the part of a 3-D box in the image, or None.

    Args:
        corners: (8, 3) world metres, numbered by bits as in ``EDGES``.
    """
    camera = (corners - np.asarray(pose.position_m)) @ pose.matrix()
    points = [camera[camera[:, 2] >= NEAR_M]]
    for a, b in EDGES:  # where an edge leaves through the near plane, the point on that plane
        near, far = sorted((camera[a], camera[b]), key=lambda point: float(point[2]))
        if near[2] < NEAR_M <= far[2]:
            share = (NEAR_M - near[2]) / (far[2] - near[2])
            points.append((near + share * (far - near))[None])
    front = np.concatenate(points)
    if not len(front):
        return None
    u = front[:, 0] / front[:, 2] * intrinsics.fx + intrinsics.cx
    v = front[:, 1] / front[:, 2] * intrinsics.fy + intrinsics.cy
    box = [
        float(np.clip(value, 0, side))
        for value, side in (
            (u.min(), width_px),
            (v.min(), height_px),
            (u.max(), width_px),
            (v.max(), height_px),
        )
    ]
    small = min(box[2] - box[0], box[3] - box[1]) < MIN_SIDE_PX
    return None if small else box


def _object(item: Mapping[str, Any]) -> SimObject:
    aligned = item["axisAlignedBoundingBox"]
    oriented = (item.get("objectOrientedBoundingBox") or {}).get("cornerPoints")
    center, size = (aligned[name] for name in ("center", "size"))
    materials = [str(name).lower() for name in item["salientMaterials"] or ()]
    known = [name for name in materials if name not in NO_MATERIAL]
    return SimObject(
        object_id=str(item["objectId"]),
        object_type=str(item["objectType"]),
        receptacles=tuple(item["parentReceptacles"] or ()),
        pickupable=bool(item["pickupable"]),
        visible=bool(item["visible"]),
        held=bool(item["isPickedUp"]),
        material=known[0] if known else None,
        box=Box3(
            (float(center["x"]), float(center["z"]), float(center["y"])),
            (float(size["x"]), float(size["z"]), float(size["y"])),
        ),
        corners=_oriented(oriented) if oriented else _aligned(center, size),
    )


def _aligned(center: Mapping[str, float], size: Mapping[str, float]) -> Corners:
    signs = np.array([[(k >> axis & 1) - 0.5 for axis in range(3)] for k in range(8)])
    middle = np.array([center[axis] for axis in "xyz"], np.float64)
    corners: Corners = middle + signs * np.array([size[axis] for axis in "xyz"], np.float64)
    return corners


def _oriented(points: list[list[float]]) -> Corners:
    """Return Unity's corners in the order of bits: its lower and upper ring run around."""
    ring = np.asarray(points, np.float64)
    if ring.shape != (8, 3):
        raise ValueError(f"objectOrientedBoundingBox of shape {ring.shape}")
    ordered: Corners = ring[[0, 1, 4, 5, 3, 2, 7, 6]]
    return ordered


def _detections(objects: list[SimObject], edges: Mapping[str, list[float]]) -> list[SimDetection]:
    boxes = [item.box for item in objects]
    found = []
    for number, item in enumerate(objects):
        if item.object_id not in edges or item.object_type in BACKGROUND:
            continue
        # What the gripper holds stands nowhere.
        relations = [] if item.held else relations_of(number, objects, boxes)
        found.append(
            SimDetection(
                object_id=item.object_id,
                object_type=item.object_type,
                box_px=edges[item.object_id],
                attributes=item.attributes(),
                relations=[SimRelation(r.type, r.object_type, r.attributes) for r in relations],
            )
        )
    return found
