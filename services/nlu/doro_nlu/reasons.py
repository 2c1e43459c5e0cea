"""Why a text is not understood: one clear sentence, and one word for programs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from doro_nlu.words import MOVES, PRONOUNS, TOWARDS, WAYS

NO_WORD = "no_word"
LANGUAGE = "language"
NO_OBJECT = "no_object"
NAVIGATION = "navigation"
TWO_TARGETS = "two_targets"
UNSURE = "unsure"
KINDS = (NO_WORD, LANGUAGE, NO_OBJECT, NAVIGATION, TWO_TARGETS, UNSURE)
_LONGEST_SHOWN = 80
_LONGEST_TEXT = 400


class Reason(NamedTuple):
    """A kind (one of ``KINDS``) and the sentence for people."""

    kind: str
    text: str


def plain(text: str) -> str:
    """Return a text for a sentence: on one line, printable, shortened."""
    line = " ".join("".join(c if c.isprintable() else " " for c in text[:_LONGEST_TEXT]).split())
    return line if len(line) <= _LONGEST_SHOWN else line[: _LONGEST_SHOWN - 3] + "..."


def no_object(words: Sequence[str], text: str) -> Reason:
    """Return the reason for a text without an object.

    Args:
        words: its tokens in lower case.
    """
    quoted = plain(text)
    if _moves(words):
        return Reason(
            NAVIGATION, f"only a place to go to was named in '{quoted}': say what to fetch or find"
        )
    if any(word in PRONOUNS for word in words):
        return Reason(
            NO_OBJECT,
            f"no object to fetch or find was named in '{quoted}': name the thing instead of 'one'",
        )
    return Reason(NO_OBJECT, f"no object to fetch or find was named in '{quoted}'")


def _moves(words: Sequence[str]) -> bool:
    """Tell whether a text sends the robot somewhere: "go to", "walk straight over to"."""
    for at, word in enumerate(words):
        if word in MOVES:
            rest = [later for later in words[at + 1 : at + 4] if later not in WAYS]
            if rest and rest[0] in TOWARDS:
                return True
    return False


def two_targets(first: str, second: str) -> Reason:
    """Return the reason for an instruction with two objects: one is fetched at a time."""
    return Reason(
        TWO_TARGETS,
        f"two targets were named, '{plain(first)}' and '{plain(second)}': ask for one at a time",
    )


def unsure(name: str, text: str) -> Reason:
    """Return the reason for an object that the tagger is not sure of."""
    return Reason(
        UNSURE,
        f"it is not clear what is meant by '{plain(name)}' in '{plain(text)}':"
        " say it in other words",
    )
