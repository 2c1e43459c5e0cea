"""The map: the two hash maps as deltas and snapshots, and the unique instance graphs."""

from __future__ import annotations

from typing import Any, ClassVar

import msgspec
import numpy as np

from doro_schemas.graph import ObjectGraph
from doro_schemas.messages.base import Message


class GraphEntry(msgspec.Struct, frozen=True):
    """An object graph id of the first hash map and the graph it stands for."""

    graph_id: int
    graph: ObjectGraph


class GridDelta(Message, kw_only=True):
    """What one frame changed in the map; also the mapper's word that the frame is merged.

    Attributes:
        seq: running number of the delta since the mapper's start or reset, from 0.
        reset: the map was emptied before this delta (a new episode).
        camera, frame: the frame that was merged; frame is -1 for a reset.
        frames_merged: frames in the map, this one included.
        cell_m, band_m: edge of a ground cell and height of a band, metres.
        new_graphs: object graph ids that are new.
        cells: int32 (n, 6) of changed cells: graph_id, ground cell a, ground cell b, height
            band, frequency, observable (absolute values after the change). In a ``unity``
            world a is x and b is z; in a ``ros`` world a is x and b is y.
        weights: float32 (n,) sum of weights of the same cells, absolute.
    """

    SEGMENTS: ClassVar[tuple[str, ...]] = ("cells", "weights")

    seq: int
    reset: bool = False
    camera: str = "cam0"
    frame: int
    frames_merged: int
    cell_m: float
    band_m: float
    new_graphs: list[GraphEntry] = []
    cells: np.ndarray[Any, Any]
    weights: np.ndarray[Any, Any]

    def __post_init__(self) -> None:
        check_cells(self.cells, self.weights)


class GridRequest(Message, kw_only=True):
    """A question to ``doro/grid``: the whole map, or the cells of one class."""

    name: str = ""


class GridSnapshot(Message, kw_only=True):
    """The map as it stands; fields as in :class:`GridDelta`, and ``digest`` over all of it.

    Attributes:
        floor: int32 (m, 2) ground cells seen to be floor or surface, for pictures.
        path_m: camera positions in order of merging, float32 (k, 2) ground metres.
        digest: hex digest of graphs and cells, equal for equal maps.
    """

    SEGMENTS: ClassVar[tuple[str, ...]] = ("cells", "weights", "floor", "path_m")

    frames_merged: int
    last_frame: int
    cell_m: float
    band_m: float
    graphs: list[GraphEntry] = []
    digest: str = ""
    cells: np.ndarray[Any, Any]
    weights: np.ndarray[Any, Any]
    floor: np.ndarray[Any, Any]
    path_m: np.ndarray[Any, Any]

    def __post_init__(self) -> None:
        check_cells(self.cells, self.weights)


def check_cells(cells: np.ndarray[Any, Any], weights: np.ndarray[Any, Any]) -> None:
    """Raise ValueError unless the two arrays describe the same n cells."""
    if cells.dtype != np.int32 or cells.ndim != 2 or cells.shape[1] != 6:
        raise ValueError(f"cells must be int32 (n, 6), got {cells.dtype} {cells.shape}")
    if weights.dtype != np.float32 or weights.shape != (len(cells),):
        raise ValueError(f"weights must be float32 ({len(cells)},), got {weights.shape}")


class Evidence(msgspec.Struct, frozen=True):
    """A view that supports an instance: the frame, the box in it, and its caption."""

    camera: str
    frame: int
    box_px: list[float]
    caption: str = ""


class Instance(msgspec.Struct, frozen=True):
    """A unique instance graph and what supports it.

    Attributes:
        instance_id: stable within an episode for equal input ("cup-1").
        graph: class, voted attributes, relations; never observed stays absent.
        position_m: centre of what was seen, world axes, metres.
        extent_m: size of the axis-aligned box, world axes, metres.
        confidence: existence, 0..1.
        hits, misses: frames that saw it; frames that should have and did not.
        evidence: strongest views first.
        cells: ground cells ``[a, b, band]`` that it stands on.
        runner_up: by attribute type, the second most seen value, if any.
    """

    instance_id: str
    graph: ObjectGraph
    position_m: list[float]
    extent_m: list[float]
    confidence: float = 1.0
    hits: int = 1
    misses: int = 0
    evidence: list[Evidence] = []
    cells: list[list[int]] = []
    runner_up: dict[str, str] = {}


class InstancesRequest(Message, kw_only=True):
    """A question to ``doro/instances``: which unique instances of a class are there?

    Attributes:
        name: class as said; its kinds count as well ("lamp" finds desk lamps). Empty: all.
        carried: classes of things that an instance may have on or in it ("the tray with the
            sponge on it"): where the map has them there, they come as inverse relations.
    """

    ADDED: ClassVar[dict[str, object]] = {"carried": []}

    name: str = ""
    carried: list[str] = []


class Instances(Message, kw_only=True):
    """The mapper's answer.

    Attributes:
        name: the class asked for.
        frames_merged, last_frame: state of the map that answered.
        digest: digest of that map.
        unseen_share: share of the area inside the map's bounds that no frame observed, 0..1.
        instances: the unique instances, in order of their ids.
    """

    name: str
    frames_merged: int
    last_frame: int
    digest: str = ""
    unseen_share: float = 0.0
    instances: list[Instance] = []
