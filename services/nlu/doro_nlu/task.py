"""The task's verb phrase: the last verb before the object, else the first one after it."""

from __future__ import annotations

from collections.abc import Sequence

from doro_nlu.labels import OUTSIDE
from doro_nlu.words import PARTICLES, SPLIT_VERBS, TASKS

_PHRASES = {tuple(phrase.split()) for phrase in TASKS}
_LONGEST_PHRASE = 6
_BEFORE_NO_VERB = frozenset(["the", "a", "an", "my", "your", "his", "her", "our", "this"])


def task_of(tokens: Sequence[str], labels: Sequence[str], start: int, end: int) -> str:
    """Return the verb phrase that governs the object at ``start:end``, or ``""``.

    "Go to the hall and bring me the cup" -> "bring"; "pick the cup up" -> "pick up"; "on the
    table there is a cup, fetch it" -> "fetch".
    """
    words = [token.lower() for token in tokens]
    if words[0] == "where":
        return "where is"
    split = _split_verb(words, labels, start, end)
    if split:
        return split
    before = _verbs(words, labels, 0, start)
    after = _verbs(words, labels, end, len(words))
    if not before:
        return after[0] if after else ""
    return before[-1]


def _split_verb(words: Sequence[str], labels: Sequence[str], start: int, end: int) -> str:
    """Return a verb whose particle stands behind the object: "turn the oven on"."""
    particle = words[end] if end < len(words) and labels[end] == OUTSIDE else ""
    if particle not in PARTICLES:
        particle = _last_particle(words, labels, end)
    for at in range(start - 1, max(-1, start - 1 - _LONGEST_PHRASE), -1):
        if words[at] in SPLIT_VERBS:
            phrase = f"{words[at]} {particle}"
            return phrase if labels[at] == OUTSIDE and phrase in TASKS else ""
    return ""


def _last_particle(words: Sequence[str], labels: Sequence[str], end: int) -> str:
    """Return a particle behind the object's relations: "pick the cup on the table up"."""
    for at in range(end + 1, len(words)):
        closes = at + 1 == len(words) or not words[at + 1].isalpha() or words[at + 1] == "and"
        if words[at] in PARTICLES and labels[at] == OUTSIDE != labels[at - 1] and closes:
            return words[at]
    return ""


def _verbs(words: Sequence[str], labels: Sequence[str], start: int, end: int) -> list[str]:
    found: list[str] = []
    index = start
    while index < end:
        step = 1
        if labels[index] == OUTSIDE and not (index and words[index - 1] in _BEFORE_NO_VERB):
            for length in (2, 1):
                phrase = tuple(words[index : index + length])
                if index + length <= end and phrase in _PHRASES:
                    found.append(" ".join(phrase))
                    step = length
                    break
        index += step
    return found
