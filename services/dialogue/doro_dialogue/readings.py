"""Several readings of one instruction: which decision they share, or what to ask.

"The cup on the table near the sink": either may be near the sink. Where the readings single
out different things the ambiguity is in the words, and the question is about the words
(DESIGN, "Tagger"); where they do not, nothing is asked about it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import msgspec

from doro_dialogue.decision import Decision, Judged
from doro_dialogue.facts import Attribute, Candidate, Fact, facts_of, natural_order, value_of
from doro_dialogue.surface import definite, predicate
from doro_schemas.graph import ObjectGraph, Relation

Rule = Callable[[ObjectGraph, Sequence[Candidate]], Decision]
Slot = tuple[str, str, int]
MAX_READINGS = 16


class Holder(msgspec.Struct, frozen=True):
    """Something that the open words may belong to.

    Attributes:
        name: its class ("table").
        text: how it is called in the question ("the white table").
        is_object: it is the thing wanted itself.
        readings: the readings in which the words belong to it, the preferred one first.
        decision: what they come to.
    """

    name: str
    text: str
    is_object: bool
    readings: list[ObjectGraph]
    decision: Decision


class Split(msgspec.Struct, frozen=True):
    """What is open: a fact, and two or more things that it may be said of.

    Attributes:
        fact: the relation or attribute.
        words: the same in English ("near the sink").
        holders: the thing wanted first, then landmarks in order of the sentence.
    """

    fact: Fact
    words: str
    holders: list[Holder]


class Read(msgspec.Struct, frozen=True):
    """The decision over all readings; ``split`` is None where none of them needs a question."""

    decision: Decision
    split: Split | None = None


class _Place(msgspec.Struct, frozen=True):
    """Where a fact hangs in one reading."""

    owner: ObjectGraph
    depth: int
    fact: Fact


def decide_readings(
    readings: Sequence[ObjectGraph], instances: Sequence[Candidate], rule: Rule
) -> Read:
    """Decide every reading; where they differ in state or matches, find what to ask.

    A reading under which nothing matches, and that nothing observed speaks against for the
    matches of another, is no reason to ask: its answer would be the same instance.

    Args:
        readings: the preferred one first.

    Raises:
        Refused: as the rule does.
    """
    graphs = list(readings)[:MAX_READINGS]
    decisions = [rule(graph, instances) for graph in graphs]
    kept = _speaking(decisions)
    if len({_substance(decisions[i]) for i in kept}) == 1:
        return Read(decisions[kept[0]])
    split = _split([graphs[i] for i in kept], [decisions[i] for i in kept])
    if split is None:
        return Read(decisions[kept[0]])
    return Read(_over_all(graphs[kept[0]], [decisions[i] for i in kept]), split)


def without_open(split: Split) -> ObjectGraph:
    """Return the sentence without the open words, which belong to neither."""
    return _dropped(split.holders[0].readings[0], split.fact)


def _speaking(decisions: Sequence[Decision]) -> list[int]:
    """Return the readings that count: those that match something come first."""
    matching = [i for i, one in enumerate(decisions) if one.matches]
    matched = [set(decisions[i].matches) for i in matching]

    def silent(decision: Decision) -> bool:
        open_ids = {one.candidate.id for one in decision.open}
        return any(ids <= open_ids for ids in matched)

    rest = [i for i, one in enumerate(decisions) if not one.matches and not silent(one)]
    return sorted([*matching, *rest]) if matching else rest


def _substance(decision: Decision) -> tuple[str, tuple[str, ...]]:
    return decision.state, tuple(decision.matches)


def _over_all(graph: ObjectGraph, decisions: Sequence[Decision]) -> Decision:
    """Return one decision with the best verdict that any reading gives each instance."""
    best: dict[str, Judged] = {}
    order = ("holds", "unknown", "contradicted")
    for one in (judged for decision in decisions for judged in decision.judged):
        kept = best.setdefault(one.candidate.id, one)
        if order.index(one.match.verdict) < order.index(kept.match.verdict):
            best[one.candidate.id] = one
    ids = [one.id for one in natural_order([judged.candidate for judged in best.values()])]
    judged = [best[name] for name in ids]
    offered = [one for one in judged if one.match.verdict == "holds"]
    return Decision(graph, "INFORM-AMBIGUITY", "readings", judged, offered or judged)


def _split(graphs: Sequence[ObjectGraph], decisions: Sequence[Decision]) -> Split | None:
    """Return the first open fact, in order of the sentence, whose place changes the decision."""
    places = [_places(graph) for graph in graphs]
    fallback: Split | None = None
    for slot in places[0]:
        parts: dict[tuple[object, ...], list[int]] = {}
        for i, found in enumerate(places):
            if slot in found:
                parts.setdefault(_identity(found[slot]), []).append(i)
        if len(parts) < 2 or sum(map(len, parts.values())) < len(graphs):
            continue
        found_at = [(places[part[0]][slot], part) for part in parts.values()]
        results = [{_substance(decisions[i]) for i in part} for part in parts.values()]
        if any(one != results[0] for one in results):
            return _asked(found_at, graphs, decisions)
        # Two open facts may matter only together: then the first is as good as the second.
        fallback = fallback or _asked(found_at, graphs, decisions)
    return fallback


def _asked(
    found_at: list[tuple[_Place, list[int]]],
    graphs: Sequence[ObjectGraph],
    decisions: Sequence[Decision],
) -> Split:
    found_at = sorted(found_at, key=lambda one: one[0].depth)
    fact = found_at[0][0].fact
    texts = _called([place for place, _ in found_at])
    holders = [
        Holder(
            name=place.owner.name,
            text=text,
            is_object=place.depth == 0,
            readings=[graphs[i] for i in part],
            decision=decisions[part[0]],
        )
        for (place, part), text in zip(found_at, texts, strict=True)
    ]
    bare = fact if isinstance(fact, Attribute) else _bare(fact)
    return Split(fact, predicate([bare]), holders)


def _called(places: Sequence[_Place]) -> list[str]:
    """Return what each holder is called: its noun with its own attributes, never the open one."""
    texts = []
    for place in places:
        own = {
            key: value
            for key, value in place.owner.attributes.items()
            if not (isinstance(place.fact, Attribute) and place.fact.type == key)
        }
        texts.append(definite(ObjectGraph(name=place.owner.name, attributes=own)))
    if len(set(texts)) == len(texts):
        return texts
    # "the cup near the cup near the sink": by adjectives they are one and the same.
    beside = [text.replace("the ", "the other ", 1) for text in texts]
    return [
        f"{text} that you want" if place.depth == 0 else other
        for place, text, other in zip(places, texts, beside, strict=True)
    ]


def _places(graph: ObjectGraph) -> dict[Slot, _Place]:
    """Return where each fact of a reading hangs; equal facts are numbered in order."""
    found: dict[Slot, _Place] = {}
    level = [(graph, 0)]
    while level:
        node, depth = level.pop(0)
        for fact in facts_of(node):
            if isinstance(fact, Attribute):
                key = (fact.type, value_of(fact.value))
            else:
                key = (fact.type, definite(_without_relations(fact.target)))
                level.append((fact.target, depth + 1))
            number = sum(slot[:2] == key for slot in found)
            found[(*key, number)] = _Place(node, depth, fact)
    return found


def _identity(place: _Place) -> tuple[object, ...]:
    """Return what tells the owner of an open fact from another: noun, depth, other attributes."""
    own = sorted(place.owner.attributes.items())
    if isinstance(place.fact, Attribute):
        own = [(key, value) for key, value in own if key != place.fact.type]
    return (place.owner.name, min(place.depth, 1), tuple(own))


def _without_relations(graph: ObjectGraph) -> ObjectGraph:
    return ObjectGraph(name=graph.name, attributes=graph.attributes)


def _bare(relation: Relation) -> Relation:
    return msgspec.structs.replace(relation, target=_without_relations(relation.target))


def _dropped(graph: ObjectGraph, fact: Fact) -> ObjectGraph:
    own = {k: v for k, v in graph.attributes.items() if Attribute(k, v) != fact}
    relations = [
        msgspec.structs.replace(one, target=_dropped(one.target, fact))
        for one in graph.relations
        if one != fact
    ]
    return ObjectGraph(graph.name, own, relations)
