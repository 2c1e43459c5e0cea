"""What an answer is held against: the question as it was put, and what is known."""

from __future__ import annotations

import re
from collections.abc import Sequence

import msgspec

from doro_dialogue.facts import Candidate, facts_of, name_of, value_of
from doro_dialogue.matching import Verdict, compare_name, match, worst
from doro_schemas.graph import ObjectGraph, Relation, walk
from doro_schemas.messages.talk import Clause, State

BY_PLACE = re.compile(r"\bfrom left to right\b|\bleft to right\b")
ARTICLE = re.compile(r"^(?:the|a|an|one) |,")
SEGMENT = re.compile(r"[,;:.]\s*(?:and\s+)?|\s+and\s+(?=(?:one|two|a|an|another|the)\b)")
OFFER = re.compile(r"\b(?:should i|shall i|do you (?:want|mean)|is (?:it|that|this)|would you)\b")


class Scene(msgspec.Struct, frozen=True):
    """A question and its candidates.

    Attributes:
        said: the input graph.
        state, text: of the question.
        groups: what was offered, clause by clause; in the question's order if ``ordered``.
        candidates: every instance that is known, of all classes.
        ordered: the order of the groups is the one that the person read.
    """

    said: ObjectGraph
    state: State
    text: str
    groups: list[Clause]
    candidates: list[Candidate]
    ordered: bool = True

    @property
    def ids(self) -> list[str]:
        """Offered instances, in order."""
        return [name for group in self.groups for name in group.instance_ids]

    @property
    def others(self) -> list[str]:
        """Instances of the class that were not offered."""
        offered = self.ids
        return [
            one.id
            for one in self.candidates
            if one.id not in offered and compare_name(self.said.name, one.graph.name) == "holds"
        ]

    @property
    def by_place(self) -> bool:
        """The question gave its order by place."""
        return self.ordered and BY_PLACE.search(self.text.lower()) is not None

    def candidate(self, name: str) -> Candidate:
        """Return an instance by its id."""
        return next(one for one in self.candidates if one.id == name)

    def graph(self, name: str) -> ObjectGraph:
        """Return what is known of an instance."""
        return self.candidate(name).graph

    def verdict(self, graph: ObjectGraph, name: str) -> Verdict:
        """Hold a description against an instance, class name included."""
        seen = self.graph(name)
        compared = compare_name(graph.name, seen.name)
        if name_of(graph.name) == name_of(self.said.name):
            compared = "holds"
        elif compared == "unknown" and self._beside(graph, seen):
            compared = "holds"  # "the table one": the cup that is on the table
        return worst([compared, match(graph, seen).verdict])

    def _beside(self, graph: ObjectGraph, seen: ObjectGraph) -> bool:
        landmark = name_of(graph.name).removesuffix(" " + name_of(self.said.name))
        return any(compare_name(landmark, r.target.name) == "holds" for r in seen.relations)

    def is_class(self, graph: ObjectGraph) -> bool:
        """Tell whether a description is one of the things asked about."""
        names = [self.said.name, *(self.graph(one).name for one in (*self.ids, *self.others))]
        return any(compare_name(graph.name, name) != "contradicted" for name in names)

    def is_landmark(self, graph: ObjectGraph) -> list[str]:
        """Return the offered instances that have a thing of this name as a landmark."""
        return [
            one
            for one in self.ids
            if any(
                compare_name(graph.name, relation.target.name) == "holds"
                for relation in self.graph(one).relations
            )
        ]

    def said_literally(self, graph: ObjectGraph, name: str) -> bool:
        """Tell whether the question named an instance by these very words."""
        group = next(group for group in self.groups if name in group.instance_ids)
        return _literal(graph, group.graph, self.said.name)

    def verbatim(self, said: str) -> Clause | None:
        """Return the clause of one instance whose very words an answer is."""
        bare = ARTICLE.sub("", said)
        found = [one for one in self.groups if ARTICLE.sub("", one.text.lower()) == bare]
        return found[0] if len(found) == 1 and len(found[0].instance_ids) == 1 and bare else None

    def values(self) -> set[str]:
        """Return all observed values; for membership only."""
        return observed_words([one.graph for one in self.candidates], names=False)


def observed_words(graphs: Sequence[ObjectGraph], *, names: bool = True) -> set[str]:
    """Return the words of all observed values, and of all names; for membership only."""
    found = {
        word
        for graph in graphs
        for node in walk(graph)
        for value in node.attributes.values()
        for word in value_of(value).split(" ")
    }
    if names:
        for graph in graphs:
            found.update(word for node in walk(graph) for word in node.name.split(" "))
    return found


def _literal(said: ObjectGraph, named: ObjectGraph, name: str = "") -> bool:
    same = name_of(said.name) in (name_of(named.name), name_of(name or named.name))
    own = all(
        key in named.attributes and value_of(named.attributes[key]) == value_of(value)
        for key, value in said.attributes.items()
    )
    placed = all(
        any(r.type == seen.type and _literal(r.target, seen.target) for seen in named.relations)
        for r in said.relations
    )
    return same and own and placed


def read_question(
    text: str, offered: Sequence[Clause], everyone: Sequence[Candidate]
) -> tuple[list[Clause], bool]:
    """Return the clauses in the order in which a text names them, and whether it does.

    For questions that come as text only. The own wording names its clauses literally; any
    other text is cut into segments, each of which must fit one instance best.

    Args:
        offered: the clauses of the own question for the same instances.
        everyone: all instances of the class.
    """
    lower = text.lower()
    at = [lower.find(one.text.lower()) for one in offered]
    if offered and min(at) >= 0 and at == sorted(at) and len(set(at)) == len(at):
        return list(offered), True
    named: list[str] = []
    for segment in SEGMENT.split(lower):
        found = _fits_best(segment, everyone)
        if found and found not in named:
            named.append(found)
    ids = {name for one in offered for name in one.instance_ids}
    single = all(len(one.instance_ids) == 1 for one in offered)
    if single and ids and set(named) == ids:
        return sorted(offered, key=lambda one: named.index(one.instance_ids[0])), True
    asked = len(named) >= 2 or (len(named) == 1 and OFFER.search(lower) and "which" not in lower)
    if asked and (set(named) > ids or len(named) == 1):
        graphs = {one.id: one.graph for one in everyone}
        return [Clause([name], "", graphs[name]) for name in named], True
    return list(offered), False


def _fits_best(segment: str, everyone: Sequence[Candidate]) -> str:
    """Return the one instance whose observed words a segment holds most of, or nothing."""
    spoken = set(re.findall(r"[a-z]+", segment))
    scores = [(_score(one.graph, spoken), one.id) for one in everyone]
    best = max((score for score, _ in scores), default=0)
    fitting = [name for score, name in scores if score == best]
    return fitting[0] if best > 0 and len(fitting) == 1 else ""


def _score(graph: ObjectGraph, spoken: set[str]) -> int:
    score = 0
    for fact in facts_of(graph):
        if isinstance(fact, Relation):
            score += set(name_of(fact.target.name).split(" ")) <= spoken
        else:
            score += set(fact.value.lower().split(" ")) <= spoken
    return score
