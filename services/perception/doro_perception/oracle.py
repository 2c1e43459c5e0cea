"""The oracle: what the simulator knows of a frame, said as a perfect captioner would.

Paper, Section V: ground-truth detections are disturbed by the error models (in
:mod:`doro_schemas.detector_errors`, before they come here) and captioned.
"""

from __future__ import annotations

import re

from doro_perception.backend import big_enough, clip_box
from doro_perception.caption import caption
from doro_perception.settings import PerceptionSettings
from doro_schemas.errors import Refused
from doro_schemas.graph import ObjectGraph, Relation
from doro_schemas.messages import CaptionedBox, SimDetection, SimDetections
from doro_schemas.vocabulary import canonical_name, canonical_value, split_camel_case

CLASS_TEXT = re.compile(r"[A-Za-z][A-Za-z0-9 _]{0,39}")
VALUE_TEXT = re.compile(r"[A-Za-z][A-Za-z -]{0,29}")


class Oracle:
    """Turns the simulator's detections into captioned boxes; holds no state."""

    def __init__(self, settings: PerceptionSettings) -> None:
        self._settings = settings

    def describe(self, frame: SimDetections) -> list[CaptionedBox]:
        """Return the captioned boxes of a frame, in the simulator's order, score 1.

        Raises:
            Refused: a class or a value that is no English word.
        """
        settings = self._settings
        boxes = []
        for detection in frame.detections:
            graph = self._graph(detection, frame)
            box_px = clip_box(detection.box_px, frame.height_px, frame.width_px)
            if detection.object_type in settings.leave_out:
                continue
            if not big_enough(box_px, settings.min_side_px, settings.min_area_px):
                continue
            if settings.emit == "graphs":
                boxes.append(CaptionedBox(box_px=box_px, score=1.0, graph=graph))
            else:
                text = caption(graph, settings.relation_joiner)
                boxes.append(CaptionedBox(box_px=box_px, score=1.0, caption=text))
        return boxes

    def _graph(self, detection: SimDetection, frame: SimDetections) -> ObjectGraph:
        """Return the object graph of a detection; its landmarks have no relations."""
        where = f"object '{detection.object_id[:60]}' of frame {frame.frame}"
        relations = [
            Relation(
                type=relation.type,
                target=_node(relation.object_type, relation.attributes, where),
            )
            for relation in detection.relations
        ]
        node = _node(detection.object_type, detection.attributes, where)
        return ObjectGraph(name=node.name, attributes=node.attributes, relations=relations)


def _node(object_type: str, attributes: dict[str, str], where: str) -> ObjectGraph:
    """Return one node in canonical words; ``where`` names it in a refusal."""
    if not CLASS_TEXT.fullmatch(object_type):
        raise Refused(
            f"objectType {object_type[:40]!r} of {where} is no class name:"
            " send the simulator's objectType, for example 'CoffeeTable'"
        )
    values = {}
    for kind, value in attributes.items():
        if not VALUE_TEXT.fullmatch(value):
            raise Refused(
                f"attribute {kind[:40]!r} of {where} has the value {value[:40]!r}:"
                " send a word, for example 'red'"
            )
        values[kind] = canonical_value(value)
    return ObjectGraph(name=canonical_name(split_camel_case(object_type)), attributes=values)
