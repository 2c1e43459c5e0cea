"""Holds what an answer says of a thing against the instances that were offered."""

from __future__ import annotations

import re
from collections.abc import Sequence

import msgspec

from doro_dialogue.act_words import DESCRIBING, SHADES
from doro_dialogue.acts import Phrase
from doro_dialogue.facts import COLOR, facts_of, value_of
from doro_dialogue.matching import Verdict, worst
from doro_dialogue.rows import IN_ROW
from doro_dialogue.scene import Scene
from doro_schemas.graph import ObjectGraph
from doro_schemas.messages.talk import Clause

Graphs = dict[str, ObjectGraph | None]


class Found(msgspec.Struct, frozen=True):
    """What one alternative of an answer leaves of the offered instances.

    Attributes:
        holds: all that was said holds of them.
        maybe: nothing contradicts, something was not observed.
        false: what was said is false of all.
        graph: the parser's graph of what was said.
        plural: several are wanted.
    """

    holds: list[str] = []
    maybe: list[str] = []
    false: bool = False
    graph: ObjectGraph | None = None
    plural: bool = False


def alternative(scene: Scene, phrases: list[Phrase], graphs: Graphs) -> Found:
    """Return the offered instances for which all phrases hold, or may."""
    ids = scene.ids
    verdicts: dict[str, list[Verdict]] = {one: [] for one in ids}
    graph: ObjectGraph | None = None
    excluding = False
    for phrase in phrases:
        each = _phrase(scene, phrase, graphs, excluded=excluding)
        if each is None:
            # Something was said that nothing observed answers; the rest may still narrow it.
            continue
        if phrase.negative:
            if "holds" not in each.values():
                return Found()
            excluding = True
            each = {one: _turned(verdict) for one, verdict in each.items()}
        elif phrase.text:
            read = graphs[phrase.text]
            graph = None if read is None else _shade(scene, read)
        for one in ids:
            verdicts[one].append(each[one])
    if not any(verdicts.values()):
        return _others(scene, phrases, graphs)
    results = {one: worst(verdicts[one]) for one in ids}
    placed = any(phrase.ordinal or phrase.side or phrase.other for phrase in phrases)
    return Found(
        holds=[one for one in ids if results[one] == "holds"],
        maybe=[one for one in ids if results[one] == "unknown"],
        # "the first one, the blue one", and the first is red: a slip, not a missing thing.
        false=not placed and all(verdict == "contradicted" for verdict in results.values()),
        graph=graph,
        plural=any(phrase.plural for phrase in phrases),
    )


def _turned(verdict: Verdict) -> Verdict:
    return "contradicted" if verdict == "holds" else "holds"


def _others(scene: Scene, phrases: list[Phrase], graphs: Graphs) -> Found:
    """ "No, the other one" after a confirmation: the only other of the class."""
    others = scene.others
    if scene.state != "CONFIRM" or not any(phrase.other for phrase in phrases):
        graph = next((g for p in phrases if (g := _facts(scene, graphs.get(p.text)))), None)
        return Found(graph=graph, false=not scene.ids and graph is not None)
    return Found(holds=others) if len(others) == 1 else Found(maybe=others)


def _phrase(
    scene: Scene, phrase: Phrase, graphs: Graphs, *, excluded: bool
) -> dict[str, Verdict] | None:
    """Return a verdict for every offered instance; None where the phrase says nothing."""
    graph = _facts(scene, graphs.get(phrase.text) if phrase.text else None)
    by_facts: dict[str, Verdict] | None = None
    if graph is not None:
        by_facts = {one: scene.verdict(graph, one) for one in scene.ids}
    placed: list[str] | None = None
    if phrase.ordinal and phrase.side:
        placed = _from_side(scene, phrase.ordinal, phrase.side)
    elif phrase.ordinal:
        placed = _ordinal(scene, phrase.ordinal, by_facts)
    elif phrase.side:
        placed = _side(scene, phrase.side)
    elif phrase.other:
        placed = _marked_other(scene, graph, named=phrase.named)
        if placed is None and not excluded:
            return None
    if placed is None:
        # An order that the question did not give says nothing, nor does what goes with it.
        return None if phrase.ordinal or phrase.side else by_facts
    at: dict[str, Verdict] = {
        one: "holds" if one in placed else "contradicted" for one in scene.ids
    }
    return {one: worst([at[one], by_facts[one] if by_facts else "holds"]) for one in scene.ids}


def _marked_other(scene: Scene, graph: ObjectGraph | None, *, named: bool) -> list[str] | None:
    """Return the clause that the question itself called "one other cup", if it is one.

    Of several ("one other red cup, and one other cup") the one with these very words.
    """
    marked = [group for group in scene.groups if re.search(r"\bother\b", group.text)]
    if len(marked) > 1 and graph is not None:
        marked = [
            one
            for one in marked
            if scene.said_literally(graph, one.instance_ids[0])
            and len(facts_of(one.graph)) == len(facts_of(graph))
        ]
    elif len(marked) > 1 and named:
        marked = [one for one in marked if not facts_of(one.graph)]
    return marked[0].instance_ids if len(marked) == 1 else None


def _facts(scene: Scene, graph: ObjectGraph | None) -> ObjectGraph | None:
    """Return the graph if it says something that an observation can answer."""
    if graph is None:
        return None
    graph = _shade(scene, graph)
    known = scene.values()
    for value in graph.attributes.values():
        if not all(word in DESCRIBING or word in known for word in value_of(value).split(" ")):
            return None
    named = graph.name not in (scene.said.name,)
    return graph if graph.attributes or graph.relations or named else None


def _shade(scene: Scene, graph: ObjectGraph) -> ObjectGraph:
    """Return "the dark one" as "the dark blue one", where one color offered is dark."""
    color = graph.attributes.get(COLOR, "")
    if color not in SHADES:
        return graph
    seen = {value_of(scene.graph(one).attributes.get(COLOR, "")) for one in scene.ids}
    shades = sorted(one for one in seen if one.startswith(f"{color} "))
    own = {key: value for key, value in graph.attributes.items() if key != COLOR}
    own |= {COLOR: shades[0]} if len(shades) == 1 else {}
    return ObjectGraph(graph.name, own, graph.relations)


def _ordinal(scene: Scene, number: int, by_facts: dict[str, Verdict] | None) -> list[str] | None:
    """Return the group with this number; with a description, both readings must agree."""
    if not scene.ordered:
        return None
    among = scene.groups
    fitting = [g for g in among if by_facts and "holds" in map(by_facts.get, g.instance_ids)]
    whole, part = _nth(among, number), _nth(fitting, number)
    if by_facts is None:
        return whole
    if whole is not None and any(by_facts[one] == "holds" for one in whole):
        return whole if part in (None, whole) else None
    return part


def _nth(groups: Sequence[Clause], number: int) -> list[str] | None:
    """Return a clause's instances; those that nothing tells apart have no order of their own."""
    index = number - 1 if number > 0 else len(groups) - 1
    if not 0 <= index < len(groups):
        return None
    # Counting goes wrong behind "two identical cups": is the second the other twin?
    before = groups[: index + 1] if number > 0 else groups[index:]
    if any(len(group.instance_ids) > 1 for group in before):
        return None
    return list(groups[index].instance_ids)


def _side(scene: Scene, side: str) -> list[str] | None:
    """Return the group at a side, where the question gave its order by place."""
    row = row_of_groups(scene)
    if not row or (side == "middle" and len(row) % 2 == 0):
        return None
    index = {"left": 0, "middle": len(row) // 2, "right": len(row) - 1}[side]
    return row[index].instance_ids


def _from_side(scene: Scene, number: int, side: str) -> list[str] | None:
    """Return the group counted from a side ("the second from the left")."""
    row = row_of_groups(scene) if side == "left" else row_of_groups(scene)[::-1]
    index = number - 1 if number > 0 else len(row) - 1
    return row[index].instance_ids if 0 <= index < len(row) else None


def row_of_groups(scene: Scene) -> list[Clause]:
    """Return the groups that the question put in a row, from left to right."""
    if scene.by_place:
        return list(scene.groups)
    return [group for group in scene.groups if IN_ROW.search(group.text)]
