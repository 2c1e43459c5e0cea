"""The task's verb phrase: the last verb before the object, else the first one after it."""

from __future__ import annotations

from collections.abc import Sequence

from doro_nlu.labels import OUTSIDE
from doro_nlu.words import PARTICLES, SPLIT_VERBS, TASKS

_PHRASES = {tuple(phrase.split()) for phrase in TASKS}
_BEFORE_NO_VERB = frozenset(["the", "a", "an", "my", "your", "his", "her", "our", "this"])


def task_of(tokens: Sequence[str], labels: Sequence[str], start: int, end: int) -> str:
    """Return the verb phrase that governs the object at ``start:end``, or ``""``.

    "Go to the hall and bring me the cup" -> "bring"; "pick the cup up" -> "pick up"; "on the
    table there is a cup, fetch it" -> "fetch".
    """
    words = [token.lower() for token in tokens]
    before = _verbs(words, labels, 0, start)
    after = _verbs(words, labels, end, len(words))
    if not before:
        return after[0] if after else ""
    verb = before[-1]
    particle = words[end] if end < len(words) and labels[end] == OUTSIDE else ""
    if verb in SPLIT_VERBS and particle in PARTICLES and f"{verb} {particle}" in TASKS:
        return f"{verb} {particle}"
    return verb


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
