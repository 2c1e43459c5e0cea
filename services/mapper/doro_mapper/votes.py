"""What the views say of one thing: class, attributes, relations, and the best views."""

from __future__ import annotations

import bisect
from collections.abc import Iterable
from dataclasses import dataclass

from doro_mapper.sightings import Sighting
from doro_schemas.graph import ObjectGraph, identity
from doro_schemas.messages import Evidence
from doro_schemas.vocabulary import name_satisfies

NAME_SHARE = 0.25
MOST_EVIDENCE = 8
MOST_VALUES = 32
"""Values kept per attribute, classes per thing, relations per thing; the weakest goes first."""


@dataclass(slots=True)
class Stated:
    """A relation that captions state: in how many views, and which landmarks with what weight."""

    views: int
    variants: dict[str, float]
    graphs: dict[str, ObjectGraph]


Shown = tuple[float, int, Evidence]
"""Weight (negated, so that the best sorts first), serial, view."""


class Votes:
    """Votes of the sightings of one thing, weighted by evidence. Memory: bounded, about 3 kB.

    Attributes:
        names: by class; a detector's class distribution is spread over the classes.
        attributes: by type and value.
        stated: by (relation, landmark's class, inverse).
        evidence: the best views.
        doubt: how many sightings are wrong by the scores of a detector that knows how sure it
            is (a calibrated one); others are taken at their word.
    """

    __slots__ = ("_look", "attributes", "doubt", "evidence", "names", "stated")

    def __init__(self) -> None:
        self.names: dict[str, float] = {}
        self.attributes: dict[str, dict[str, float]] = {}
        self.stated: dict[tuple[str, str, bool], Stated] = {}
        self.evidence: list[Shown] = []
        self.doubt = 0.0
        self._look: tuple[str, dict[str, str]] | None = None

    def add(self, sighting: Sighting) -> None:
        """Count one sighting."""
        weight, graph = sighting.weight, sighting.graph
        self._look = None
        self.doubt += sighting.doubt
        total = sum(one.probability for one in sighting.classes)
        if total <= 0:
            _count(self.names, graph.name, weight)
        for one in sighting.classes if total > 0 else ():
            _count(self.names, one.name, weight * one.probability / total)
        for kind, value in graph.attributes.items():
            _count(self.attributes.setdefault(kind, {}), value, weight)
        for relation in graph.relations:
            key = (relation.type, relation.target.name, relation.inverse)
            known = self.stated.setdefault(key, Stated(0, {}, {}))
            known.views += 1
            text = identity(relation.target)
            known.graphs[text] = ObjectGraph(relation.target.name, relation.target.attributes)
            _count(known.variants, text, weight)
        if len(self.stated) > MOST_VALUES:
            del self.stated[min(self.stated, key=lambda key: (self.stated[key].views, key))]
        shown = Evidence(sighting.camera, sighting.frame, list(sighting.box_px), sighting.caption)
        self._show((-weight, sighting.serial, shown))

    def _show(self, shown: Shown) -> None:
        if len(self.evidence) < MOST_EVIDENCE or shown[:2] < self.evidence[-1][:2]:
            bisect.insort(self.evidence, shown, key=_strongest)
            del self.evidence[MOST_EVIDENCE:]

    def take(self, other: Votes) -> None:
        """Add all of another thing's votes."""
        self._look = None
        for name, weight in other.names.items():
            _count(self.names, name, weight)
        for kind, values in other.attributes.items():
            for value, weight in values.items():
                _count(self.attributes.setdefault(kind, {}), value, weight)
        for key, stated in other.stated.items():
            known = self.stated.setdefault(key, Stated(0, {}, {}))
            known.views += stated.views
            known.graphs.update(stated.graphs)
            for text, weight in stated.variants.items():
                _count(known.variants, text, weight)
        self.doubt += other.doubt
        for shown in other.evidence:
            self._show(shown)

    def look(self) -> tuple[str, dict[str, str]]:
        """Return (class, value by attribute type) with most evidence."""
        if self._look is None:
            best = {kind: ranked(values)[0] for kind, values in sorted(self.attributes.items())}
            self._look = voted_name(self.names), best
        return self._look

    def second(self) -> dict[str, str]:
        """Return by attribute type the second most seen value, if any."""
        order = {kind: ranked(values) for kind, values in sorted(self.attributes.items())}
        return {kind: values[1] for kind, values in order.items() if len(values) > 1}

    def classes(self) -> list[tuple[str, float]]:
        """Return the fused class distribution, most probable first."""
        total = sum(self.names.values())
        return [(name, self.names[name] / total) for name in ranked(self.names)]


def _strongest(shown: Shown) -> tuple[float, int]:
    return shown[:2]


def merged_look(parts: list[Votes]) -> tuple[str, dict[str, str]]:
    """Return what several tracks together look like."""
    out = Votes()
    for part in parts:
        for name, weight in part.names.items():
            _count(out.names, name, weight)
        for kind, values in part.attributes.items():
            for value, weight in values.items():
                _count(out.attributes.setdefault(kind, {}), value, weight)
    return out.look()


def merged(parts: Iterable[Votes]) -> Votes:
    """Return the votes of several tracks together."""
    out = Votes()
    for part in parts:
        out.take(part)
    return out


def _count(votes: dict[str, float], key: str, weight: float) -> None:
    votes[key] = votes.get(key, 0.0) + weight
    if len(votes) > MOST_VALUES:
        del votes[ranked(votes)[-1]]


def ranked(votes: dict[str, float]) -> list[str]:
    """Return the values by votes, most first; equal votes in alphabetical order."""
    return sorted(votes, key=lambda value: (-votes[value], value))


def voted_name(votes: dict[str, float]) -> str:
    """Return the class: votes for a hypernym count for its kinds ("lamp" for "desk lamp")."""
    if len(votes) == 1:
        return next(iter(votes))
    total = sum(votes.values())
    backed = {
        name: sum(w for other, w in votes.items() if name_satisfies(other, name))
        for name, weight in votes.items()
        if weight >= NAME_SHARE * total
    }
    return ranked(backed or votes)[0]
