"""The baseline's rows of Tables III and IV: which captions it reads, and how it came out.

One view (the same one that our single-view rows take), the captions of all views joined, and our
aggregated instances worded as captions. All on the same detections with the same errors.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from doro_evaluation.baseline.examples import caption_of
from doro_evaluation.baseline.judging import judge_text
from doro_evaluation.baseline.model import Baseline
from doro_evaluation.chain import ERROR_MODELS
from doro_evaluation.maps import MappedRoom
from doro_evaluation.outcomes import reported_in, reported_views
from doro_evaluation.queries.judge import Truth
from doro_evaluation.queries.pairs import Pair
from doro_evaluation.queries.systems import QueryOutcome, View, best_view, of_view
from doro_evaluation.runs import speak
from doro_nlu.core import Nlu
from doro_schemas.graph import ObjectGraph

BASELINE, JOINED, AGGREGATED = "baseline", "baseline_captions", "baseline_aggregated"


def aggregated(graphs: Sequence[ObjectGraph]) -> list[str]:
    """Return the map's instances as captions, one each: "our aggregation turned into text"."""
    return [caption_of(graph) for graph in graphs]


def run(
    mapped: MappedRoom, pairs: Sequence[Pair], baseline: Baseline, nlu: Nlu, *, errors: str
) -> list[QueryOutcome]:
    """Return the outcomes of a recording's pairs for the baseline's rows."""
    room = mapped.room
    spoken = speak().captions(room, ERROR_MODELS[errors], mapped.context.seed)
    views = [[box.caption for box in frame.detections] for frame in spoken]
    merged = aggregated([one.graph for one in mapped.found("tracks", errors).instances])
    graphs = mapped.graphs(errors)
    whole = Truth.of(room.truth, reported_views(room), room.detections)
    outcomes: list[QueryOutcome] = []
    for pair in pairs:
        view = best_view(room.detections, pair)
        _, identity = of_view(graphs[view], room.detections[view])
        frame = [room.detections[view]]
        delivered = Truth.of(room.truth, set(identity.values()), frame)
        shown = Truth.of(room.truth, reported_in(room, [view]), frame)
        one_view = baseline.answer(views[view], pair.instruction)
        said: list[tuple[str, View, Truth, str]] = [
            (BASELINE, "one-view", whole, one_view),
            (BASELINE, "single-view", delivered, one_view),
            (BASELINE, "single-view-shown", shown, one_view),
            (JOINED, "multi-view", whole, baseline.answer_views(views, pair.instruction)),
            (AGGREGATED, "multi-view", whole, baseline.answer(merged, pair.instruction)),
        ]
        for system, where, truth, text in said:
            verdict = judge_text(truth, pair.graph, pair.task, text, parser(nlu))
            outcomes.append(QueryOutcome(pair, system, where, verdict))
    return outcomes


def parser(nlu: Nlu) -> Callable[[str], ObjectGraph | None]:
    """Return nlu's parse of a noun phrase."""
    return lambda phrase: nlu.parse_text(phrase, caption=True).graph
