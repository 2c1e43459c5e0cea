"""One name for one class and one word for one value, in all graphs of a frame."""

from __future__ import annotations

import functools

from doro_schemas.graph import ObjectGraph, Relation
from doro_schemas.messages import ClassProbability, FrameGraphs
from doro_schemas.vocabulary import canonical_name, canonical_value

_name = functools.lru_cache(maxsize=4096)(canonical_name)
_value = functools.lru_cache(maxsize=4096)(canonical_value)


def canonical(graphs: FrameGraphs) -> FrameGraphs:
    """Return the message with canonical names and values in all graphs and distributions."""

    def graph(own: ObjectGraph) -> ObjectGraph:
        return ObjectGraph(
            _name(own.name),
            {kind: _value(value) for kind, value in sorted(own.attributes.items())},
            [Relation(one.type, graph(one.target), one.inverse) for one in own.relations],
        )

    return FrameGraphs(
        stamp_ns=graphs.stamp_ns,
        episode=graphs.episode,
        camera=graphs.camera,
        frame=graphs.frame,
        height_px=graphs.height_px,
        width_px=graphs.width_px,
        detections=[
            type(box)(
                box.box_px,
                box.score,
                graph(box.graph),
                box.caption,
                [ClassProbability(_name(one.name), one.probability) for one in box.classes],
            )
            for box in graphs.detections
        ],
        unnamed=graphs.unnamed,
        calibrated=graphs.calibrated,
    )
