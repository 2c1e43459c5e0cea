"""QA, AA, BLEU and similarity of outcomes, with 95 % intervals over rooms (paper, Section V-D).

- QA: share of pairs whose query is right by the rule of ``judge``.
- AA: F1 of "there is something to ask", every state but CONFIRM being positive; and the F1 over
  the four states, weighted by how often each is true.
- BLEU-4: sacrebleu's corpus BLEU, all true wordings of a pair as its references, 0..1.
- BERTScore and the cosine of sentence vectors: means over pairs of the best true wording.

All are ratios of sums over pairs, so that an interval needs the sums of each room only: rooms are
drawn with replacement, as recordings of one room are not independent.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable, Sequence

import msgspec
import numpy as np
from numpy.typing import NDArray
from sacrebleu.metrics.bleu import BLEU

from doro_evaluation.bootstrap import Score, Statistic, f1, share, tallied
from doro_evaluation.context import room_of
from doro_evaluation.queries.systems import QueryOutcome

__all__ = ["QueryScores", "Score", "ambiguity_f1", "bleu", "score_queries", "states_f1"]

CLEAR = "CONFIRM"
STATES = ("CONFIRM", "INFORM-AMBIGUITY", "INFORM-MISMATCH", "INFORM-MISSING")
ORDERS = 4
Tally = Callable[[QueryOutcome], Sequence[float]]
Floats = NDArray[np.float64]


class QueryScores(msgspec.Struct, frozen=True):
    """The figures of one row of Table III or IV; ``faults`` counts what was wrong first.

    ``bertscore`` and ``cosine`` are absent where their model is not installed.
    """

    pairs: int
    qa: Score
    aa: Score
    aa_states: Score
    state_accuracy: Score
    bleu: Score
    faults: dict[str, int]
    bertscore: Score | None = None
    cosine: Score | None = None


def score_queries(outcomes: Sequence[QueryOutcome], seed: int = 0) -> QueryScores:
    """Return the figures of the outcomes of one system in one view."""

    def scored(tally: Tally, statistic: Statistic) -> Score:
        return tallied(_by_room(outcomes, [tally(one) for one in outcomes]), statistic, seed)

    faults = Counter(one.verdict.fault for one in outcomes if one.verdict.fault)
    more = {
        name: tallied(_by_room(outcomes, [(value, 1.0) for value in values]), share, seed)
        for name in ("bertscore", "cosine")
        if (values := _values(outcomes, name))
    }
    return QueryScores(
        pairs=len(outcomes),
        qa=scored(lambda one: (one.verdict.right, 1), share),
        aa=scored(_ambiguity, f1),
        aa_states=scored(_states, _weighted_f1),
        state_accuracy=scored(lambda one: (one.verdict.said == one.verdict.true, 1), share),
        bleu=bleu(outcomes, seed),
        faults=dict(sorted(faults.items())),
        **more,
    )


def ambiguity_f1(outcomes: Sequence[QueryOutcome]) -> float:
    """Return the F1 of "something is to be asked or told" (all states but CONFIRM)."""
    return _of_all(_ambiguity, f1, outcomes)


def states_f1(outcomes: Sequence[QueryOutcome]) -> float:
    """Return the F1 over the four states, weighted by their true number."""
    return _of_all(_states, _weighted_f1, outcomes)


def bleu(outcomes: Sequence[QueryOutcome], seed: int = 0) -> Score:
    """Return the corpus BLEU-4 against all wordings; the sums are sacrebleu's of each sentence."""
    metric = BLEU(effective_order=True)
    tallies = []
    for one in outcomes:
        found = metric.sentence_score(one.verdict.text, one.verdict.references or [""])
        tallies.append([*found.counts, *found.totals, found.sys_len, found.ref_len])
    return tallied(_by_room(outcomes, tallies), _corpus_bleu, seed)


def _corpus_bleu(sums: Floats) -> Floats:
    """Return sacrebleu's corpus BLEU, 0..1, of rows (4 counts, 4 totals, lengths)."""
    values = []
    for row in sums.astype(int).tolist():
        counts, totals, (said, meant) = row[:ORDERS], row[ORDERS : 2 * ORDERS], row[-2:]
        values.append(BLEU.compute_bleu(counts, totals, said, meant, smooth_method="exp").score)
    return np.array(values) / 100


def _values(outcomes: Sequence[QueryOutcome], name: str) -> list[float]:
    """Return a value for each outcome; none where one of them has none."""
    values = [getattr(one, name) for one in outcomes]
    return [] if None in values else [float(value) for value in values]


def _ambiguity(one: QueryOutcome) -> tuple[bool, bool, bool]:
    said, true = one.verdict.said not in (CLEAR, ""), one.verdict.true != CLEAR
    return said and true, said, true


def _states(one: QueryOutcome) -> list[float]:
    hits = [one.verdict.said == one.verdict.true == state for state in STATES]
    said = [one.verdict.said == state for state in STATES]
    return [*hits, *said, *(one.verdict.true == state for state in STATES)]


def _weighted_f1(sums: Floats) -> Floats:
    hits, said, true = np.split(sums, 3, axis=1)
    each = 2 * hits / np.maximum(said + true, 1)
    return np.asarray((each * true).sum(axis=1) / true.sum(axis=1))


def _of_all(tally: Tally, statistic: Statistic, outcomes: Sequence[QueryOutcome]) -> float:
    sums = np.array([tally(one) for one in outcomes], dtype=np.float64).sum(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        return float(statistic(sums[None])[0])


def _by_room(outcomes: Sequence[QueryOutcome], tallies: Sequence[Sequence[float]]) -> Floats:
    """Return the sums by room, (rooms, k), rooms by name."""
    rooms: dict[str, list[Sequence[float]]] = defaultdict(list)
    for one, tally in zip(outcomes, tallies, strict=True):
        rooms[room_of(one.pair.episode)].append(tally)
    return np.array([np.sum(rooms[name], axis=0) for name in sorted(rooms)], dtype=np.float64)
