"""What is said to an answer: the acknowledgement, the narrower question, or what is missing."""

from __future__ import annotations

from collections.abc import Sequence

import msgspec

from doro_dialogue.ask_reading import compose_read, compose_split
from doro_dialogue.decision import Decision, Judged, decide
from doro_dialogue.discriminate import discriminate
from doro_dialogue.facts import Candidate, Fact, facts_of, graph_with, place_of
from doro_dialogue.matching import match
from doro_dialogue.question import Part, Question, carries, compose, pick
from doro_dialogue.readings import Split, decide_readings
from doro_dialogue.resolve import Outcome
from doro_dialogue.rows import IN_ROW
from doro_dialogue.scene import Scene
from doro_dialogue.surface import counted, listed
from doro_dialogue.which import ask_from_left
from doro_schemas.graph import ObjectGraph, Relation
from doro_schemas.messages.talk import SeenFrom, State

SORRY = "I could not tell from that. "
DECLINED = "Then I have not found it. Should I look for something else?"
TELL_ME = "Tell me what to look for, or where."


class Said(msgspec.Struct, frozen=True):
    """The text, the clauses it is about, and the state and reason that a Query carries."""

    text: str
    parts: list[Part]
    state: State
    reason: str
    seen_from: SeenFrom | None = None


class Manner(msgspec.Struct, frozen=True):
    """What the wording depends on: seed and dialogue id, the task, what was not seen."""

    seed: int = 0
    key: str = ""
    task: str = ""
    unseen_share: float = 0.0


def reply_to(scene: Scene, outcome: Outcome, manner: Manner) -> Said:
    """Return what is said to an answer; for ``replaced`` see :func:`decide_anew`."""
    if outcome.action == "resolved":
        return _resolved(scene, outcome, manner)
    if outcome.action == "resolved_multiple":
        return _several(scene, outcome, manner)
    if outcome.action == "missing":
        return _missing(scene, outcome, manner)
    if outcome.action == "cancelled":
        return Said("Okay, I will leave it.", [], scene.state, "cancelled")
    if outcome.action == "search_again":
        where = "again" if outcome.repeat else "there"
        return Said(f"Okay, I will look {where}.", [], scene.state, "search_again")
    return _again(scene, outcome, manner)


def decide_anew(
    readings: Sequence[ObjectGraph], candidates: Sequence[Candidate], manner: Manner
) -> tuple[Outcome, Said]:
    """Decide for an object that replaces the first one, or for the reading that was chosen."""
    read = decide_readings(readings, candidates, decide)
    decision = read.decision
    question = compose_read(read, task=manner.task, unseen_share=manner.unseen_share)
    said = _say(question, decision.state, decision.reason, manner)
    if decision.state == "CONFIRM":
        return Outcome("resolved", targets=decision.matches), said
    return Outcome("missing" if decision.state == "INFORM-MISSING" else "ask_again"), said


def _say(question: Question, state: State, reason: str, manner: Manner) -> Said:
    text = pick(question.wordings, manner.seed, manner.key)
    return Said(text, question.parts, state, reason, question.seen_from)


def _judged(scene: Scene, ids: Sequence[str], graph: ObjectGraph) -> list[Judged]:
    return [Judged(scene.candidate(one), match(graph, scene.graph(one))) for one in ids]


def _resolved(scene: Scene, outcome: Outcome, manner: Manner) -> Said:
    seen = scene.graph(outcome.targets[0])
    own = ObjectGraph(name=seen.name, attributes=seen.attributes)
    graph = _named(scene, outcome.graph) if outcome.graph is not None else own
    judged = _judged(scene, outcome.targets, graph)
    decision = Decision(graph, "CONFIRM", "unique_match", judged, judged)
    question = compose(decision, task=manner.task)
    if side := _side_of(scene, outcome.targets[0]):
        what = question.parts[0].text
        aside = side if side.startswith("the ") else f"the one {side}"
        wordings = [one.replace(what, f"{what}, {aside}", 1) for one in question.wordings]
        part = msgspec.structs.replace(question.parts[0], text=f"{what}, {side}")
        question = Question([part], wordings)
    return _say(question, "CONFIRM", "answered", manner)


def _side_of(scene: Scene, name: str) -> str:
    """Return the side at which the question put an instance, or nothing."""
    found = (IN_ROW.search(group.text) for group in scene.groups if name in group.instance_ids)
    return next((match[1] for match in found if match), "")


def _several(scene: Scene, outcome: Outcome, manner: Manner) -> Said:
    groups = discriminate([scene.candidate(one) for one in outcome.targets])
    parts = [
        Part(group.ids, counted(group.graph, len(group.ids), other=group.other), group.graph)
        for group in groups
    ]
    verb = "I will take" if carries(manner.task) else "I found"
    text = f"Okay, {verb} {listed([part.text for part in parts])}."
    return Said(text, parts, "CONFIRM", "answered")


def _missing(scene: Scene, outcome: Outcome, manner: Manner) -> Said:
    if outcome.graph is None:
        return Said(DECLINED, [], "INFORM-MISSING", "declined")
    graph = _named(scene, outcome.graph)
    decision = Decision(graph, "INFORM-MISSING", "missing", [], [])
    question = compose(decision, unseen_share=manner.unseen_share)
    # "I saw no cups at all" would not be true here: only the first wording is.
    return Said(question.wordings[0], [], "INFORM-MISSING", "missing")


def _again(scene: Scene, outcome: Outcome, manner: Manner) -> Said:
    ids = outcome.about or scene.ids
    if len(ids) == 1 and outcome.about:
        return _offer(scene, ids[0], outcome.graph, manner)
    note = _note(scene, outcome)
    if len(ids) < 2:
        parts = [Part(one.instance_ids, one.text, one.graph) for one in scene.groups]
        text = note + (_put_again(scene) if scene.groups or not note else TELL_ME)
        return Said(text, parts, scene.state, "ask_again")
    if outcome.sides and (row := _from_left(scene, ids, manner)) is not None:
        return row
    said = _which(scene, ids, manner, outcome.graph)
    return msgspec.structs.replace(said, text=note + said.text)


def _put_again(scene: Scene) -> str:
    """Return the question once more; a confirmation becomes one."""
    if scene.state == "CONFIRM" and len(scene.groups) == 1:
        return f"Do you mean {scene.groups[0].text}?"
    return scene.text.removeprefix(SORRY)


def _note(scene: Scene, outcome: Outcome) -> str:
    """Return what is said before a question is put again: why the answer did not decide it."""
    about = outcome.about
    if outcome.repeat or 0 < len(about) < len(scene.ids):
        return ""
    graph = outcome.graph if len(about) > 1 else None
    if graph is not None and all(scene.verdict(graph, one) == "holds" for one in about):
        return f"That is true of {'both' if len(about) == 2 else 'all of them'}. "
    return SORRY


def ask_about(scene: Scene, ids: Sequence[str], manner: Manner) -> Said:
    """Ask which of these is meant, or offer the only one."""
    return _which(scene, ids, manner) if len(ids) > 1 else _offer(scene, ids[0], None, manner)


def ask_reading_again(split: Split, manner: Manner) -> Said:
    """Put the question for a reading once more."""
    question = compose_split(split)
    text = SORRY + pick(question.wordings, manner.seed, manner.key)
    return Said(text, question.parts, "INFORM-AMBIGUITY", "readings")


def _from_left(scene: Scene, ids: Sequence[str], manner: Manner) -> Said | None:
    judged = _judged(scene, ids, scene.said)
    decision = Decision(scene.said, "INFORM-AMBIGUITY", "several_match", judged, judged)
    question = ask_from_left(decision, carries(manner.task))
    return _say(question, "INFORM-AMBIGUITY", "ask_again", manner) if question else None


def _which(
    scene: Scene, ids: Sequence[str], manner: Manner, graph: ObjectGraph | None = None
) -> Said:
    """Ask which of these, with the person's own words where they hold."""
    own = {**scene.said.attributes, **(graph.attributes if graph is not None else {})}
    judged = _judged(scene, ids, ObjectGraph(scene.said.name, own))
    decision = Decision(scene.said, "INFORM-AMBIGUITY", "several_match", judged, judged)
    question = compose(decision, task=manner.task)
    return _say(question, "INFORM-AMBIGUITY", "ask_again", manner)


def _offer(scene: Scene, name: str, graph: ObjectGraph | None, manner: Manner) -> Said:
    """Offer one instance: it may be meant, but that is not sure."""
    said = _named(scene, graph)
    found = match(said, scene.graph(name))
    if graph is not None and found.verdict == "unknown":
        judged = [Judged(scene.candidate(name), found)]
        decision = Decision(said, "INFORM-MISMATCH", "unknown", judged, judged)
        return _say(compose(decision, task=manner.task), "INFORM-MISMATCH", "offer", manner)
    seen = scene.graph(name)
    facts: list[Fact] = [one for one in facts_of(seen) if not isinstance(one, Relation)]
    place = place_of(seen)
    shown = graph_with(seen.name, [*facts, *([place] if place else [])])
    part = Part([name], counted(shown), shown)
    suffix = "Should I take it?" if carries(manner.task) else "Is that what you mean?"
    return Said(f"I found {part.text}. {suffix}", [part], "INFORM-MISMATCH", "offer")


def _named(scene: Scene, graph: ObjectGraph | None) -> ObjectGraph:
    """Return a description under its class name ("the table one" has none of its own)."""
    if graph is None:
        return ObjectGraph(name=scene.said.name)
    names = [scene.graph(one).name for one in (*scene.ids, *scene.others)]
    name = graph.name if graph.name in names else scene.said.name
    return ObjectGraph(name, graph.attributes, graph.relations)
