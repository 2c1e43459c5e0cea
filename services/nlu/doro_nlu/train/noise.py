"""Typing errors: the label stays that of the word meant."""

from __future__ import annotations

from random import Random

from doro_nlu.train.annotate import Example


def misspell(word: str, rng: Random) -> str:
    """Return a word with one letter lost, doubled, swapped with its neighbour or replaced."""
    at = rng.randrange(1, len(word) - 1)
    roll = rng.random()
    if roll < 0.3:
        return word[:at] + word[at + 1 :]
    if roll < 0.5:
        return word[:at] + word[at] + word[at:]
    if roll < 0.8:
        return word[:at] + word[at + 1] + word[at] + word[at + 2 :]
    return word[:at] + rng.choice("abcdefghijklmnopqrstuvwxyz") + word[at + 1 :]


def add_typos(example: Example, rng: Random) -> Example:
    """Return the example with one or two of its longer words misspelt."""
    tokens = list(example.tokens)
    long = [index for index, token in enumerate(tokens) if len(token) > 3 and token.isalpha()]
    for index in rng.sample(long, min(len(long), rng.choice((1, 1, 2)))):
        tokens[index] = misspell(tokens[index], rng)
    return Example(tokens, example.labels)
