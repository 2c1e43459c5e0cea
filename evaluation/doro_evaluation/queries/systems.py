"""The whole system on (recording, instruction) pairs (paper, Tables III and IV)."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Sequence
from typing import Literal

import msgspec
import numpy as np

from doro_dialogue.ask_reading import compose_read
from doro_dialogue.decision import Decision, decide, paper_literal
from doro_dialogue.facts import Candidate
from doro_dialogue.question import Question, pick
from doro_dialogue.readings import decide_readings
from doro_evaluation.chain import Room
from doro_evaluation.maps import Found, MappedRoom
from doro_evaluation.outcomes import reported_boxes, reported_in, reported_views
from doro_evaluation.queries.judge import Truth, Verdict, identify, judge
from doro_evaluation.queries.pairs import Pair
from doro_nlu.core import Nlu
from doro_schemas.graph import ObjectGraph
from doro_schemas.messages import Evidence, FrameGraphs, SimDetections
from doro_schemas.vocabulary import canonical_name, name_satisfies, split_camel_case

View = Literal["multi-view", "one-view", "single-view", "single-view-shown"]
Decide = Callable[[ObjectGraph, Sequence[Candidate]], Decision]
DECIDERS: dict[str, Decide] = {"ours": decide, "paper_literal": paper_literal}
FINDERS = {"ours": "tracks", "paper_literal": "paper_literal"}


class QueryOutcome(msgspec.Struct, frozen=True):
    """How one pair came out in one row of a table.

    Attributes:
        view: ``multi-view``: all views merged (paper, Table IV); ``one-view``: one view with the
            most instances, judged by the whole room (Table IV, "single view");
            ``single-view``: the same view, judged by what the detector delivered of it (Table
            III); ``single-view-shown``: judged by what a perfect detector reports in it.
        bertscore, cosine: of the text and the true wording most like it, where measured.
    """

    pair: Pair
    system: str
    view: View
    verdict: Verdict
    bertscore: float | None = None
    cosine: float | None = None


class Speaker:
    """Instruction and candidates to what is said; the services' own functions.

    Args:
        nlu: parses the instructions.
        system: ``ours`` or ``paper_literal``, which decides by the paper's formulas.
    """

    def __init__(self, nlu: Nlu, system: str) -> None:
        self._nlu, self._decide, self._all = nlu, DECIDERS[system], system == "ours"

    def say(
        self, pair: Pair, candidates: Sequence[Candidate], unseen_share: float
    ) -> tuple[Decision, Question, str] | None:
        """Return decision, question and text; None where the instruction is not understood."""
        parsed = self._nlu.parse_text(pair.instruction)
        if parsed.graph is None:
            return None
        readings = [parsed.graph, *parsed.readings] if self._all else [parsed.graph]
        read = decide_readings(readings, candidates, self._decide)
        question = compose_read(read, task=parsed.task, unseen_share=unseen_share)
        return read.decision, question, pick(question.wordings, 0, pair.id)


def multi_view(
    room: Room, pairs: Sequence[Pair], found: Found, nlu: Nlu, *, system: str = "ours"
) -> Iterator[QueryOutcome]:
    """Yield the outcomes of a recording's pairs on the map of all its views."""
    truth = Truth.of(room.truth, reported_views(room), room.detections)
    identity = identify(found.instances, truth)
    candidates = [
        Candidate(one.instance_id, one.graph, tuple(one.evidence)) for one in found.instances
    ]
    speaker = Speaker(nlu, system)
    for pair in pairs:
        said = speaker.say(pair, candidates, found.unseen_share)
        verdict = judge(truth, pair.graph, pair.task, said, identity, found.unseen_share)
        yield QueryOutcome(pair, system, "multi-view", verdict)


def single_view(
    room: Room,
    pairs: Sequence[Pair],
    graphs: Sequence[FrameGraphs],
    nlu: Nlu,
    *,
    system: str = "ours",
) -> Iterator[QueryOutcome]:
    """Yield the outcomes on one view each, judged by the whole room and by the image."""
    whole = Truth.of(room.truth, reported_views(room), room.detections)
    speaker = Speaker(nlu, system)
    for pair in pairs:
        view = best_view(room.detections, pair)
        candidates, identity = of_view(graphs[view], room.detections[view])
        said, shown = speaker.say(pair, candidates, 0.0), [room.detections[view]]
        truths: dict[View, Truth] = {
            "one-view": whole,
            "single-view": Truth.of(room.truth, set(identity.values()), shown),
            "single-view-shown": Truth.of(room.truth, reported_in(room, [view]), shown),
        }
        for name, truth in truths.items():
            verdict = judge(truth, pair.graph, pair.task, said, identity)
            yield QueryOutcome(pair, system, name, verdict)


def best_view(detections: Sequence[SimDetections], pair: Pair) -> int:
    """Return a view with the most instances of the pair's class, drawn by the pair's id."""
    counts = np.array([_count(frame, pair.graph.name) for frame in detections])
    best = np.flatnonzero(counts == counts.max())
    digest = hashlib.sha256(f"view|{pair.id}".encode()).digest()
    return int(best[int.from_bytes(digest[:8], "big") % len(best)])


def run_system(
    mapped: MappedRoom, pairs: Sequence[Pair], nlu: Nlu, *, errors: str, system: str
) -> list[QueryOutcome]:
    """Return the outcomes of a recording's pairs for a system's rows of Tables III and IV."""
    found = mapped.found(FINDERS[system], errors)
    outcomes = list(multi_view(mapped.room, pairs, found, nlu, system=system))
    outcomes += single_view(mapped.room, pairs, mapped.graphs(errors), nlu, system=system)
    return outcomes


def _count(frame: SimDetections, name: str) -> int:
    """Return how many things of a class a perfect detector reports in a view."""
    return sum(name_satisfies(name, _name(item.object_type)) for item in reported_boxes(frame))


def of_view(graphs: FrameGraphs, frame: SimDetections) -> tuple[list[Candidate], dict[str, str]]:
    """Return the candidates of one view, and which object each of them is.

    The detector's boxes were shifted, so an object is found by class and nearest box.
    """
    candidates, identity, taken = [], {}, set[str]()
    for number, box in enumerate(graphs.detections, start=1):
        name = f"{box.graph.name.replace(' ', '-')}-{number}"
        seen = Evidence(graphs.camera, graphs.frame, list(box.box_px), box.caption)
        candidates.append(Candidate(name, box.graph, (seen,)))
        free = [
            item
            for item in frame.detections
            if item.object_id not in taken and _name(item.object_type) == box.graph.name
        ]
        if free:
            nearest = min(free, key=lambda item: _apart_px(item.box_px, box.box_px))
            identity[name] = nearest.object_id
            taken.add(nearest.object_id)
    return candidates, identity


def _name(object_type: str) -> str:
    return canonical_name(split_camel_case(object_type))


def _apart_px(one: Sequence[float], other: Sequence[float]) -> float:
    return float(np.abs(np.subtract(one, other)).sum())
