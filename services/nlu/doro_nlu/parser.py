"""Labels to graph: the paper's deterministic tag-to-graph parser (Section IV-A).

Grammar, with the mixing that real sentences need: ``r -> (at_S | at_R)*``, ``at_S -> av_S``,
``at_R -> av_R``, ``av_R -> (at_S | at_R)*``. A value goes to the noun it modifies, a relation to
the nearest noun before it, a fronted one to the object (:mod:`doro_nlu.attach`); where something
may as well belong to another noun, the other graphs are kept (:mod:`doro_nlu.readings`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from doro_nlu.attach import Link, Sentence, Value
from doro_nlu.readings import Found, Reading, readings_of
from doro_nlu.reasons import Reason, no_object, two_targets
from doro_nlu.spans import Span, spans_of
from doro_nlu.tagger import Tagged
from doro_nlu.targets import settle
from doro_nlu.task import task_of
from doro_schemas.graph import ObjectGraph

MAX_RELATIONS = 64


class Parse(NamedTuple):
    """What a tagged sentence says.

    Attributes:
        graph: the likeliest reading; None where the sentence names no object.
        readings: the other readings, each with its share of ``confidence``.
        task: the verb phrase.
        confidence: lowest probability among the labels that made the graph.
        reason: why there is no graph.
        object_probability: that of the object's labels.
        second: why two targets make it no instruction (a caption has its graph all the same).
    """

    graph: ObjectGraph | None
    readings: list[Reading]
    task: str
    confidence: float
    reason: Reason | None
    object_probability: float = 0.0
    second: Reason | None = None


def refused(reason: Reason) -> Parse:
    """Return the parse of a text that is not understood."""
    return Parse(None, [], "", 0.0, reason)


def parse(tagged: Tagged, text: str, heads: Mapping[int, int] | None = None) -> Parse:
    """Return the graph of a tagged sentence.

    Args:
        tagged: tokens, labels and their probabilities.
        text: for the reason's sentence.
        heads: by the first token of a span, a token of the noun that a dependency parse hangs it
            on (:mod:`doro_nlu.dependencies`): the first reading follows it.
    """
    words = [token.lower() for token in tagged.tokens]
    settled = settle(words, spans_of(*tagged))
    if settled is None:
        return refused(no_object(words, text))
    root = settled.root
    sentence = Sentence(tagged.tokens, settled.spans, root)
    links = sentence.links()[:MAX_RELATIONS]
    values = sentence.values()
    if heads:
        links, values = _by_heads(sentence.nouns, links, values, heads)
    first, *others = readings_of(Found(sentence.nouns, values, links))
    second = two_targets(first.graph.name, settled.second) if settled.second else None
    return Parse(
        first.graph,
        others,
        task_of(tagged.tokens, tagged.labels, root.start, root.end),
        _confidence(root, values, links),
        None,
        root.probability,
        second,
    )


def _by_heads(
    nouns: Sequence[Span], links: Sequence[Link], values: Sequence[Value], heads: Mapping[int, int]
) -> tuple[list[Link], list[Value]]:
    """Return links and values with the nouns that a dependency parse names put first."""
    owner = {at: index for index, noun in enumerate(nouns) for at in range(noun.start, noun.end)}

    def noun_of(*spans: Span) -> int:
        named = [heads[span.start] for span in spans if span.start in heads]
        return owner.get(named[0], -1) if named else -1

    hung = [link._replace(prefers=noun_of(*link.spans)) for link in links]
    moved = [
        value._replace(noun=value.other, other=value.noun)
        if noun_of(value.span) == value.other != value.noun
        else value
        for value in values
    ]
    return hung, moved


def _confidence(root: Span, values: Sequence[Value], links: Sequence[Link]) -> float:
    reached = {0, *(link.target for link in links)}
    used = [root, *(value.span for value in values if value.noun in reached)]
    used += [span for link in links for span in link.spans]
    return min(span.probability for span in used)
