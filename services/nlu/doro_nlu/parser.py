"""Labels to graph: the paper's deterministic tag-to-graph parser (Section IV-A).

Grammar, with the mixing that real sentences need: ``r -> (at_S | at_R)*``, ``at_S -> av_S``,
``at_R -> av_R``, ``av_R -> (at_S | at_R)*``. A value goes to the noun it modifies, a relation to
the nearest noun before it, a fronted one to the object; where a later relation may as well be
one of the object, the other graphs are kept as readings.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import NamedTuple

from doro_nlu.attach import Link, Sentence, Value
from doro_nlu.labels import OBJECT
from doro_nlu.spans import Span, spans_of
from doro_nlu.spelling import repair
from doro_nlu.tagger import Tagged
from doro_nlu.task import task_of
from doro_schemas.graph import MAX_DEPTH, ObjectGraph, Relation
from doro_schemas.vocabulary import canonical_name, canonical_value

MAX_READINGS = 7
MAX_OPEN = 4
MAX_RELATIONS = 64


class Parse(NamedTuple):
    """What a tagged sentence says; ``graph`` is None with a ``reason``, or the reason is empty.

    ``second`` names another target beside the object ("the cup and the plate"), else empty.
    """

    graph: ObjectGraph | None
    readings: list[ObjectGraph]
    task: str
    confidence: float
    reason: str
    object_probability: float = 0.0
    second: str = ""


class Found(NamedTuple):
    """Nouns (the object first), their values and the relations between them."""

    nouns: Sequence[Span]
    values: Sequence[Value]
    links: Sequence[Link]


def parse(tagged: Tagged, text: str) -> Parse:
    """Return the graph of a tagged sentence; ``text`` is for the reason's sentence."""
    spans = spans_of(*tagged)
    root = next((span for span in spans if span.kind == OBJECT and _names(span.text)), None)
    if root is None:
        return Parse(None, [], "", 0.0, no_object(text))
    sentence = Sentence(tagged.tokens, spans, root)
    values, links = sentence.values(), sentence.links()[:MAX_RELATIONS]
    links = [link for link in links if _names(sentence.nouns[link.target].text)]
    choices = _choices(links)
    found = Found(sentence.nouns, values, links)
    graphs = [_build(found, choice, 0, 1) for choice in choices]
    readings: list[ObjectGraph] = []
    for graph in graphs[1:]:
        if graph != graphs[0] and graph not in readings:
            readings.append(graph)
    task = task_of(tagged.tokens, tagged.labels, root.start, root.end)
    reached = {0, *(link.target for link in links)}
    used = [root, *(value.span for value in values if value.noun in reached)]
    used += [span for link in links for span in (link.connector, sentence.nouns[link.target])]
    confidence = min(span.probability for span in used)
    return Parse(
        graphs[0],
        readings[:MAX_READINGS],
        task,
        confidence,
        "",
        root.probability,
        sentence.second_target(),
    )


def no_object(text: str) -> str:
    """Return the reason for a text without an object; long texts are shortened."""
    shown = text.strip() if len(text.strip()) <= 80 else text.strip()[:77] + "..."
    return f"no object to fetch or find was named in '{shown}'"


def _names(text: str) -> bool:
    return any(char.isalpha() for char in text)


def _choices(links: Sequence[Link]) -> list[tuple[int, ...]]:
    """Return source per link for each reading, the preferred one first; a few open at most."""
    groups: dict[int, tuple[int, ...]] = {}
    for link in links:  # landmarks of one connector ("between A and B") hang together
        opened = sum(len(sources) > 1 for sources in groups.values())
        sources = link.sources if opened < MAX_OPEN else link.sources[:1]
        groups.setdefault(link.connector.start, sources)
    choices = []
    for combination in itertools.product(*groups.values()):
        chosen = dict(zip(groups, combination, strict=True))
        choices.append(tuple(chosen[link.connector.start] for link in links))
    return choices


def _build(found: Found, sources: Sequence[int], noun: int, depth: int) -> ObjectGraph:
    """Return the tree under a noun; deeper than ``MAX_DEPTH`` nothing is kept.

    A landmark stands behind its source in the text, or its source is the object: no cycles.
    """
    relations = [
        Relation(link.connector.kind, _build(found, sources, link.target, depth + 1))
        for link, source in zip(found.links, sources, strict=True)
        if source == noun and depth < MAX_DEPTH
    ]
    return ObjectGraph(
        name=canonical_name(found.nouns[noun].text),
        attributes=_attributes(noun, found.values),
        relations=relations,
    )


def _attributes(noun: int, values: Sequence[Value]) -> dict[str, str]:
    """Return the values of a noun by type, in the order of the types; several are joined."""
    found: dict[str, list[str]] = {}
    for value in values:
        if value.noun == noun:
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
