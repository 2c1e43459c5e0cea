"""QA, AA and BLEU of outcomes, with 95 % intervals over rooms (paper, Section V-D).

- QA: share of pairs whose query is right by the rule of ``judge``.
- AA: F1 of "there is something to ask", every state but CONFIRM being positive; and the F1 over
  the four states, weighted by how often each is true.
- BLEU-4: sacrebleu's corpus BLEU, all true wordings of a pair as its references, 0..1.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Sequence

import msgspec
from sacrebleu.metrics.bleu import BLEU

from doro_evaluation.bootstrap import interval
from doro_evaluation.queries import QueryOutcome

CLEAR = "CONFIRM"


class Score(msgspec.Struct, frozen=True):
    """A figure with its 95 % interval."""

    value: float
    low: float
    high: float


class QueryScores(msgspec.Struct, frozen=True):
    """The figures of one row of Table III or IV; ``faults`` counts what was wrong first."""

    pairs: int
    qa: Score
    aa: Score
    aa_states: Score
    state_accuracy: Score
    bleu: Score
    faults: dict[str, int]


def score_queries(outcomes: Sequence[QueryOutcome], seed: int = 0) -> QueryScores:
    """Return the figures of the outcomes of one system in one view."""
    rooms: dict[str, list[QueryOutcome]] = defaultdict(list)
    for one in outcomes:
        rooms[one.pair.episode].append(one)
    groups = list(rooms.values())

    def scored(statistic: Callable[[list[QueryOutcome]], float]) -> Score:
        return Score(statistic(list(outcomes)), *interval(groups, statistic, seed))

    faults = Counter(one.verdict.fault for one in outcomes if one.verdict.fault)
    return QueryScores(
        pairs=len(outcomes),
        qa=scored(lambda rows: _share(one.verdict.right for one in rows)),
        aa=scored(ambiguity_f1),
        aa_states=scored(states_f1),
        state_accuracy=scored(lambda rows: _share(o.verdict.said == o.verdict.true for o in rows)),
        bleu=bleu(outcomes),
        faults=dict(sorted(faults.items())),
    )


def ambiguity_f1(outcomes: Sequence[QueryOutcome]) -> float:
    """Return the F1 of "something is to be asked or told" (all states but CONFIRM)."""
    said = [one.verdict.said not in (CLEAR, "") for one in outcomes]
    true = [one.verdict.true != CLEAR for one in outcomes]
    hits = sum(a and b for a, b in zip(said, true, strict=True))
    total = sum(said) + sum(true)
    return 2 * hits / total if total else float("nan")


def states_f1(outcomes: Sequence[QueryOutcome]) -> float:
    """Return the F1 over the four states, weighted by their true number."""
    true = Counter(one.verdict.true for one in outcomes)
    said = Counter(one.verdict.said for one in outcomes)
    hits = Counter(o.verdict.true for o in outcomes if o.verdict.said == o.verdict.true)
    f1 = {state: 2 * hits[state] / (true[state] + said[state]) for state in true}
    return sum(f1[state] * count for state, count in true.items()) / max(len(outcomes), 1)


def bleu(outcomes: Sequence[QueryOutcome], draws: int = 1000) -> Score:
    """Return the corpus BLEU-4 against all wordings, with sacrebleu's own bootstrap interval."""
    texts = [one.verdict.text for one in outcomes]
    most = max((len(one.verdict.references) for one in outcomes), default=0)
    streams = [
        [one.verdict.references[k] if k < len(one.verdict.references) else "" for one in outcomes]
        for k in range(most)
    ]
    score = BLEU().corpus_score(texts, streams, n_bootstrap=draws)
    half = score._ci
    return Score(score.score / 100, (score._mean - half) / 100, (score._mean + half) / 100)


def _share(flags: Iterable[bool]) -> float:
    values = list(flags)
    return sum(values) / len(values) if values else float("nan")
