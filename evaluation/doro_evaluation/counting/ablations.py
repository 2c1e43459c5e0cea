"""What the parts of the mapper are worth: counting and queries with each of them left out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import msgspec
from rich.table import Table

from doro_evaluation.bootstrap import Score
from doro_evaluation.context import Context
from doro_evaluation.counting.metrics import intervals, measure
from doro_evaluation.figures import Figure
from doro_evaluation.outcomes import Outcome
from doro_evaluation.queries.scores import score_queries
from doro_evaluation.queries.systems import QueryOutcome

RECORDINGS = 24
"""Of the paper's 102 test recordings, evenly spread over their names."""
ERRORS = ("cs+sd+fn", "all")
QUERY_ERRORS = "cs+sd+fn"


class Ablation(msgspec.Struct, frozen=True):
    """A part of the mapper left out; ``changes`` are settings of the mapper."""

    name: str
    title: str
    changes: Mapping[str, Any]

    def of(self, context: Context) -> Context:
        """Return the context with the part left out."""
        mapper = msgspec.structs.replace(context.mapper, **self.changes)
        return msgspec.structs.replace(context, mapper=mapper)


ABLATIONS = (
    Ablation("full", "all parts", {}),
    Ablation("no_soft_mask", "no soft mask: all pixels of a box weigh the same", {"sigma": 1e3}),
    Ablation(
        "no_cannot_link",
        "no cannot-link: things seen in one frame may be merged",
        {"without": ("cannot_link",)},
    ),
    Ablation(
        "no_observability",
        "no observability: views that should have seen a thing and did not say nothing",
        {"without": ("observability",)},
    ),
    Ablation("no_persistence", "no persistence: one view makes an instance", {"min_hits": 1}),
    Ablation(
        "no_voting",
        "no voting: the first view says what a thing is and where",
        {"without": ("voting",)},
    ),
)


class AblationResult(msgspec.Struct, frozen=True):
    """What came out: by error model the counting outcomes, and the queries."""

    ablation: Ablation
    outcomes: Mapping[str, Sequence[Outcome]]
    queries: Sequence[QueryOutcome]


def counted(outcomes: Sequence[Outcome]) -> Score:
    """Return the average F1 of counting with its interval over rooms."""
    return Score(measure(outcomes)["average/f1"], *intervals(outcomes)["average/f1"])


def scores_of(result: AblationResult) -> dict[str, Score]:
    """Return the figures of a row: F1 by error model, exact counts, QA, BLEU."""
    scores = {f"{errors}/average/f1": counted(found) for errors, found in result.outcomes.items()}
    for errors, found in result.outcomes.items():
        exact = Score(measure(found)["accuracy"], *intervals(found)["accuracy"])
        scores[f"{errors}/accuracy"] = exact
    rows = sorted(
        (one for one in result.queries if one.view == "multi-view"), key=lambda one: one.pair.id
    )
    if rows:
        asked = score_queries(rows)
        scores |= {"qa": asked.qa, "aa": asked.aa, "bleu": asked.bleu}
    return scores


def figures_of(results: Sequence[AblationResult]) -> dict[str, Figure]:
    """Return ``ablations/<name>/<metric>`` with the bounds of the 95 % interval."""
    figures: dict[str, Figure] = {}
    for result in results:
        for metric, score in scores_of(result).items():
            name = f"ablations/{result.ablation.name}/{metric}"
            figures[name] = round(score.value, 4)
            figures[f"{name}_low"] = round(score.low, 4)
            figures[f"{name}_high"] = round(score.high, 4)
    return figures


def table_of(results: Sequence[AblationResult]) -> Table:
    """Return a row for each part left out."""
    heads = list(scores_of(results[0]))
    recordings = len(next(iter(results[0].outcomes.values())))
    pairs = sum(one.view == "multi-view" for one in results[0].queries)
    title = f"Ablations on {recordings} test recordings, {pairs} pairs (cs+sd+fn)"
    table = Table("left out", *heads, title=title)
    for result in results:
        scores = scores_of(result)
        cells = [
            f"{scores[head].value:.3f} [{scores[head].low:.2f}, {scores[head].high:.2f}]"
            for head in heads
        ]
        table.add_row(result.ablation.title, *cells)
    return table
