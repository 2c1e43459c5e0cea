"""Inverse relations: what the object holds or carries ("the tray with the sponge on it")."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from doro_nlu.labels import is_noun, is_relation
from doro_nlu.spans import Span
from doro_nlu.targets import brings_contents, gap_before
from doro_nlu.words import (
    BREAKERS,
    COPULAS,
    DETERMINERS,
    JOINTS,
    RELATIVES,
    STRANDED,
    THIRD,
    TOOL_VERBS,
)

HELD = "is-at"
"""What "a box with a cup" says: the cup is there, on or in it."""

_INSIDE = frozenset(["in", "inside", "within", "into"])
_LONGEST_PHRASE = 4


class Carried(NamedTuple):
    """How a landmark is held or carried.

    Attributes:
        kind: the relation of the landmark to what carries it.
        connector: the span labelled for it, if any.
        closed: the phrase ends with the connector ("in it"), what follows is said of others.
        bars_surfaces: it is inside, so that no table or shelf carries it.
    """

    kind: str
    connector: Span | None
    closed: bool
    bars_surfaces: bool


class Contents:
    """Finds the landmarks of a sentence that the object, or another landmark, carries.

    Args:
        words: the tokens in lower case.
        spans: the spans in order, the target chosen.
        root: the span of the target.
    """

    def __init__(self, words: Sequence[str], spans: Sequence[Span], root: Span) -> None:
        self.words, self.spans, self.root = words, spans, root
        self._tool = any(word in TOOL_VERBS for word in words[: root.start])

    def carried(self, noun: Span, pending: Span | None) -> Carried | None:
        """Return how a landmark is carried; None where it is an ordinary one.

        Args:
            pending: the connector before it that has no landmark yet.
        """
        if noun.start < self.root.start:
            return None
        if pending is not None and not self.is_stranded(pending):
            # "the box in which the cup is", "the shelf on which there is a radio"
            which = self.words[pending.end : pending.end + 1] in (["which"], ["whom"])
            return Carried(pending.kind, pending, True, False) if which else None
        gap = gap_before(self.words, self.spans, noun.start)
        after = self._stranded_after(noun)
        if brings_contents(gap):
            return self._with(noun, after)
        clause = bool(gap) and gap[0] in RELATIVES and len(gap) <= 3
        return self._clause(noun, after) if clause else None

    def is_stranded(self, connector: Span) -> bool:
        """Tell whether a connector has no landmark after it: "on it", or the clause ends.

        "from the counter" has one, "in which the cup is" as well.
        """
        end = connector.end
        if end >= len(self.words) or self.words[end] in THIRD:
            return True
        if self.words[end] in JOINTS or (self.words[end] in BREAKERS and self.words[end] != "with"):
            return self.words[end] not in RELATIVES
        later = [span for span in self.spans if span.start >= end]
        for span in later:
            if is_relation(span.kind):
                return True
            if is_noun(span.kind):
                return False
        return True

    def _with(self, noun: Span, after: Span | None) -> Carried | None:
        if after is not None:
            inside = self.words[after.start] in _INSIDE
            return Carried(after.kind, after, True, inside)
        where, what, *_ = [*self.words[noun.end : noun.end + 2], "", ""]
        if where in STRANDED and (what in THIRD or not what):
            return Carried(STRANDED[where], None, True, where in _INSIDE)
        return None if self._tool else Carried(HELD, None, False, False)

    def _clause(self, noun: Span, after: Span | None) -> Carried | None:
        """Read "that the television is on": a copula, then a preposition without landmark."""
        if after is not None:
            between = self.words[noun.end : after.start]
            verb = all(word in COPULAS | {"currently", "now", "right"} for word in between)
            return Carried(after.kind, after, True, False) if verb else None
        rest = self.words[noun.end : noun.end + 3]
        while rest and rest[0] in COPULAS and len(rest) > 1:
            rest = rest[1:]
            if rest[0] in STRANDED:
                return Carried(STRANDED[rest[0]], None, True, rest[0] in _INSIDE)
        return Carried(HELD, None, True, False) if rest and rest[0] in COPULAS else None

    def _stranded_after(self, noun: Span) -> Span | None:
        """Return the stranded connector that ends the phrase of a landmark, if there is one.

        More landmarks may be joined in between: "with a knife and a fork in it".
        """
        at = noun.end
        for span in self.spans:
            if span.start < noun.end:
                continue
            gap = [word for word in self.words[at : span.start] if word not in DETERMINERS]
            joined = is_noun(span.kind) and bool(gap) and gap[0] in JOINTS
            if len(gap) > _LONGEST_PHRASE or (is_noun(span.kind) and not joined):
                return None
            if is_relation(span.kind):
                return span if self.is_stranded(span) else None
            at = span.end
        return None
