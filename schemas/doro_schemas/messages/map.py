"""The map: the two hash maps as deltas and snapshots, and the unique instance graphs."""

from __future__ import annotations

from typing import Any, ClassVar, Literal

import msgspec
import numpy as np

from doro_schemas.graph import ObjectGraph
from doro_schemas.messages.base import Message
from doro_schemas.messages.perception import ClassProbability


class GraphEntry(msgspec.Struct, frozen=True):
    """An object graph id of the first hash map and the graph it stands for."""

    graph_id: int
    graph: ObjectGraph


def _no_rows(columns: int) -> Any:
    """Return the default of a segment of int32 rows."""
    return msgspec.field(default_factory=lambda: np.zeros((0, columns), np.int32))


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
        weights: float32 (n,) sum of weights of the same cells, absolute. A cell with frequency 0
            is no longer in the map (a pose was corrected).
        blocks: int32 (m, 4) of blocks that this frame had in view: block a, block b, block up,
            and the frames that had them in view, absolute. A block is 5 x 5 cells and 2 bands:
            its numbers are the cell's divided by (5, 5, 2), rounded down. A cell's observable
            is the larger one of its frequency and its block's count; a delta repeats cells only
            when their weight changed.
        corrected: frames that corrected poses placed anew; ``frame`` is -1 then.
    """

    SEGMENTS: ClassVar[tuple[str, ...]] = ("cells", "weights", "blocks")
    ADDED: ClassVar[dict[str, object]] = {"blocks": None, "corrected": 0}

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
    blocks: np.ndarray[Any, Any] = _no_rows(4)
    corrected: int = 0

    def __post_init__(self) -> None:
        check_cells(self.cells, self.weights)
        check_rows(self.blocks, 4, "blocks")


class GridRequest(Message, kw_only=True):
    """A question to ``doro/grid``: the whole map, or the cells of one class."""

    name: str = ""


class GridSnapshot(Message, kw_only=True):
    """The map as it stands; fields as in :class:`GridDelta`, and ``digest`` over all of it.

    Attributes:
        floor: int32 (m, 2) ground cells seen to be floor or surface, for pictures.
        path_m: camera positions in order of merging, float32 (k, 2) ground metres; the latest.
        digest: hex digest of graphs and cells, equal for equal maps.
        blocks: int32 (m, 4) all blocks, as in :class:`GridDelta`.
        squares: int32 (m, 4) squares of ``square_m`` in which a surface was seen: square a, square
            b, frames, and a bit for each eighth of the circle from which it was looked at (bit 0:
            looking along +a, the next ones turning towards +b).
        regions, region_scores: int32 (k, 3) graph_id, region a, region b and float32 (k,): the
            paper's occupancy score of the graph in regions of ``region_m``; sums to 1 by graph.
    """

    SEGMENTS: ClassVar[tuple[str, ...]] = (
        "cells",
        "weights",
        "floor",
        "path_m",
        "blocks",
        "squares",
        "regions",
        "region_scores",
    )
    ADDED: ClassVar[dict[str, object]] = {
        "blocks": None,
        "squares": None,
        "regions": None,
        "region_scores": None,
        "square_m": 0.0,
        "region_m": 0.0,
    }

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
    blocks: np.ndarray[Any, Any] = _no_rows(4)
    squares: np.ndarray[Any, Any] = _no_rows(4)
    regions: np.ndarray[Any, Any] = _no_rows(3)
    region_scores: np.ndarray[Any, Any] = msgspec.field(
        default_factory=lambda: np.zeros(0, np.float32)
    )
    square_m: float = 0.0
    region_m: float = 0.0

    def __post_init__(self) -> None:
        check_cells(self.cells, self.weights)
        check_rows(self.blocks, 4, "blocks")
        check_rows(self.squares, 4, "squares")
        check_rows(self.regions, 3, "regions")


def check_cells(cells: np.ndarray[Any, Any], weights: np.ndarray[Any, Any]) -> None:
    """Raise ValueError unless the two arrays describe the same n cells."""
    if cells.dtype != np.int32 or cells.ndim != 2 or cells.shape[1] != 6:
        raise ValueError(f"cells must be int32 (n, 6), got {cells.dtype} {cells.shape}")
    if weights.dtype != np.float32 or weights.shape != (len(cells),):
        raise ValueError(f"weights must be float32 ({len(cells)},), got {weights.shape}")


def check_rows(rows: np.ndarray[Any, Any], columns: int, what: str) -> None:
    """Raise ValueError unless ``rows`` is int32 (n, columns)."""
    if rows.dtype != np.int32 or rows.ndim != 2 or rows.shape[1] != columns:
        raise ValueError(f"{what} must be int32 (n, {columns}), got {rows.dtype} {rows.shape}")


class Evidence(msgspec.Struct, frozen=True):
    """A view that supports an instance: the frame, the box in it, and its caption."""

    camera: str
    frame: int
    box_px: list[float]
    caption: str = ""


class Instance(msgspec.Struct, frozen=True):
    """A unique instance graph and what supports it.

    Attributes:
        instance_id: given once in an episode and never to another thing ("cup-1"), whatever
            the map learns later; equal for equal input.
        graph: class, voted attributes, relations; never observed stays absent.
        position_m: centre of what was seen, world axes, metres.
        extent_m: size of the axis-aligned box, world axes, metres.
        confidence: probability that it exists, 0..1, from hits and misses.
        hits, misses: frames that saw it; frames that should have and did not.
        evidence: strongest views first.
        cells: ground cells ``[a, b, band]`` that it stands on.
        runner_up: by attribute type, the second most seen value, if any.
        status: ``confirmed``: counts; ``tentative``: seen too little. Absent: confirmed.
        covariance_m2: of the position, xx, xy, xz, yy, yz, zz in world axes, square metres.
        classes: class distribution over all views, most probable first.
        replaces: ids under which parts of it were known before they turned out to be one.
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
    status: Literal["confirmed", "tentative"] | msgspec.UnsetType = msgspec.UNSET
    covariance_m2: list[float] | msgspec.UnsetType = msgspec.UNSET
    classes: list[ClassProbability] | msgspec.UnsetType = msgspec.UNSET
    replaces: list[str] | msgspec.UnsetType = msgspec.UNSET


class GoneInstance(msgspec.Struct, frozen=True):
    """An id that was given and stands for no counted instance now; it may come back.

    Attributes:
        reason: ``merged``: it turned out to be ``replaced_by``; ``moved``: its place was looked
            at again and it was not there; ``doubted``: too many views missed it.
        replaced_by: the instance that it is now, empty where there is none.
    """

    instance_id: str
    reason: Literal["merged", "moved", "doubted"]
    replaced_by: str = ""


class UnnamedPlace(msgspec.Struct, frozen=True):
    """Something is there that the detector could not name; it counts as nothing.

    Attributes:
        position_m: its centre, world axes, metres.
        views: frames that showed it.
    """

    position_m: list[float]
    views: int


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
        tentative: things seen too little to count; ids are empty where none was given yet.
        gone: ids given before that stand for no counted instance of the reply's classes.
        one_sided_share: share of the area observed that was looked at from one side only, 0..1;
            what hides behind things there has not been seen.
        unnamed: places with something that has no name, whatever class is asked for, those with
            most views first.
    """

    ADDED: ClassVar[dict[str, object]] = {
        "tentative": [],
        "gone": [],
        "one_sided_share": 0.0,
        "unnamed": [],
    }

    name: str
    frames_merged: int
    last_frame: int
    digest: str = ""
    unseen_share: float = 0.0
    instances: list[Instance] = []
    tentative: list[Instance] = []
    gone: list[GoneInstance] = []
    one_sided_share: float = 0.0
    unnamed: list[UnnamedPlace] = []
