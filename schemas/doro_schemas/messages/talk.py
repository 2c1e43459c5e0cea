"""What is said to the person and what comes back."""

from __future__ import annotations

from typing import ClassVar, Literal

import msgspec

from doro_schemas.graph import ObjectGraph
from doro_schemas.messages.base import Message
from doro_schemas.messages.language import check_text
from doro_schemas.messages.map import Evidence

State = Literal["CONFIRM", "INFORM-MISMATCH", "INFORM-AMBIGUITY", "INFORM-MISSING"]


class Clause(msgspec.Struct, frozen=True):
    """One described candidate of a query and what supports the words.

    Attributes:
        instance_ids: the instance, or several that nothing tells apart.
        text: the words ("one red cup on top of the table").
        graph: the attributes and relations that the words use, no others.
        evidence, cells: frames, boxes and cells that support it.
    """

    instance_ids: list[str]
    text: str
    graph: ObjectGraph
    evidence: list[Evidence] = []
    cells: list[list[int]] = []


class SeenFrom(msgspec.Struct, frozen=True):
    """The view that gives left and right their meaning: one frame of one camera."""

    camera: str
    frame: int


class Query(Message, kw_only=True):
    """The robot's question, or its confirmation.

    Attributes:
        dialogue_id: the dialogue it opens, ``<episode>/<number of the instruction>``.
        revision: 0 at first; counts up when new evidence changes the decision.
        instruction: the person's words.
        input_graph: what was understood of them.
        state: one of the paper's four.
        reason: why this state, one word or phrase (``unique_match``, ``no_match``, ...).
        text: what is said.
        clauses: the candidates in the order of the text; with reason ``readings`` what the
            sentence may mean, each with the instances that it would single out.
        matches: ids of the instances for which all that was said holds.
        instances: ids of all instances of the class.
        unseen_share: share of the area not observed, 0..1.
        map_digest: the map that it was decided on.
        frames_merged: frames in that map: what a "could not find" rests on; -1 unknown.
        replaces: the revision of this dialogue that no longer holds; -1: none.
        ended: how the dialogue ended with this (``resolved``, ``cancelled``, ``turn_limit``,
            ``timed_out``); empty while an answer is taken.
        early: raised before the exploration had finished.
        seen_from: the view in which left and right are meant; None where no side is named.
        also: instances that the text mentions without offering them, with their evidence.
        person: who is asked: who gave the instruction; empty where that was not said.
    """

    ADDED: ClassVar[dict[str, object]] = {
        "frames_merged": -1,
        "replaces": -1,
        "ended": "",
        "early": False,
        "seen_from": None,
        "also": [],
        "person": "",
    }

    dialogue_id: str
    revision: int = 0
    instruction: str
    input_graph: ObjectGraph
    state: State
    reason: str
    text: str
    clauses: list[Clause] = []
    matches: list[str] = []
    instances: list[str] = []
    unseen_share: float = 0.0
    map_digest: str = ""
    frames_merged: int = -1
    replaces: int = -1
    ended: str = ""
    early: bool = False
    seen_from: SeenFrom | None = None
    also: list[Clause] = []
    person: str = ""


class Belief(Message, kw_only=True):
    """The decision as it stands while frames stream.

    Attributes:
        dialogue_id, state, reason, matches, instances: as in :class:`Query`.
        frames_merged: frames in the map that it rests on.
        unseen_share: share of the area not observed, 0..1; -1 unknown.
        confidence: lowest existence of the instances that it rests on, 0..1; -1: none.
        stable_beliefs: beliefs in a row, this one included, that decided the same; 0 unknown.
    """

    ADDED: ClassVar[dict[str, object]] = {
        "unseen_share": -1.0,
        "confidence": -1.0,
        "stable_beliefs": 0,
    }

    dialogue_id: str
    state: State
    reason: str
    matches: list[str] = []
    instances: list[str] = []
    frames_merged: int = 0
    unseen_share: float = -1.0
    confidence: float = -1.0
    stable_beliefs: int = 0


class Answer(Message, kw_only=True):
    """The person's reply. Plain UTF-8 on the same key becomes one of these.

    Attributes:
        text: the words.
        dialogue_id: the dialogue that is answered; empty: the one that spoke last.
        person: who answers; without a dialogue_id the last one that spoke to this person.
    """

    ADDED: ClassVar[dict[str, object]] = {"person": ""}

    text: str
    dialogue_id: str = ""
    person: str = ""

    def __post_init__(self) -> None:
        check_text(self.text, "answer")


class Target(Message, kw_only=True):
    """The resolved instance: where the robot may go."""

    dialogue_id: str
    instance_id: str
    graph: ObjectGraph
    position_m: list[float]
    extent_m: list[float]
