"""What belongs to what: values to nouns, relations to nouns, with the attachments left open."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from doro_nlu.labels import OBJECT, RELATED, is_noun, is_relation
from doro_nlu.spans import Span
from doro_nlu.words import BREAKERS, COMPANIONS, DETERMINERS, JOINTS, PRONOUNS, is_room


class Link(NamedTuple):
    """A relation: its connector, the landmark (index of noun) and where it may hang.

    ``sources`` are indices of nouns, the preferred one first; more than one = open.
    """

    connector: Span
    target: int
    sources: tuple[int, ...]


class Value(NamedTuple):
    """A self attribute and the noun that it modifies (index of noun)."""

    span: Span
    noun: int


class Sentence:
    """Spans of a tagged sentence, with the object chosen.

    Args:
        tokens: the tokens, any case.
        spans: the spans in order.
        root: the span of the object.
    """

    def __init__(self, tokens: Sequence[str], spans: Sequence[Span], root: Span) -> None:
        self.words = [token.lower() for token in tokens]
        self.spans = spans
        self.nouns = [root, *(span for span in spans if span.kind == RELATED)]
        self.starts = {span.start: index for index, span in enumerate(self.nouns)}
        self.others = [span for span in spans if span.kind == OBJECT and span is not root]

    def second_target(self) -> str:
        """Return the text of an object joined to the first one ("the cup and the plate"), or "".

        Between the two stand "and", "or" or a comma, a determiner and adjectives; a re-mention of
        the same noun is no second target.
        """
        root = self.nouns[0]
        for other in self.others:
            before = [span for span in self.spans if is_noun(span.kind) and span.end <= other.start]
            labelled = {at for span in self.spans for at in range(span.start, span.end)}
            start = max((span.end for span in before), default=other.start)
            gap = [self.words[at] for at in range(start, other.start) if at not in labelled]
            joined = [word for word in gap[:2] if word in JOINTS]
            rest = gap[len(joined) :]
            near = not rest or (rest[0] in DETERMINERS and len(rest) <= 3)
            if root.start < other.start and joined and near and other.text != root.text:
                return other.text
        return ""

    def values(self) -> list[Value]:
        """Return the self attributes with their nouns, without those of parts and of nothing."""
        found = []
        for index, span in enumerate(self.spans):
            if is_noun(span.kind) or is_relation(span.kind):
                continue
            noun = self._noun_of(index)
            if noun is not None:
                found.append(Value(span, noun))
        return found

    def _noun_of(self, index: int) -> int | None:
        """The noun after the value in its own noun phrase, else the one before it."""
        span = self.spans[index]
        at = span.end
        for later in self.spans[index + 1 :]:
            if not self._same_phrase(at, later.start):
                break
            if is_noun(later.kind):
                return self.starts.get(later.start)
            if is_relation(later.kind):
                break
            at = later.end
        if self._is_part(at):
            return None
        return self._before(index, at)

    def _same_phrase(self, start: int, end: int) -> bool:
        between = self.words[start:end]
        return len(between) <= 4 and not any(
            word in DETERMINERS or (word in BREAKERS and word != ",") for word in between
        )

    def _is_part(self, at: int) -> bool:
        """Tell whether the value at ``at`` is of a part ("with a black handle")."""
        follows = self.words[at] if at < len(self.words) else ""
        free = any(span.start == at for span in self.spans)
        if free or not follows.isalpha() or follows in BREAKERS | JOINTS | PRONOUNS:
            return False
        before = self.words[max(0, at - 5) : at]
        return follows not in ("color", "colour") and any(word in COMPANIONS for word in before)

    def _before(self, index: int, at: int) -> int | None:
        if at < len(self.words) and self.words[at] in PRONOUNS:
            return 0
        start = self.spans[index].start
        earlier = [span for span in (*self.nouns, *self.others) if span.end <= start]
        if not earlier:
            return None
        return self.starts.get(max(earlier, key=lambda span: span.start).start)

    def links(self) -> list[Link]:
        """Return the relations that have a landmark; the order is that of the text."""
        found: list[Link] = []
        pending: Span | None = None
        for span in self.spans:
            if is_relation(span.kind):
                pending = span
            elif span.kind == RELATED:
                noun = self.starts[span.start]
                if pending is not None:
                    found.append(Link(pending, noun, self._sources(pending, noun, found)))
                elif found and self._joined(found[-1], span):
                    found.append(Link(found[-1].connector, noun, found[-1].sources))
                pending = None
            elif span.kind == OBJECT:
                pending = None
        return found

    def _joined(self, previous: Link, span: Span) -> bool:
        """Tell whether a landmark without connector shares the one before ("between A and B")."""
        between = self.words[self.nouns[previous.target].end : span.start]
        return bool(between) and between[0] in JOINTS

    def _sources(self, connector: Span, target: int, found: Sequence[Link]) -> tuple[int, ...]:
        earlier = [i for i, noun in enumerate(self.nouns) if noun.end <= connector.start]
        if not earlier:
            return (0,)
        nearest = max(earlier, key=lambda i: self.nouns[i].start)
        if nearest in (0, target):
            return (0,)
        name = self.nouns[nearest].text
        gap = self.words[self.nouns[nearest].end : connector.start]
        grounded = is_room(name) and connector.kind != "is-near"
        attached = any(link.target == nearest for link in found)
        if not attached or grounded:
            return (0,)
        if gap and gap[0] in JOINTS and not _relative(gap):
            return (0, nearest)
        return (nearest, 0)


def _relative(gap: Sequence[str]) -> bool:
    """Tell whether the words open a relative clause, which belongs to the noun before it."""
    return any(word in ("that", "which", "that's") for word in gap)
