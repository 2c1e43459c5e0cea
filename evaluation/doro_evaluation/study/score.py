"""``doro study score``: ratings by system, how far raters agree, and whether replies resolve.

A reply is understood by the dialogue's own core, against the query that the participant saw
and what the system that asked it knew. The true measure of a question is whether the thing
that was wanted is found by the reply to it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Literal

import msgspec
import numpy as np
from numpy.typing import NDArray

from doro_dialogue.answer_lines import answer_record
from doro_evaluation.study.agreement import krippendorff_alpha
from doro_evaluation.study.files import (
    SCALES,
    Answers,
    Asked,
    Item,
    Rating,
    Study,
    Unit,
    passed_checks,
    read_answers,
)
from doro_schemas.errors import Refused
from doro_schemas.graph import ObjectGraph

DRAWS = 2000
REPLY = "reply"
Parse = Callable[[str], ObjectGraph | None]
Outcome = Literal["resolved", "wrong", "asked_again", "cannot_tell"]
OUTCOMES: tuple[Outcome, ...] = ("resolved", "wrong", "asked_again", "cannot_tell")


class Word(msgspec.Struct, frozen=True):
    """One participant's word on one system in one scene.

    Attributes:
        outcome: what the reply comes to; None where nothing was wanted, or nothing said.
    """

    participant: str
    item: str
    unit: str
    system: str
    rating: Rating
    outcome: Outcome | None


class Score(msgspec.Struct, frozen=True):
    """A mean with its 95 % interval over participants and scenes.

    Attributes:
        count: number of values; mean, median, low and high are NaN without any.
    """

    count: int
    mean: float
    median: float
    low: float
    high: float


class Scores(msgspec.Struct, frozen=True):
    """What a study comes to.

    Attributes:
        problems: a sentence for each file that does not count.
        failed: participants who failed an attention check; they do not count either.
        by_system: for each system and scale, and ``reply``: the share of replies that resolve.
        by_item: the same by system, scene and scale.
        replies: how many replies came to what, by system.
        agreement: Krippendorff's alpha by scale, ordinal and interval.
        differences: mean of the first system minus that of another, by system and scale.
    """

    participants: list[str]
    failed: list[str]
    problems: list[str]
    by_system: dict[str, dict[str, Score]]
    by_item: dict[str, dict[str, dict[str, Score]]]
    replies: dict[str, dict[str, int]]
    agreement: dict[str, dict[str, float | None]]
    differences: dict[str, dict[str, Score]]
    words: list[Word]


def read_all(paths: Sequence[Path], study: Study) -> tuple[list[Answers], list[str]]:
    """Return the files that fit, and a sentence for each that does not."""
    good: list[Answers] = []
    problems: list[str] = []
    for path in paths:
        try:
            one = read_answers(path, study)
        except Refused as refused:
            problems.append(refused.reason)
            continue
        if any(other.participant == one.participant for other in good):
            problems.append(f"{path}: the answers of '{one.participant}' are there already")
            continue
        good.append(one)
    return good, problems


def score_study(
    study: Study, files: Sequence[Answers], problems: Sequence[str], parse: Parse, seed: int = 0
) -> Scores:
    """Return the scores of a study.

    Args:
        parse: nlu's parser, for the replies.
        seed: of the bootstrap.
    """
    passed = [one for one in files if passed_checks(one, study)]
    words = [word for one in passed for word in words_of(study, one, parse)]
    by_system: dict[str, dict[str, Score]] = {}
    differences: dict[str, dict[str, Score]] = {}
    for system in study.systems:
        by_system[system] = {
            what: _score(_table(words, system, what), seed) for what in (*SCALES, REPLY)
        }
    for system in study.systems[1:]:
        differences[system] = {
            what: _difference(
                _table(words, study.systems[0], what), _table(words, system, what), seed
            )
            for what in (*SCALES, REPLY)
        }
    return Scores(
        participants=[one.participant for one in passed],
        failed=[one.participant for one in files if one not in passed],
        problems=list(problems),
        by_system=by_system,
        by_item=_by_item(study, words, seed),
        replies=_replies(study, words),
        agreement={scale: _agreement(words, scale) for scale in SCALES},
        differences=differences,
        words=words,
    )


def words_of(study: Study, answers: Answers, parse: Parse) -> Iterator[Word]:
    """Yield a participant's ratings, once for every system that said the text."""
    units = {unit.id: (item, unit) for item in study.items for unit in item.units}
    for rating in answers.answers:
        item, unit = units[rating.unit]
        for system in study.systems:
            if system in unit.asked:
                outcome = outcome_of(item, unit, unit.asked[system], rating, parse)
                yield Word(answers.participant, item.id, unit.id, system, rating, outcome)


def outcome_of(
    item: Item, unit: Unit, asked: Asked, rating: Rating, parse: Parse
) -> Outcome | None:
    """Return what a reply comes to: the wanted thing, another, or another question."""
    if not item.wanted:
        return None
    if not rating.reply.strip():
        return "cannot_tell" if rating.cannot_tell else None
    record = {
        "id": unit.id,
        "graph": msgspec.to_builtins(asked.graph or item.graph),
        "task": item.task,
        "instances": msgspec.to_builtins(asked.instances),
        "query": {
            "text": asked.text,
            "clauses": msgspec.to_builtins(asked.clauses),
            "state": asked.state,
        },
        "answer": rating.reply,
    }
    found = answer_record(record, parse)
    targets = found.get("targets", [])
    if not targets:
        return "asked_again"
    return "resolved" if set(targets) <= set(asked.intended) else "wrong"


def _value(word: Word, what: str) -> float | None:
    if what == REPLY:
        return None if word.outcome is None else float(word.outcome == "resolved")
    return float(getattr(word.rating, what))


def _table(words: Sequence[Word], system: str, what: str) -> NDArray[np.float64]:
    """Return participants x scenes, NaN where nobody said anything; means of several texts."""
    people = sorted({word.participant for word in words})
    items = sorted({word.item for word in words})
    sums = np.zeros((len(people), len(items)))
    counts = np.zeros_like(sums)
    for word in words:
        value = _value(word, what)
        if word.system == system and value is not None:
            place = people.index(word.participant), items.index(word.item)
            sums[place] += value
            counts[place] += 1
    return np.where(counts > 0, sums / np.maximum(counts, 1), np.nan)


def _score(table: NDArray[np.float64], seed: int) -> Score:
    values = table[~np.isnan(table)]
    if not len(values):
        return Score(0, np.nan, np.nan, np.nan, np.nan)
    low, high = _interval([table], seed)
    return Score(len(values), float(values.mean()), float(np.median(values)), low, high)


def _difference(first: NDArray[np.float64], other: NDArray[np.float64], seed: int) -> Score:
    a, b = first[~np.isnan(first)], other[~np.isnan(other)]
    if not (len(a) and len(b)):
        return Score(0, np.nan, np.nan, np.nan, np.nan)
    low, high = _interval([first, other], seed)
    middle = float(np.median(a) - np.median(b))
    return Score(min(len(a), len(b)), float(a.mean() - b.mean()), middle, low, high)


def _interval(tables: Sequence[NDArray[np.float64]], seed: int) -> tuple[float, float]:
    """Return the 95 % interval of the mean, or of the difference of two means.

    Participants and scenes are both drawn again, with replacement (A. Owen, The pigeonhole
    bootstrap, 2007): another study would have other people and other rooms.
    """
    people, items = tables[0].shape
    rng = np.random.default_rng([seed, people, items])
    rows = rng.multinomial(people, np.full(people, 1 / people), DRAWS).astype(np.float64)
    columns = rng.multinomial(items, np.full(items, 1 / items), DRAWS).astype(np.float64)
    means = []
    for table in tables:
        said = ~np.isnan(table)
        totals = np.einsum("dp,pi,di->d", rows, np.where(said, table, 0.0), columns)
        weights = np.einsum("dp,pi,di->d", rows, said.astype(np.float64), columns)
        means.append(totals / np.where(weights > 0, weights, np.nan))
    drawn = means[0] if len(means) == 1 else means[0] - means[1]
    low, high = np.nanpercentile(drawn, [2.5, 97.5])
    return float(low), float(high)


def _by_item(
    study: Study, words: Sequence[Word], seed: int
) -> dict[str, dict[str, dict[str, Score]]]:
    return {
        system: {
            item.id: {
                what: _score(
                    _table([word for word in words if word.item == item.id], system, what), seed
                )
                for what in (*SCALES, REPLY)
            }
            for item in study.items
        }
        for system in study.systems
    }


def _replies(study: Study, words: Sequence[Word]) -> dict[str, dict[str, int]]:
    found = {}
    for system in study.systems:
        counts = Counter(word.outcome for word in words if word.system == system)
        found[system] = {str(outcome): counts[outcome] for outcome in OUTCOMES}
    return found


def _agreement(words: Sequence[Word], scale: str) -> dict[str, float | None]:
    """Return alpha over the texts rated; a text that two systems say is one text."""
    by_unit: dict[str, dict[str, int]] = {}
    for word in words:
        by_unit.setdefault(word.unit, {})[word.participant] = getattr(word.rating, scale)
    ratings = [list(by_unit[unit].values()) for unit in sorted(by_unit)]
    return {
        "ordinal": krippendorff_alpha(ratings, "ordinal"),
        "interval": krippendorff_alpha(ratings, "interval"),
    }
