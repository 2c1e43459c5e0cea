"""One-sided, three-valued matching: does all that was said hold of an instance?

Every fact that was said is held against what was observed and gets one verdict: ``holds``,
``contradicted`` or ``unknown``. What was observed and not said does not matter (DESIGN,
"Decision" and "Conventions of meaning"). The rules are listed in the README.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Literal

import msgspec

from doro_dialogue.facts import (
    IS_AT,
    IS_NEAR,
    IS_ON,
    WORDS_CACHED,
    Attribute,
    Fact,
    facts_of,
    graph_with,
    name_of,
    value_of,
    words,
)
from doro_schemas.graph import ObjectGraph, Relation
from doro_schemas.vocabulary import name_satisfies

Verdict = Literal["holds", "contradicted", "unknown"]

KIND_OF = {
    "navy": "blue",
    "scarlet": "red",
    "crimson": "red",
    "maroon": "red",
    "burgundy": "red",
    "violet": "purple",
    "charcoal": "gray",
    "steel": "metal",
    "iron": "metal",
    "aluminum": "metal",
    "aluminium": "metal",
    "brass": "metal",
    "copper": "metal",
    "bronze": "metal",
    "oak": "wood",
    "pine": "wood",
    "walnut": "wood",
    "porcelain": "ceramic",
    "cotton": "fabric",
    "linen": "fabric",
    "wool": "fabric",
}
"""A value and the broader one that it is a kind of."""

CLOSE = frozenset(
    frozenset(pair)
    for pair in (
        ("silver", "gray"),
        ("gold", "yellow"),
        ("cream", "white"),
        ("ivory", "white"),
        ("beige", "tan"),
        ("tan", "brown"),
        ("ceramic", "clay"),
        ("fabric", "cloth"),
    )
)
"""Values that a camera or a person may take for one another: never the same, never excluded."""

ROOMS = words(
    "room kitchen bedroom bathroom hall hallway house apartment office garage basement attic"
    " pantry lounge upstairs downstairs"
)
"""Places of another scale: a cup in the sink may be in the kitchen."""

OPEN_FURNITURE = words("shelf sofa bed chair stool bench rack")
"""Landmarks that enclose nothing: "in the arm chair" and "on the arm chair" are one place."""

PLACE = (IS_ON, IS_AT)


class Finding(msgspec.Struct, frozen=True):
    """One said fact held against an instance.

    Attributes:
        said: the fact as the person said it.
        verdict: whether it holds.
        seen: what was observed in its place, cut down to what the verdict rests on;
            None where nothing was.
    """

    said: Fact
    verdict: Verdict
    seen: Fact | None = None


class Match(msgspec.Struct, frozen=True):
    """All said facts held against one instance, in the documented order of facts."""

    verdict: Verdict
    findings: list[Finding]

    def of(self, verdict: Verdict) -> list[Finding]:
        """Return the findings with this verdict."""
        return [finding for finding in self.findings if finding.verdict == verdict]


def match(said: ObjectGraph, seen: ObjectGraph) -> Match:
    """Hold what was said of an object against an instance of its class (names aside)."""
    findings = [
        _attribute(fact, seen) if isinstance(fact, Attribute) else _relation(fact, seen)
        for fact in facts_of(said)
    ]
    return Match(worst([finding.verdict for finding in findings]), findings)


def difference(said: ObjectGraph, seen: ObjectGraph) -> ObjectGraph:
    """Return g - Ig of Section IV-C: what was said and does not hold of the instance."""
    findings = match(said, seen).findings
    return graph_with(said.name, [f.said for f in findings if f.verdict != "holds"])


def worst(verdicts: list[Verdict]) -> Verdict:
    """Return the verdict of a conjunction; nothing said holds."""
    if "contradicted" in verdicts:
        return "contradicted"
    return "unknown" if "unknown" in verdicts else "holds"


@lru_cache(WORDS_CACHED)
def compare_name(said: str, seen: str) -> Verdict:
    """Compare class names: a kind holds, a broader word leaves it open, others contradict."""
    if name_satisfies(said, seen):
        return "holds"
    return "unknown" if name_satisfies(seen, said) else "contradicted"


@lru_cache(WORDS_CACHED)
def compare_value(said: str, seen: str) -> Verdict:
    """Compare two values of one attribute.

    "blue" holds of dark blue, navy and "blue and white"; "dark blue" said and blue seen is
    unknown, since the shade was not observed; dark blue and light blue contradict.
    """
    want, have = value_of(said), value_of(seen)
    if want in broader_values(have):
        return "holds"
    if have in broader_values(want) or frozenset((want, have)) in CLOSE:
        return "unknown"
    return "contradicted"


@lru_cache(WORDS_CACHED)
def broader_values(value: str) -> tuple[str, ...]:
    """Return a canonical value and all broader ones that it implies, itself first."""
    found = [value]
    for one in found:
        parts = one.split(" and ")
        split = one.split(" ")
        more = parts if len(parts) > 1 else [" ".join(split[i:]) for i in range(1, len(split))]
        found += [v for v in (*more, KIND_OF.get(one, one)) if v not in found]
    return tuple(found)


@lru_cache(WORDS_CACHED)
def is_room(name: str) -> bool:
    """Tell whether a landmark is a room or larger."""
    return name_of(name).split(" ")[-1] in ROOMS


def fits(said: str, seen: str, landmark: str) -> bool:
    """Tell whether a place relation ``seen`` at a landmark is one that ``said`` means.

    is-at holds "at" and "from" as well as "in", so that is-on satisfies it ("from the desk").
    """
    open_furniture = name_of(landmark).split(" ")[-1] in OPEN_FURNITURE
    return said in (seen, IS_AT) or open_furniture


def _attribute(said: Attribute, seen: ObjectGraph) -> Finding:
    value = seen.attributes.get(said.type)
    if value is None:
        return Finding(said, "unknown")
    return Finding(said, compare_value(said.value, value), Attribute(said.type, value))


def _relation(said: Relation, seen: ObjectGraph) -> Finding:
    """Hold a said relation against all observed ones: any that holds decides, then any open."""
    place = _place if said.type in PLACE else _open_list
    compare = _carried if said.inverse else place
    same_way = [relation for relation in seen.relations if relation.inverse == said.inverse]
    results = [compare(said, relation) for relation in same_way]
    for verdict in ("holds", "unknown", "contradicted"):
        for finding in results:
            if finding is not None and finding.verdict == verdict:
                return finding
    return Finding(said, "unknown")


def _place(said: Relation, seen: Relation) -> Finding | None:
    """Compare where a thing was said to be with one relation; None: says nothing about it."""
    if seen.type not in PLACE:
        return None
    target = _landmark(said.target, seen.target)
    fitting = fits(said.type, seen.type, seen.target.name)
    if fitting and target.verdict == "holds":
        return _found(said, "holds", seen, target)
    # On a tray that is on the table is on the table.
    beyond = _relation(said, seen.target) if seen.target.relations else None
    if beyond is not None and beyond.verdict == "holds" and isinstance(beyond.seen, Relation):
        nested = ObjectGraph(name=seen.target.name, relations=[beyond.seen])
        return Finding(said, "holds", Relation(seen.type, nested))
    if not fitting:
        compared = target.verdict == "holds"
    else:
        compared = is_room(said.target.name) == is_room(seen.target.name)
    if fitting and target.verdict == "unknown":
        return _found(said, "unknown", seen, target)
    return _found(said, "contradicted", seen, target) if compared else None


def _open_list(said: Relation, seen: Relation) -> Finding | None:
    """Compare is-near, or a type of another label set: being near one thing excludes no other.

    Only a landmark of the class said whose own facts contradict does; and a thing that lies
    on or in the landmark is not near it (the rule of ``doro_schemas.spatial``).
    """
    target = _landmark(said.target, seen.target)
    if said.type != seen.type:
        lies_there = said.type == IS_NEAR and seen.type in PLACE and target.verdict == "holds"
        return _found(said, "contradicted", seen, target) if lies_there else None
    if compare_name(said.target.name, seen.target.name) == "contradicted":
        return None
    return _found(said, target.verdict, seen, target)


def _carried(said: Relation, seen: Relation) -> Finding | None:
    """Compare what a thing was said to have on or in it with one thing that it has.

    A tray with a sponge may have a spoon as well, so only the thing said can say anything, and
    a tray on which no sponge was seen may still have had one out of view: absence is unknown.
    """
    target = _landmark(said.target, seen.target)
    if target.verdict != "contradicted" and said.type in (seen.type, IS_AT):
        return _found(said, target.verdict, seen, target)
    return None


class _Landmark(msgspec.Struct, frozen=True):
    verdict: Verdict
    graph: ObjectGraph


def _landmark(said: ObjectGraph, seen: ObjectGraph) -> _Landmark:
    """Match a landmark, name included, and cut the seen one down to what was compared."""
    name = compare_name(said.name, seen.name)
    if name == "contradicted":
        return _Landmark("contradicted", ObjectGraph(name=seen.name))
    result = match(said, seen)
    compared = [finding.seen for finding in result.findings if finding.seen is not None]
    return _Landmark(worst([name, result.verdict]), graph_with(seen.name, compared))


def _found(said: Relation, verdict: Verdict, seen: Relation, target: _Landmark) -> Finding:
    return Finding(said, verdict, Relation(seen.type, target.graph, seen.inverse))
