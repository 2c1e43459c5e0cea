"""What belongs to what: values to nouns, relations to nouns, with the attachments left open."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from doro_nlu.contents import Contents
from doro_nlu.labels import RELATED, is_noun, is_relation
from doro_nlu.spans import Span
from doro_nlu.targets import has_letter, is_negated
from doro_nlu.words import (
    BREAKERS,
    COMPANIONS,
    DETERMINERS,
    JOINTS,
    NEGATORS,
    PRONOUNS,
    STRANDED,
    is_room,
    is_surface,
)

_SHORT_GAP = 3
_NAMING_AGAIN = frozenset(["it", "it's", "its", "they", "they're"])


class Link(NamedTuple):
    """A relation that a landmark stands in, and what decides where it hangs.

    Attributes:
        kind: of the relation.
        target: the landmark (index of noun).
        spans: what was labelled for it: connector (if any) and landmark.
        start: token where it begins.
        inverse: the landmark is on or in what it hangs on ("the tray with the sponge on it").
        object_first: the object is the likelier place, not the nearest landmark.
        joined: it hangs where the link before it hangs ("between A and B").
        closed: nothing that follows hangs on the landmark ("with an apple in it").
        shuns: nouns that it cannot hang on although they stand before it.
        prefers: the noun that a dependency parse hangs it on; -1 = no such parse.
    """

    kind: str
    target: int
    spans: tuple[Span, ...]
    start: int
    inverse: bool = False
    object_first: bool = False
    joined: bool = False
    closed: bool = False
    shuns: tuple[int, ...] = ()
    prefers: int = -1


class Value(NamedTuple):
    """A self attribute: the noun that it modifies and, where open, the other one (index of noun).

    Values of one list ("red and plastic") have one ``group`` and are moved together.
    """

    span: Span
    noun: int
    other: int
    group: int


class Sentence:
    """Spans of a tagged sentence, with the target chosen; see :mod:`doro_nlu.targets`.

    Args:
        tokens: the tokens, any case.
        spans: the spans in order.
        root: the span of the target.
    """

    def __init__(self, tokens: Sequence[str], spans: Sequence[Span], root: Span) -> None:
        self.words = [token.lower() for token in tokens]
        self.spans = spans
        self.nouns = [root, *(span for span in spans if span.kind == RELATED)]
        self.starts = {span.start: index for index, span in enumerate(self.nouns)}
        self.contents = Contents(self.words, spans, root)

    # -- values ---------------------------------------------------------------------------

    def values(self) -> list[Value]:
        """Return the self attributes with their nouns, without those of parts, of nothing and
        those that are excluded ("that isn't red")."""
        found: list[Value] = []
        end = -1
        for index, span in enumerate(self.spans):
            if is_noun(span.kind) or is_relation(span.kind):
                continue
            if self._is_excluded(span):
                continue
            place = self._place_of(index)
            if place is None:
                continue
            listed = found and all(word in JOINTS for word in self.words[end : span.start])
            group = found[-1].group if listed and found[-1][1:3] == place else span.start
            found.append(Value(span, *place, group))
            end = span.end
        return found

    def _is_excluded(self, span: Span) -> bool:
        before = self.words[max(0, span.start - 2) : span.start]
        while before and before[-1] in DETERMINERS:
            before.pop()
        if before and before[-1] == "but":  # "any cup but the red one"; not "not red but blue"
            return not any(word in NEGATORS for word in self.words[: span.start])
        return bool(before) and (before[-1] in NEGATORS or before[-1] == "non")

    def _place_of(self, index: int) -> tuple[int, int] | None:
        """The noun after the value in its own noun phrase, else the one before it."""
        span = self.spans[index]
        at = span.end
        for later in self.spans[index + 1 :]:
            if not self._same_phrase(at, later.start):
                break
            if is_noun(later.kind):
                noun = self.starts.get(later.start)
                return None if noun is None else (noun, noun)
            if is_relation(later.kind):
                break
            at = later.end
        return None if self._is_part(at) else self._before(span, at)

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

    def _before(self, span: Span, at: int) -> tuple[int, int] | None:
        """The noun before a value; after a landmark the object is the other choice.

        After a comma or "and" the object is the likelier one ("the cup on the desk, red"), and
        the only one where a pronoun names it ("the red one", "it's blue").
        """
        earlier = [item for item in self.spans if is_noun(item.kind) and item.end <= span.start]
        if at < len(self.words) and self.words[at] in PRONOUNS:
            return (0, 0)
        nearest = self.starts.get(earlier[-1].start) if earlier else None
        if nearest is None:
            return None
        gap = self._gap(earlier[-1].end, span.start)
        if nearest == 0 or any(word in _NAMING_AGAIN for word in gap):
            return (0, 0)
        if self.nouns[0].start > span.start:
            return (nearest, nearest)
        joined = bool(gap) and gap[0] in JOINTS and not is_relative(gap)
        return (0, nearest) if joined else (nearest, 0)

    def _gap(self, start: int, end: int) -> list[str]:
        labelled = {at for span in self.spans for at in range(span.start, span.end)}
        return [self.words[at] for at in range(start, end) if at not in labelled]

    # -- relations ------------------------------------------------------------------------

    def links(self) -> list[Link]:
        """Return the relations that have a landmark; the order is that of the text."""
        found: list[Link] = []
        pending: Span | None = None
        for span in self.spans:
            if is_relation(span.kind):
                pending = span
            elif span.kind == RELATED:
                link = self._link(span, pending, found)
                if link is not None and has_letter(span.text):
                    found.append(link)
                pending = None
            elif is_noun(span.kind):
                pending = None
        return found

    def _link(self, span: Span, pending: Span | None, found: Sequence[Link]) -> Link | None:
        noun = self.starts[span.start]
        carried = self.contents.carried(span, pending)
        if carried is not None:
            spans = (span,) if carried.connector is None else (carried.connector, span)
            kind, inverse = carried.kind, carried.kind != "is-near"
            link = Link(kind, noun, spans, span.start, inverse, closed=carried.closed)
            return link._replace(shuns=self._shunned(carried.bars_surfaces))
        if pending is not None and not self.contents.is_stranded(pending):
            if is_negated(self.words, pending.start) and self._not_before(pending):
                return None
            first = self._prefers_object(pending, found)
            link = Link(pending.kind, noun, (pending, span), pending.start, object_first=first)
            return link._replace(shuns=self._rooms() if pending.kind != "is-near" else ())
        if found and self._is_joined(found[-1], span):
            before = found[-1]
            return before._replace(target=noun, spans=(*before.spans[:-1], span), joined=True)
        return self._unlabelled(span, noun)

    def _unlabelled(self, span: Span, noun: int) -> Link | None:
        """Read a preposition that the tagger left out: "the chair by the fireplace"."""
        earlier = [one for one in self.spans if one.end <= span.start and is_noun(one.kind)]
        gap = self._gap(earlier[-1].end, span.start) if earlier else []
        kind = STRANDED.get(gap[0], "") if gap else ""
        if not kind or len(gap) > _SHORT_GAP or any(word in JOINTS for word in gap):
            return None
        shuns = self._rooms() if kind != "is-near" else ()
        return Link(kind, noun, (span,), earlier[-1].end, shuns=shuns)

    def _not_before(self, pending: Span) -> bool:
        """Tell whether a negation stands right before a connector ("not on the table")."""
        return pending.start > 0 and self.words[pending.start - 1] in NEGATORS

    def _rooms(self) -> tuple[int, ...]:
        """A thing that is on or at something stands there, not the room before it."""
        return tuple(i for i, noun in enumerate(self.nouns) if i and is_room(noun.text))

    def _shunned(self, bars_surfaces: bool) -> tuple[int, ...]:
        if not bars_surfaces:
            return ()
        return tuple(i for i, noun in enumerate(self.nouns) if i and is_surface(noun.text))

    def _is_joined(self, previous: Link, span: Span) -> bool:
        """Tell whether a landmark without connector shares the one before ("between A and B")."""
        gap = self._gap(self.nouns[previous.target].end, span.start)
        return bool(gap) and gap[0] in JOINTS

    def _prefers_object(self, connector: Span, found: Sequence[Link]) -> bool:
        """After a joint, and after contents: "a vase with flowers on the shelf" is a vase there."""
        earlier = [noun for noun in self.nouns if noun.end <= connector.start]
        if not earlier:
            return False
        nearest = max(earlier, key=lambda noun: noun.start)
        gap = self._gap(nearest.end, connector.start)
        if gap and gap[0] in JOINTS and not is_relative(gap):
            return True
        return bool(found) and found[-1].inverse


def is_relative(gap: Sequence[str]) -> bool:
    """Tell whether the words open a relative clause, which belongs to the noun before it."""
    return any(word in ("that", "which", "that's") for word in gap)
