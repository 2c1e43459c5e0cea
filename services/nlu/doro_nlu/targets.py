"""Which noun is the target: the object among several, landmarks told from it, second targets."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import NamedTuple

from doro_nlu.labels import OBJECT, RELATED, is_noun, is_relation
from doro_nlu.spans import Span
from doro_nlu.words import (
    BREAKERS,
    COMPANIONS,
    COPULAS,
    DETERMINERS,
    FETCH_VERBS,
    JOINTS,
    MODALS,
    NEGATORS,
    NO_THINGS,
    NOT_TARGETS,
    PARTICLES,
    PRONOUNS,
    RELATIVES,
    THIRD,
)

_NEAR = "is-near"
_LOOK_BACK = 5
_LONGEST_PHRASE = 5
_BEFORE_COMPANION = frozenset(
    [",", "that", "which", "is", "are", "'s", "that's", "filled", "up", "out"]
)
_ALSO = (["along", "with"], ["together", "with"], ["as", "well"])
_EXCLUDING = (["instead", "of"], ["rather", "than"])
_SEQUENCE = frozenset(["and", ",", ";", ".", "then", "also", "next", "&"])


class Settled(NamedTuple):
    """The spans with the target chosen: it is the only one that counts as object.

    ``second`` is the text of another target beside it, or empty.
    """

    root: Span
    spans: list[Span]
    second: str


def settle(words: Sequence[str], spans: Sequence[Span]) -> Settled | None:
    """Choose the target among the spans labelled object; None without one.

    Args:
        words: the tokens in lower case.
        spans: the tagger's spans in order.
    """
    spans = [_without_question(words, span) for span in _without_excluded(words, spans)]
    objects = [span for span in spans if span.kind == OBJECT and _names_a_thing(span.text)]
    if not objects:
        return None
    free = [span for span in objects if not _after_connector(words, spans, span)] or objects
    root = next((span for span in free if not is_negated(words, span.start)), free[0])
    settled: list[Span] = []
    for span in spans:
        other = span.kind == OBJECT and span is not root and has_letter(span.text)
        landmark = other and _is_landmark(words, spans, settled, root, span)
        settled.append(span._replace(kind=RELATED) if landmark else span)
    second = (
        _second_by_joint(words, settled, root)
        or _second_by_verb(words, settled, root)
        or _second_by_one(words, settled, root)
        or _second_by_value(words, settled, root)
    )
    return Settled(root, settled, second)


def has_letter(text: str) -> bool:
    """Tell whether a text can name something."""
    return any(char.isalpha() for char in text)


def _without_excluded(words: Sequence[str], spans: Sequence[Span]) -> list[Span]:
    """Return the spans without those after "instead of" and "rather than", to the clause's end."""
    barred: set[int] = set()
    for at in range(len(words) - 1):
        if list(words[at : at + 2]) in _EXCLUDING:
            end = at + 2
            while end < len(words) and words[end].isalnum() and words[end] not in FETCH_VERBS:
                end += 1
            barred.update(range(at, end))
    kept = []
    for span in spans:
        inside = next((at for at in range(span.start, span.end) if at in barred), span.end)
        if inside > span.start:
            text = " ".join(words[span.start : inside])
            kept.append(span if inside == span.end else span._replace(end=inside, text=text))
    return kept


def _without_question(words: Sequence[str], span: Span) -> Span:
    """Cut back a noun that runs into the next question: "... in the office can you get it"."""
    asks = words[span.end - 1] in MODALS and words[span.end : span.end + 1] in (["you"], ["we"])
    if not (asks and is_noun(span.kind) and span.end - span.start > 1):
        return span
    end = span.end - 1
    return span._replace(end=end, text=" ".join(words[span.start : end]))


def _names_a_thing(text: str) -> bool:
    return has_letter(text) and text not in NO_THINGS


def is_negated(words: Sequence[str], start: int) -> bool:
    """Tell whether what begins at ``start`` is excluded: "not the red cup", "I don't want tea"."""
    for at in range(start - 1, max(-1, start - 1 - _LOOK_BACK), -1):
        if words[at] in (BREAKERS - {"not"}) | JOINTS:
            return False
        if words[at] in NEGATORS:
            return True
    return False


def gap_before(words: Sequence[str], spans: Sequence[Span], start: int) -> list[str]:
    """Return the unlabelled words between the noun before ``start`` and ``start``."""
    end = max((span.end for span in spans if is_noun(span.kind) and span.end <= start), default=0)
    labelled = {at for span in spans for at in range(span.start, span.end)}
    return [words[at] for at in range(end, start) if at not in labelled]


def brings_contents(gap: Sequence[str]) -> bool:
    """Tell whether the words between two nouns say that the first has the second: "with the",
    "which has a", "filled with"; not "along with the", "while holding the"."""
    rest = list(gap)
    while rest and rest[0] in _BEFORE_COMPANION:
        rest.pop(0)
    return bool(rest) and rest[0] in COMPANIONS and len(rest) <= _LONGEST_PHRASE


def _after_connector(words: Sequence[str], spans: Sequence[Span], noun: Span) -> bool:
    """Tell whether a relation stands right before the noun phrase ("next to the knife")."""
    before = [span for span in spans if span.end <= noun.start and not _is_value(span)]
    if not before or not is_relation(before[-1].kind):
        return False
    gap = words[before[-1].end : noun.start]
    return len(gap) <= _LONGEST_PHRASE and not any(
        word in THIRD or word in JOINTS or word in FETCH_VERBS or (word in BREAKERS)
        or word in ("there", "i", "you")
        for word in gap
    )  # fmt: skip


def _is_value(span: Span) -> bool:
    return not is_noun(span.kind) and not is_relation(span.kind)


def _is_landmark(
    words: Sequence[str], spans: Sequence[Span], settled: Sequence[Span], root: Span, span: Span
) -> bool:
    """Tell whether a noun labelled object is a landmark of the target before it.

    Right after a connector; one more thing to be near to ("next to the knife and the fork": a
    thing is near several, but on or in one place, so after on and at it is a second target);
    contents ("the tray that has a sponge on it"); what the target carries ("the table that the
    television is on").
    """
    if span.start < root.start:
        return False
    if _after_connector(words, spans, span):
        return True
    nouns = [item for item in settled if is_noun(item.kind)]
    gap = gap_before(words, spans, span.start)
    after = words[span.end : span.end + 2]
    if nouns and nouns[-1] is not root and gap and gap[0] in JOINTS and _short(gap[1:]):
        if brings_contents(gap_before(words, settled, nouns[-1].start)):
            return True
        connectors = [item for item in settled if is_relation(item.kind)]
        own = any(is_relation(item.kind) and item.start == span.end for item in spans)
        return bool(connectors) and connectors[-1].kind == _NEAR and not own
    if not gap or any(word in JOINTS for word in gap):
        return False
    carried = gap[0] in RELATIVES and _short(gap[1:]) and bool(after) and after[0] in COPULAS
    return carried or brings_contents(gap)


def _short(gap: Sequence[str]) -> bool:
    return not gap or (gap[0] in DETERMINERS and len(gap) <= 3)


def _second_by_joint(words: Sequence[str], spans: Sequence[Span], root: Span) -> str:
    """Return an object joined to what stands before it: "the cup and the plate".

    Between the two stand "and", "or" or a comma, a determiner and adjectives; a re-mention of
    the same noun is no second target.
    """
    for other in _others(spans, root):
        gap = gap_before(words, spans, other.start)
        also = 2 if gap[:2] in _ALSO else 0
        joined = gap[:also] or [word for word in gap[:2] if word in JOINTS]
        rest = gap[len(joined) + (gap[also : also + 1] == ["as"]) :]
        if joined and _short(rest) and not is_negated(words, other.start):
            return other.text
    return ""


def _others(spans: Sequence[Span], root: Span) -> list[Span]:
    return [
        span
        for span in spans
        if span.kind == OBJECT and span.start > root.start and span.text != root.text
    ]


def _second_by_verb(words: Sequence[str], spans: Sequence[Span], root: Span) -> str:
    """Return what a second clause wants fetched: "bring the cup and bring the plate".

    The clause begins with a joint and a verb that brings things, as the first one does, or with
    "along with"; what follows is a noun phrase, no pronoun, no re-mention of the target, no "take
    a left".
    """
    if not any(word in FETCH_VERBS for word in words[: root.start]):
        return ""
    for at in range(root.end, len(words) - 1):
        also = words[at : at + 2] in _ALSO
        if also or (words[at] in FETCH_VERBS and words[at - 1] in _SEQUENCE):
            start = at + 1 + also + (words[at : at + 3] == ["as", "well", "as"])
            while start < len(words) and words[start] in PARTICLES | {"me", "us"}:
                start += 1
            noun = _phrase_at(words, spans, start, any_noun=also)
            if noun and not _mentions(words[start : start + _LONGEST_PHRASE], noun, root):
                return noun
    return ""


def _second_by_one(words: Sequence[str], spans: Sequence[Span], root: Span) -> str:
    """Return another thing of the same kind: "the red cup and the blue one"."""
    own = [span.kind for span in spans if _is_value(span) and 0 < root.start - span.end + 1 <= 3]
    for span in spans:
        start = span.start - 1
        while start > root.end and words[start] in DETERMINERS:
            start -= 1
        joined = span.start > root.end and words[start] in ("and", "or") and start < span.start - 1
        one = words[span.end : span.end + 1] in (["one"], ["ones"])
        if joined and one and _is_value(span) and span.kind in own:
            return f"{span.text} one"
    return ""


def _second_by_value(words: Sequence[str], spans: Sequence[Span], root: Span) -> str:
    """Return a choice of values: "the purple or the pink balloon"; "a red and white cup" is one."""
    before = [span for span in spans if span.end <= root.start]
    for first, other in itertools.pairwise(before):
        gap = words[first.end : other.start]
        alike = _is_value(first) and first.kind == other.kind
        choice = gap[:1] == ["or"] or (gap[:1] == ["and"] and len(gap) > 1)
        if alike and choice and _short(gap[1:]) and root.start - other.end <= 1:
            return f"{other.text} {root.text}"
    return ""


def _phrase_at(words: Sequence[str], spans: Sequence[Span], start: int, *, any_noun: bool) -> str:
    """Return the noun phrase that begins with a determiner at ``start``, without it, or "".

    Args:
        any_noun: a landmark's label counts as well.
    """
    if start >= len(words) or words[start] not in DETERMINERS - {"those", "these", "another"}:
        return ""
    for span in spans:
        if is_noun(span.kind) and start < span.start <= start + 3:
            return span.text if any_noun or span.kind != RELATED else ""
    end = start + 1
    inside = {at for span in spans for at in range(span.start, span.end) if not _is_value(span)}
    while end < min(len(words), start + 4) and end not in inside and words[end].isalpha():
        if words[end] in BREAKERS | JOINTS | DETERMINERS | PARTICLES | COMPANIONS or (
            words[end] in ("to", "from", "at", "into", "back", "next", "near", "by", "for", "then")
        ):
            break
        end += 1
    found = words[start + 1 : end]
    if not found or found[0] in NOT_TARGETS or found[-1] in PRONOUNS | NOT_TARGETS:
        return ""
    return " ".join(found)


def _mentions(phrase: Sequence[str], noun: str, root: Span) -> bool:
    """Tell whether a later noun phrase is the target again ("put the cup away")."""
    own = root.text.split(" ")
    return own[-1] in phrase or own[0] in phrase or noun.rsplit(" ", maxsplit=1)[-1] in own
