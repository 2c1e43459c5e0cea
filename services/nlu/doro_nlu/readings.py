"""The graphs that a sentence may mean: every attachment that is open, the likeliest first."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from doro_nlu.attach import Link, Value
from doro_nlu.spans import Span
from doro_nlu.spelling import repair
from doro_nlu.words import FILLED, NAME_EDGES
from doro_schemas.graph import MAX_DEPTH, ObjectGraph, Relation
from doro_schemas.vocabulary import canonical_name, canonical_value

MAX_READINGS = 13
"""Beside the first one: a chain of four relations has 14 attachments (a Catalan number)."""

MAX_OPEN = 4
DEPARTURE = 0.5
"""What a step away from the likeliest attachment leaves of a reading's confidence: a rank of the
readings, not a measured probability."""


class Attachment(NamedTuple):
    """One way to attach everything: source of each link, noun of each value, and its distance
    from the likeliest one in steps."""

    steps: int
    sources: tuple[int, ...]
    owners: tuple[int, ...]


class Found(NamedTuple):
    """Nouns (the object first), their values and the relations between them."""

    nouns: Sequence[Span]
    values: Sequence[Value]
    links: Sequence[Link]


class Reading(NamedTuple):
    """A graph and the share of the labels' confidence that is left to it."""

    graph: ObjectGraph
    share: float


def readings_of(found: Found) -> list[Reading]:
    """Return the readings, the likeliest first, equal graphs once, ``MAX_READINGS`` + 1 at most."""
    kept: list[Reading] = []
    for way in sorted(attachments(found), key=lambda one: one.steps):
        graph = _build(found, way, 0, 1)
        if all(graph != one.graph for one in kept):
            kept.append(Reading(graph, DEPARTURE**way.steps))
        if len(kept) > MAX_READINGS:
            break
    return kept


def attachments(found: Found) -> Iterator[Attachment]:
    """Yield the ways to attach links and values; the first one has no steps.

    A link hangs on the nearest noun, on what that one hangs on, and so on up to the object: what
    is further left on the right frontier of the tree (no crossing attachments). Only the first
    ``MAX_OPEN`` choices are left open.
    """
    for steps, sources, opened in _sources(found, 0, (0,), 0):
        for more, owners in _owners(found.values, opened):
            yield Attachment(steps + more, sources, owners)


def _sources(
    found: Found, at: int, frontier: tuple[int, ...], opened: int
) -> Iterator[tuple[int, tuple[int, ...], int]]:
    """Yield (steps, sources, open choices) for the links from ``at`` on."""
    if at == len(found.links):
        yield 0, (), opened
        return
    link, root = found.links[at], found.nouns[0]
    if at and found.links[at - 1].start < root.start < link.start:
        frontier = (0,)
    group = 1
    while at + group < len(found.links) and found.links[at + group].joined:
        group += 1
    options = _options(link, frontier)
    if opened >= MAX_OPEN:
        options = options[:1]
    opened += len(options) > 1
    for steps, source in enumerate(options):
        rest = frontier[: frontier.index(source) + 1]
        last = found.links[at + group - 1]
        rest = rest if link.closed else (*rest, last.target)
        for more, sources, total in _sources(found, at + group, rest, opened):
            yield steps + more, (source,) * group + sources, total


def _options(link: Link, frontier: tuple[int, ...]) -> list[int]:
    """Return the nouns that a link may hang on, the likeliest first."""
    nearest_first = [noun for noun in reversed(frontier) if noun not in link.shuns]
    if link.object_first:
        nearest_first.remove(0)
        nearest_first.insert(0, 0)
    if link.prefers in nearest_first:
        nearest_first.remove(link.prefers)
        nearest_first.insert(0, link.prefers)
    return nearest_first


def _owners(values: Sequence[Value], opened: int) -> Iterator[tuple[int, tuple[int, ...]]]:
    """Yield (steps, noun of each value); the values of a list move together."""
    free = list(dict.fromkeys(value.group for value in values if value.noun != value.other))
    free = free[: max(0, MAX_OPEN - opened)]
    for mask in range(1 << len(free)):
        moved = {group for bit, group in enumerate(free) if mask >> bit & 1}
        yield len(moved), tuple(v.other if v.group in moved else v.noun for v in values)


def _build(found: Found, way: Attachment, noun: int, depth: int) -> ObjectGraph:
    """Return the tree under a noun; deeper than ``MAX_DEPTH`` nothing is kept.

    A landmark stands behind its source in the text, or its source is the object: no cycles.
    """
    relations = [
        Relation(link.kind, _build(found, way, link.target, depth + 1), link.inverse)
        for link, source in zip(found.links, way.sources, strict=True)
        if source == noun and depth < MAX_DEPTH
    ]
    own = [v for v, owner in zip(found.values, way.owners, strict=True) if owner == noun]
    return ObjectGraph(
        name=canonical_name(name_of(found.nouns[noun].text)),
        attributes=_attributes(own),
        relations=relations,
    )


def name_of(text: str) -> str:
    """Return a labelled noun phrase without function words at its edges ("picture of") and
    without its contents ("jar full of coins")."""
    words = text.split(" ")
    words = words[: next((at for at in range(1, len(words)) if words[at] in FILLED), len(words))]
    while len(words) > 1 and words[-1] in NAME_EDGES:
        words.pop()
    while len(words) > 1 and words[0] in NAME_EDGES:
        words.pop(0)
    return " ".join(words)


def _attributes(values: Sequence[Value]) -> dict[str, str]:
    """Return values by type, in the order of the types; several of one are joined."""
    found: dict[str, list[str]] = {}
    for value in values:
        text = _plain(value.span.text, kind=value.span.kind)
        if text not in found.setdefault(value.span.kind, []):
            found[value.span.kind].append(text)
    return {kind: " and ".join(texts) for kind, texts in sorted(found.items())}


def _plain(value: str, *, kind: str) -> str:
    """Return a value's canonical form, typos repaired, "orange colored" without "colored"."""
    words = repair(value, kind).split(" ")
    if len(words) > 1 and words[-1] in ("colored", "coloured", "color", "colour"):
        words = words[:-1]
    return canonical_value(" ".join(words))
