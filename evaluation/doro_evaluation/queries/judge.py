"""Is a query right? The automatic rule of QA, and whose instance is whose.

QA of a pair is 1 when all of this holds, else 0:

1. the state is the true state;
2. the instances that the query offers are the true ones that it should offer, one to one;
3. every attribute and relation that a clause states is true of every instance it names:
   attributes by the truth's own values, relations as the truth lists them or, since it lists only
   a holder and two landmarks, by the shared rule between the true boxes (``doro_schemas.spatial``);
4. where a query tells twins by left and right, they stand so in the frame that it names.

The truth comes from the same decision on the true instances (class, attributes, relations) that
a perfect detector reports in at least one view. Which found instance is which true one follows
from its place.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Container, Mapping, Sequence
from typing import Literal

import msgspec
import numpy as np

from doro_dialogue.decision import Decision, Judged, decide
from doro_dialogue.facts import Candidate, facts_of, graph_with
from doro_dialogue.matching import match
from doro_dialogue.question import Question, compose
from doro_dialogue.rows import IN_ROW
from doro_mapper.assignment import assign
from doro_schemas.graph import ObjectGraph, Relation
from doro_schemas.messages import Evidence, Instance, SimDetections
from doro_schemas.messages.talk import SeenFrom
from doro_schemas.spatial import Box3, relation_between
from doro_schemas.vocabulary import name_satisfies
from doro_sim_feeder.rooms.expressions import name_of, true_graph
from doro_sim_feeder.rooms.truth import TrueInstance

REACH_M = 0.5
FAR_M = 1e6

Fault = Literal["", "not understood", "state", "instances", "attributes"]


class Verdict(msgspec.Struct, frozen=True):
    """How a pair came out.

    Attributes:
        fault: what is wrong first, by the rule above; empty: right.
        said, true: state said and true state; ``said`` is empty where nothing was understood.
        text: what was said; references: all true wordings.
        why: the fault in words, for people and for counting causes.
    """

    fault: Fault
    said: str
    true: str
    text: str
    references: list[str]
    why: str = ""

    @property
    def right(self) -> bool:
        return not self.fault


class Truth(msgspec.Struct, frozen=True):
    """The true instances that count, and their graphs by object id.

    Attributes:
        items: what counts; around: all of the room, as landmarks.
        views: by object id the frames that show it, with true boxes.
    """

    items: list[TrueInstance]
    graphs: dict[str, ObjectGraph]
    around: list[TrueInstance]
    views: dict[str, tuple[Evidence, ...]] = {}

    @classmethod
    def of(
        cls,
        around: Sequence[TrueInstance],
        counted: Container[str],
        frames: Sequence[SimDetections] = (),
    ) -> Truth:
        """Return the truth of a room.

        Args:
            around: all things of the room.
            counted: object ids of those that a perfect detector reports in some view.
            frames: the views with true boxes; without them nothing is told by left and right.
        """
        seen = [item for item in around if item.object_id in counted]
        views: dict[str, list[Evidence]] = defaultdict(list)
        for frame in frames:
            for box in frame.detections:
                shown = Evidence(frame.camera, frame.frame, list(box.box_px))
                views[box.object_id].append(shown)
        graphs = {item.object_id: true_graph(item) for item in seen}
        return cls(seen, graphs, list(around), {name: tuple(own) for name, own in views.items()})

    def holds(self, said: ObjectGraph, object_id: str) -> bool:
        """Tell whether all that a clause says is true of an instance."""
        return not self.untrue(said, object_id)

    def untrue(self, said: ObjectGraph, object_id: str) -> str:
        """Return what a clause says and is not true of an instance; empty: all is true."""
        for fact in facts_of(said):
            if not isinstance(fact, Relation):
                own = graph_with(said.name, [fact])
                if match(own, self.graphs[object_id]).verdict != "holds":
                    return f"{fact.type}: {fact.value}"
        if not name_satisfies(said.name, self.graphs[object_id].name):
            return f"name: {said.name}"
        item = next(one for one in self.items if one.object_id == object_id)
        for relation in said.relations:
            if not self._stands(item, relation):
                return f"{relation.type}: {relation.target.name}"
        return ""

    def _stands(self, item: TrueInstance, relation: Relation) -> bool:
        alone = ObjectGraph(name=name_of(item.object_type), relations=[relation])
        if match(alone, self.graphs[item.object_id]).verdict == "holds":
            return True
        return any(
            relation_between(_box(item), _box(other)) == relation.type
            and match(relation.target, true_graph(other)).verdict == "holds"
            and name_satisfies(relation.target.name, name_of(other.object_type))
            for other in self.around
            if other.object_id != item.object_id
        )

    def in_row(self, ids: Sequence[str], seen_from: SeenFrom) -> bool:
        """Tell whether things stand from left to right in a frame."""
        at = [
            (shown.box_px[0] + shown.box_px[2]) / 2
            for name in ids
            for shown in self.views.get(name, ())
            if (shown.camera, shown.frame) == (seen_from.camera, seen_from.frame)
        ]
        return len(at) == len(ids) and at == sorted(at)

    def decide(self, graph: ObjectGraph) -> Decision:
        """Return the true decision for the true input graph."""
        return decide(graph, [Candidate(name, seen) for name, seen in self.graphs.items()])

    def wordings(self, right: Decision, task: str, unseen_share: float) -> list[str]:
        """Return all true wordings: twins told by number, or by side where a view shows them."""
        plain = compose(right, task=task, unseen_share=unseen_share).wordings
        beside = msgspec.structs.replace(right, offered=[self._shown(one) for one in right.offered])
        sided = compose(beside, task=task, unseen_share=unseen_share).wordings
        return list(dict.fromkeys([*plain, *sided]))

    def _shown(self, judged: Judged) -> Judged:
        own = judged.candidate
        views = self.views.get(own.id, ())
        return msgspec.structs.replace(judged, candidate=Candidate(own.id, own.graph, views))


def identify(found: Sequence[Instance], truth: Truth) -> dict[str, str]:
    """Return the object id of each found instance that is one, by its own id.

    One to one, nearest first in sum; a found instance may be a true one of a class that one of
    the two names covers, within 0.5 m of its centre or with the centre inside its box.
    """
    if not found or not truth.items:
        return {}
    cost = np.full((len(found), len(truth.items)), FAR_M)
    for row, one in enumerate(found):
        for column, item in enumerate(truth.items):
            offset_m = np.abs(np.subtract(one.position_m, item.center_m))
            distance_m = float(np.linalg.norm(offset_m))
            inside = bool(np.all(offset_m <= np.asarray(item.size_m) / 2))
            if _same_class(one.graph.name, name_of(item.object_type)) and (
                inside or distance_m <= REACH_M
            ):
                cost[row, column] = distance_m
    return {
        found[row].instance_id: truth.items[column].object_id
        for row, column in assign(cost)
        if cost[row, column] < FAR_M
    }


def judge(  # noqa: PLR0917
    truth: Truth,
    true_input: ObjectGraph,
    task: str,
    said: tuple[Decision, Question, str] | None,
    identity: Mapping[str, str],
    unseen_share: float = 0.0,
) -> Verdict:
    """Return the verdict on one query.

    Args:
        true_input: graph of what the instruction really says.
        said: decision, question and text of the system; None: it understood nothing.
        identity: object ids by ids of the system's instances.
        unseen_share: as the query states it; the references state the same.
    """
    right = truth.decide(true_input)
    references = truth.wordings(right, task, unseen_share)
    if said is None:
        return Verdict("not understood", "", right.state, "", references)
    decision, question, text = said
    fault, why = _fault(truth, right, decision, question, identity)
    return Verdict(fault, decision.state, right.state, text, references, why)


def _fault(
    truth: Truth,
    right: Decision,
    decision: Decision,
    question: Question,
    identity: Mapping[str, str],
) -> tuple[Fault, str]:
    """Return what is wrong first, and in words."""
    if decision.state != right.state:
        return "state", f"{decision.state} for {right.state}"
    offered = Counter(identity.get(one.candidate.id, "") for one in decision.offered)
    wanted = Counter(one.candidate.id for one in right.offered)
    if offered != wanted:
        added, left = (offered - wanted).total(), (wanted - offered).total()
        return "instances", f"{left} left out, {added} offered that should not be"
    # The paper's confirmation is an "Okay.": nothing is said of the instance.
    for part in () if decision.literal and decision.state == "CONFIRM" else question.parts:
        for name in part.instance_ids:
            if wrong := truth.untrue(part.graph, identity[name]):
                return "attributes", wrong
    row = [identity[one.instance_ids[0]] for one in question.parts if IN_ROW.search(one.text)]
    if question.seen_from is not None and not truth.in_row(row, question.seen_from):
        return "attributes", "left and right"
    return "", ""


def _same_class(one: str, other: str) -> bool:
    return name_satisfies(one, other) or name_satisfies(other, one)


def _box(item: TrueInstance) -> Box3:
    """Return the box of an instance as (ground, ground, up), from world x, y, z."""
    (x, y, z), (width, height, depth) = item.center_m, item.size_m
    return Box3((x, z, y), (width, depth, height))
