"""A question and its parts: the paper's templates and the words that fill them."""

from __future__ import annotations

import msgspec

from doro_dialogue.facts import words
from doro_schemas.graph import ObjectGraph
from doro_schemas.messages.talk import SeenFrom

WH_SUFFIXES = (
    "which one do you mean?",
    "which one should I take?",
    "which one do you want?",
    "which one are you referring to?",
)
MISMATCH_SUFFIXES = ("Should I take {it}?", "Do you want {it}?", "Is that what you mean?")
ACKNOWLEDGEMENTS = ("Okay", "Sure", "Alright", "Got it")
CARRYING = words("bring take get fetch grab pick pass give hand carry collect retrieve deliver")
"""Tasks that "I will take it" answers; others get wordings that name no action."""


class Part(msgspec.Struct, frozen=True):
    """One clause: instances, words, and the graph with exactly the facts of the words."""

    instance_ids: list[str]
    text: str
    graph: ObjectGraph


class Question(msgspec.Struct, frozen=True):
    """A question or confirmation.

    Attributes:
        parts: its clauses, in order.
        wordings: every wording, in a fixed order, the plainest first.
        seen_from: the view in which left and right are meant; None where no side is named.
        also: instances that it mentions without offering them.
    """

    parts: list[Part]
    wordings: list[str]
    seen_from: SeenFrom | None = None
    also: list[Part] = []
