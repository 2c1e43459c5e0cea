"""Which instance an answer means: resolved only among what was offered, never guessed.

Three-valued as the decision is. One that holds is the target; several are asked about
again; one that nobody observed is offered, not taken; a value that is false of all is
missing (DESIGN, "Answer").
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import msgspec

from doro_dialogue.act_words import NO_PLACE
from doro_dialogue.acts import Heard
from doro_dialogue.facts import name_of, value_of
from doro_dialogue.matching import is_room
from doro_dialogue.pick_out import Found, Graphs, alternative, row_of_groups
from doro_dialogue.scene import Scene
from doro_schemas.graph import ObjectGraph

Action = Literal[
    "resolved", "resolved_multiple", "ask_again", "missing", "cancelled", "search_again"
]


class Outcome(msgspec.Struct, frozen=True):
    """What an answer comes to.

    Attributes:
        action: as ``doro answer`` gives it.
        targets: the instances meant, in the order of the question.
        about: the instances to ask about again; empty: the same question.
        graph: what was described, where one description decided.
        replaced: another object is wanted: to be decided anew.
        repeat: the person wants to hear it again, or the robot to look again.
        sides: the person named a side, and the question had none.
    """

    action: Action
    targets: list[str] = []
    about: list[str] = []
    graph: ObjectGraph | None = None
    replaced: ObjectGraph | None = None
    repeat: bool = False
    sides: bool = False


ASK = Outcome("ask_again")


def resolve(scene: Scene, heard: Heard, graphs: Graphs) -> Outcome:
    """Return what an answer comes to; the very words of a clause need no reading.

    Args:
        graphs: the parser's graph by text, for every text of ``heard.texts``.
    """
    if (named := scene.verbatim(heard.said)) is not None:
        return _take(named.instance_ids, named.graph)
    # "Right" is a side where the question named sides, and a "yes" elsewhere.
    sides = heard.act == "yes" and bool(heard.alternatives) and bool(row_of_groups(scene))
    if heard.act == "describe" or sides:
        return _described(scene, heard, graphs)
    acts: dict[str, Callable[[], Outcome]] = {
        "cancel": lambda: Outcome("cancelled"),
        "search": lambda: _elsewhere(scene, heard, graphs),
        "any": lambda: _take(scene.ids[:1]),
        "all": lambda: _take(scene.ids) if heard.count in (0, len(scene.ids)) else ASK,
        "none": lambda: _declined(scene),
        "yes": lambda: _yes_or_no(scene, "yes"),
        "no": lambda: _yes_or_no(scene, "no"),
        "repeat": lambda: Outcome("ask_again", repeat=True),
    }
    return acts[heard.act]() if heard.act in acts else ASK


def _yes_or_no(scene: Scene, act: str) -> Outcome:
    """Yes takes an offer and says nothing to a which-question; no declines an offer."""
    if "which" in scene.text.replace("does it matter which one", "does it matter"):
        return ASK
    if scene.state == "INFORM-AMBIGUITY" and len(scene.ids) > 1:
        takes_any = {"yes": "fine?", "no": "does it matter"}[act] in scene.text
        return _take(scene.ids[:1]) if takes_any and len(scene.groups) == 1 else ASK
    if not scene.ids:
        return ASK
    return _take(scene.ids[:1]) if act == "yes" else _declined(scene)


def _take(ids: list[str], graph: ObjectGraph | None = None) -> Outcome:
    if not ids:
        return ASK
    action: Action = "resolved" if len(ids) == 1 else "resolved_multiple"
    return Outcome(action, targets=ids, graph=graph)


def _declined(scene: Scene) -> Outcome:
    """None of what was offered: the others of the class are left, or nothing."""
    others = scene.others
    return Outcome("ask_again", about=others) if others else Outcome("missing")


def _elsewhere(scene: Scene, heard: Heard, graphs: Graphs) -> Outcome:
    """Look there, unless one that was offered lies there: then that is asked."""
    graph = next((graphs.get(text) for text in heard.texts), None)
    if graph is None or not graph.relations or not scene.is_class(graph):
        return Outcome("search_again", repeat=NO_PLACE.search(heard.said) is not None)
    there = [one for one in scene.ids if scene.verdict(graph, one) == "holds"]
    return Outcome("ask_again", about=there) if there else Outcome("search_again")


def _described(scene: Scene, heard: Heard, graphs: Graphs) -> Outcome:
    other = _other_object(scene, heard, graphs)
    if other is not None:
        return other
    sided = any(phrase.side for phrases in heard.alternatives for phrase in phrases)
    if sided and not row_of_groups(scene):
        return Outcome("ask_again", sides=True)
    found = [alternative(scene, phrases, graphs) for phrases in heard.alternatives]
    if len(found) == 1:
        return _one(scene, heard, found[0])
    return _joined(scene, heard, found)


def _joined(scene: Scene, heard: Heard, found: list[Found]) -> Outcome:
    """Resolve several alternatives ("the red one and the blue one")."""
    union = [one for one in scene.ids if any(one in each.holds for each in found)]
    if any(not each.holds for each in found):
        return ASK
    if heard.joined == "and":
        sure = all(len(each.holds) == 1 or each.plural for each in found)
        return _take(union) if sure else Outcome("ask_again", about=union)
    if heard.pick == "any":
        return _take(union[:1])
    return _take(union) if len(union) == 1 else Outcome("ask_again", about=union)


def _other_object(scene: Scene, heard: Heard, graphs: Graphs) -> Outcome | None:
    """Another class replaces the object; a landmark of the question may be short for its cup."""
    for phrase in (one for phrases in heard.alternatives for one in phrases):
        graph = graphs.get(phrase.text) if phrase.text else None
        if graph is None or phrase.negative:
            continue
        if not scene.is_class(graph):
            lies_there = scene.is_landmark(graph)
            if phrase.unclear or len(heard.alternatives) > 1:
                return ASK
            if lies_there and not heard.corrects and not graph.attributes:
                return Outcome("ask_again", about=lies_there)
            return Outcome("ask_again", replaced=graph)
        if scene.state == "INFORM-MISSING" and graph.relations and not graph.attributes:
            return Outcome("search_again")
        rooms = [r for r in graph.relations if is_room(r.target.name)]
        if rooms and not any(scene.verdict(graph, one) == "holds" for one in scene.ids):
            elsewhere = heard.corrects or scene.state in ("INFORM-MISSING", "INFORM-MISMATCH")
            return Outcome("search_again") if elsewhere else ASK
    return None


def _one(scene: Scene, heard: Heard, found: Found) -> Outcome:
    holds = found.holds
    if len(holds) > 1 and found.graph is not None:
        literal = [one for one in holds if scene.said_literally(found.graph, one)]
        narrower = [one for one in holds if not _observed(scene, found.graph, one)]
        # "blue" is true of a dark blue one; asked "one blue, and one dark blue", it is clear.
        if len(literal) == 1 and len(narrower) == len(holds) - 1:
            holds = literal
    if len(holds) == 1 and not (heard.pick == "all" and heard.count > 1):
        return _take(holds, found.graph)
    if holds:
        if heard.pick == "any":
            return _take(holds[:1], found.graph)
        wanted = heard.pick == "all" or found.plural
        if wanted and (heard.count or len(holds)) == len(holds):
            return _take(holds, found.graph)
        return Outcome("ask_again", about=holds, graph=found.graph)
    if found.maybe and not _others_that_fit(scene, found):
        return Outcome("ask_again", about=found.maybe, graph=found.graph)
    return _beyond(scene, heard, found) if found.false or found.maybe else ASK


def _beyond(scene: Scene, heard: Heard, found: Found) -> Outcome:
    """False of all that was offered: an own word taken back may mean another of the class."""
    graph = found.graph
    if graph is None:
        return ASK
    holds = _others_that_fit(scene, found)
    if len(holds) == 1 and heard.corrects:
        return _take(holds, graph)
    maybe = [one for one in scene.others if scene.verdict(graph, one) == "unknown"]
    if holds or maybe:
        return Outcome("ask_again", about=holds or maybe, graph=graph)
    return Outcome("missing", graph=graph)


def _others_that_fit(scene: Scene, found: Found) -> list[str]:
    """Return the instances of the class that were not offered and that are described."""
    if found.graph is None:
        return []
    return [one for one in scene.others if scene.verdict(found.graph, one) == "holds"]


def _observed(scene: Scene, graph: ObjectGraph, name: str) -> bool:
    """Tell whether the very words were observed, not narrower ones."""
    seen = scene.graph(name)
    placed = all(
        any(
            (one.type, name_of(one.target.name)) == (said.type, name_of(said.target.name))
            for one in seen.relations
        )
        for said in graph.relations
    )
    values = seen.attributes
    own = all(value_of(values.get(key, "-")) == value_of(v) for key, v in graph.attributes.items())
    return own and placed and name_of(seen.name) == name_of(graph.name)
