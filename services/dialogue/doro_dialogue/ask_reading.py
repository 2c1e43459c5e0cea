"""The question for a reading, and what an answer to it chooses."""

from __future__ import annotations

import re
from typing import Literal

import msgspec

from doro_dialogue.act_words import DESCRIBING, ORDINAL, ORDINALS, PREPOSITION
from doro_dialogue.facts import words
from doro_dialogue.mend import mended
from doro_dialogue.question import Part, Question, compose
from doro_dialogue.readings import Holder, Read, Split, without_open
from doro_dialogue.surface import is_plural
from doro_schemas.graph import ObjectGraph

BOTH = re.compile(r"\b(?:both|and so is|as well|each|all of them)\b")
ANY = re.compile(
    r"\b(?:either|any(?: of (?:them|these))?|whichever|(?:does not|doesn't) matter|up to you"
    r"|you (?:choose|pick|decide)|(?:do not|don't) (?:care|mind|know)|not sure|no idea)\b"
)
NEITHER = re.compile(r"\b(?:neither|none(?: of (?:them|these))?)\b")
BARE_YES_NO = re.compile(r"^(?:yes|yeah|yep|no|nope|ok|okay|sure|right|what|hm+)[ ,.!?]*$")
NOT = re.compile(r"\b(?:not|isn't|aren't)\s+(?:the |my |a )?$")
THING = rf"\b(?:one|it)(?: is| that is| that's)? {PREPOSITION.pattern}"
COMMON = words(
    "the a an is are it its that which one i mean of and or not no yes both to in on at by"
)


class Chosen(msgspec.Struct, frozen=True):
    """What an answer to the question for a reading says.

    Attributes:
        how: ``reading``: decided; ``any``: it does not matter or is not known, so that the
            things themselves are asked about; ``again``: the answer leaves it open.
        readings: those that are left, the preferred one first.
    """

    how: Literal["reading", "any", "again"]
    readings: list[ObjectGraph] = []


AGAIN = Chosen("again")


def compose_read(read: Read, *, task: str = "", unseen_share: float = 0.0) -> Question:
    """Return the question for a reading where one is needed, else that of the decision."""
    if read.split is not None:
        return compose_split(read.split)
    return compose(read.decision, task=task, unseen_share=unseen_share)


def compose_split(split: Split) -> Question:
    """Return the question for a reading in all wordings, a clause for each holder."""
    statements = [f"{one.text} {_is(one)} {split.words}" for one in split.holders]
    parts = [
        Part(one.decision.matches, text, one.readings[0])
        for one, text in zip(split.holders, statements, strict=True)
    ]
    asked = [f"{_is(one)} {one.text} {split.words}" for one in split.holders]
    names = [one.text for one in split.holders]
    which = f"{', '.join(names[:-1])} or {names[-1]}"
    either = f"{', '.join(asked[:-1])}, or {asked[-1]}?"
    return Question(
        parts,
        [
            either[0].upper() + either[1:],
            f"Just to be sure: {either}",
            f"What is {split.words}, {which}?",
        ],
    )


def choose(split: Split, text: str, known: frozenset[str]) -> Chosen | None:
    """Return what an answer chooses; None if it says nothing about the readings.

    A person repeats the one they mean ("the table", "the table is near the sink"), excludes
    the other ("not the table"), or counts ("the second"). The ambiguous words said once more
    name both and leave it open. With anything else in it that was observed ("the red cup")
    it is a description of the thing wanted.

    Args:
        known: all words that were observed; for membership only.
    """
    own = words(" ".join([split.words, *(one.text for one in split.holders)]))
    said = mended(text.lower().replace("\u2019", "'"), known | own)
    said = re.sub(r"\s+", " ", re.sub(r"[\"(),;:.!?]+", " ", said)).strip()
    if BARE_YES_NO.match(said):
        return AGAIN
    rest = [word for word in said.split(" ") if word not in COMMON and word not in own]
    if any(word in DESCRIBING or word in known for word in rest):
        return None
    named, excluded = _mentioned(split, said)
    if not named and not excluded:
        return _counted(split, said) or _unnamed(split, said)
    if BOTH.search(said) and not excluded:
        return _unnamed(split, said)
    left = named or [one for one in split.holders if one not in excluded]
    return Chosen("reading", left[0].readings) if len(left) == 1 else AGAIN


def _unnamed(split: Split, said: str) -> Chosen | None:
    """Return what is chosen without a name: neither, or that both are so or it is all one."""
    if NEITHER.search(said):
        return Chosen("reading", [without_open(split)])
    return Chosen("any") if BOTH.search(said) or ANY.search(said) else None


def _mentioned(split: Split, said: str) -> tuple[list[Holder], list[Holder]]:
    """Return the holders that an answer names, and those that it excludes."""
    named: list[Holder] = []
    excluded: list[Holder] = []
    for one in split.holders:
        patterns = [rf"\b{re.escape(one.text.removeprefix('the '))}\b"]
        if sum(other.name == one.name for other in split.holders) == 1:
            patterns.append(rf"\b{re.escape(one.name)}s?\b")
        if one.is_object:
            patterns.append(THING)
        found = next((m for p in patterns if (m := re.search(p, said))), None)
        if found is not None:
            (excluded if NOT.search(said[: found.start()]) else named).append(one)
    return named, excluded


def _counted(split: Split, said: str) -> Chosen | None:
    match = ORDINAL.search(said)
    if match is None:
        return None
    number = ORDINALS[next(group for group in match.groups() if group)]
    index = number - 1 if number > 0 else len(split.holders) - 1
    if not 0 <= index < len(split.holders):
        return AGAIN
    return Chosen("reading", split.holders[index].readings)


def _is(holder: Holder) -> str:
    return "are" if is_plural(holder.name) else "is"
