"""A made-up session for the viewer's tests: frames, a grid, five cups and a question."""

from __future__ import annotations

import cv2
import numpy as np

from doro_schemas import messages as m
from doro_schemas.camera import intrinsics_from_vertical_fov, pose_from_ai2thor
from doro_schemas.graph import ObjectGraph, Relation
from doro_schemas.messages.base import Message

CELL_M, BAND_M, SIDE_PX = 0.05, 0.25, 120
TABLE = ObjectGraph(name="table", attributes={"color": "white"})
RED = ObjectGraph(name="cup", attributes={"color": "red", "material": "plastic"})
BLUE = ObjectGraph(name="cup", attributes={"color": "dark blue"})
CLEAR = ObjectGraph(name="cup", attributes={"material": "glass"})
GRAPHS = [TABLE, RED, BLUE, CLEAR, ObjectGraph(name="sofa")]
CUPS = [
    (RED, 1.0, 1.0),
    (RED, 1.16, 1.05),
    (BLUE, 1.32, 0.98),
    (CLEAR, 1.1, 1.22),
    (BLUE, 1.3, 1.2),
]


def block(
    graph_id: int, low: tuple[float, float], high: tuple[float, float], band: int
) -> np.ndarray:
    """Return the cells of a ground rectangle, int32 (n, 6)."""
    a = np.arange(round(low[0] / CELL_M), round(high[0] / CELL_M))
    b = np.arange(round(low[1] / CELL_M), round(high[1] / CELL_M))
    pairs = np.stack(np.meshgrid(a, b, indexing="ij"), axis=-1).reshape(-1, 2)
    rest = [np.full(len(pairs), value) for value in (band, 4, 6)]
    return np.column_stack([np.full(len(pairs), graph_id), pairs, *rest]).astype(np.int32)


def cells() -> np.ndarray:
    """Return the cells of the table, the sofa and the cups."""
    parts = [block(0, (0.7, 0.8), (1.7, 1.45), 2), block(4, (-2.0, 2.4), (-0.2, 3.2), 1)]
    for graph, x, z in CUPS:
        parts.append(block(GRAPHS.index(graph), (x - 0.05, z - 0.05), (x + 0.05, z + 0.05), 3))
    return np.concatenate(parts)


def snapshot() -> m.GridSnapshot:
    """Return the map of the room."""
    every = cells()
    weights = np.linspace(0.4, 2.0, len(every), dtype=np.float32)
    floor = block(0, (-2.2, -1.0), (2.4, 3.4), 0)[:, 1:3]
    floor = floor[(floor[:, 0] < 20) | (floor[:, 1] < 44)]
    steps = np.linspace(0, 1, 30)
    path = np.column_stack([-1.5 + 3 * steps, 0.4 * np.sin(7 * steps)]).astype(np.float32)
    return m.GridSnapshot(
        stamp_ns=7_000_000_000,
        frames_merged=30,
        last_frame=29,
        cell_m=CELL_M,
        band_m=BAND_M,
        graphs=[m.GraphEntry(number, graph) for number, graph in enumerate(GRAPHS)],
        digest="0123456789abcdef",
        cells=every,
        weights=weights,
        floor=np.ascontiguousarray(floor),
        path_m=path,
    )


def instances() -> m.Instances:
    """Return five cups that stand close together."""
    found = []
    for number, (graph, x, z) in enumerate(CUPS, start=1):
        on = Relation("is-on", TABLE)
        full = ObjectGraph(name=graph.name, attributes=graph.attributes, relations=[on])
        view = m.Evidence("cam0", number, [10.0, 20.0, 40.0, 60.0], "a cup on a table")
        found.append(
            m.Instance(
                instance_id=f"cup-{number}",
                graph=full,
                position_m=[x, 0.85, z],
                extent_m=[0.08, 0.1, 0.08],
                evidence=[view],
            )
        )
    return m.Instances(name="cup", frames_merged=30, last_frame=29, instances=found)


def query(revision: int = 0) -> m.Query:
    """Return the robot's question about the red cups."""
    return m.Query(
        stamp_ns=6_000_000_000,
        dialogue_id="kitchen/1",
        revision=revision,
        instruction="bring me the red cup from the table",
        input_graph=ObjectGraph(
            name="cup", attributes={"color": "red"}, relations=[Relation("is-at", TABLE)]
        ),
        state="INFORM-AMBIGUITY",
        reason="several_match",
        text="There are two red plastic cups on the white table: the left one and the right one."
        " Which one do you mean?",
        clauses=[
            m.Clause([one.instance_id], "one red plastic cup", RED, one.evidence)
            for one in instances().instances[:2]
        ],
        matches=["cup-1", "cup-2"],
        instances=[f"cup-{number}" for number in range(1, 6)],
        unseen_share=0.12,
    )


def color_frame(frame: int, image: np.ndarray | None = None) -> m.ColorFrame:
    """Return a frame as JPEG; noise where no image is given."""
    if image is None:
        random = np.random.default_rng(frame)
        image = random.integers(0, 255, (SIDE_PX, SIDE_PX, 3), dtype=np.uint8)
    data = cv2.imencode(".jpg", image)[1].ravel()
    return m.ColorFrame(
        stamp_ns=stamp_ns(frame),
        frame=frame,
        height_px=image.shape[0],
        width_px=image.shape[1],
        encoding="jpeg",
        data=data,
    )


def stamp_ns(frame: int) -> int:
    """Return the time of a frame."""
    return 1_700_000_000_000_000_000 + frame * 100_000_000


def frame_messages(frame: int, image: np.ndarray | None = None) -> list[Message]:
    """Return what is published about one frame: colour, depth, captions, graphs, delta."""
    color = color_frame(frame, image)
    size = {"height_px": color.height_px, "width_px": color.width_px}
    side = color.width_px
    boxes = [[0.1, 0.5, 0.3, 0.8], [0.35, 0.55, 0.5, 0.75], [0.0, 0.7, 0.9, 0.98]]
    pixels = [[value * side for value in box] for box in boxes]
    seen = [RED, BLUE, TABLE]
    stamp = stamp_ns(frame)
    pose = pose_from_ai2thor((-1.5 + 0.1 * frame, 1.57, 0.3), 60.0 + frame, 20.0)
    part = cells()[frame::10]
    return [
        color,
        m.DepthFrame(
            stamp_ns=stamp,
            frame=frame,
            intrinsics=intrinsics_from_vertical_fov(side, side, 90.0),
            pose=pose,
            data=np.full((side, side), 1.0 + 0.1 * frame, dtype=np.float32),
            **size,
        ),
        m.FrameCaptions(
            stamp_ns=stamp,
            frame=frame,
            detections=[
                m.CaptionedBox(box, 0.9, f"a {graph.attributes['color']} {graph.name}")
                for box, graph in zip(pixels, seen, strict=True)
            ],
            **size,
        ),
        m.FrameGraphs(
            stamp_ns=stamp,
            frame=frame,
            detections=[
                m.GraphBox(box, 0.9, graph, f"a {graph.attributes['color']} {graph.name}")
                for box, graph in zip(pixels, seen, strict=True)
            ],
            **size,
        ),
        m.GridDelta(
            stamp_ns=stamp,
            seq=frame,
            frame=frame,
            frames_merged=frame + 1,
            cell_m=CELL_M,
            band_m=BAND_M,
            new_graphs=snapshot().graphs if frame == 0 else [],
            cells=part,
            weights=np.ones(len(part), dtype=np.float32),
        ),
    ]


def session(frames: int, images: list[np.ndarray] | None = None) -> list[Message]:
    """Return a whole run up to the robot's question."""
    told: list[Message] = [
        m.Exploration(state="started", room="kitchen", frames=frames),
        m.InstructionGraph(
            text="bring me the red cup from the table",
            task="bring",
            graph=query().input_graph,
            confidence=0.97,
        ),
    ]
    for frame in range(frames):
        told += frame_messages(frame, images[frame] if images else None)
    told.append(
        m.Belief(
            dialogue_id="kitchen/1",
            state="INFORM-AMBIGUITY",
            reason="several_match",
            matches=["cup-1", "cup-2"],
            instances=["cup-1", "cup-2", "cup-3"],
            frames_merged=frames,
        )
    )
    told.append(m.Exploration(state="finished", frames=frames))
    return [*told, query()]
