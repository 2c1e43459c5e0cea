"""A user's own labelled sentences: JSON lines or BIO, checked line by line. No torch needed."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from random import Random
from typing import NamedTuple

from doro_nlu.labels import OUTSIDE, may_follow
from doro_nlu.train.annotate import Example
from doro_schemas.errors import Refused

LEAST_SENTENCES = 10
TEST_EVERY = 5
MAX_TOKENS = 100
_TYPE_MARKS = "-_"


class Split(NamedTuple):
    """Sentences to learn from, and those held out to measure."""

    train: list[Example]
    test: list[Example]


def read_annotations(path: Path, labels: Sequence[str], *, extend: bool = False) -> list[Example]:
    """Return the sentences of a file, all checked.

    ``.jsonl``: an object per line with ``tokens`` and ``labels``, lists of equal length. Any other
    name is BIO: a token and its label per line, an empty line between sentences.

    Args:
        path: the file.
        labels: the label set of the tagger.
        extend: take types that the tagger does not know.

    Raises:
        Refused: the file cannot be read, a line is wrong, or there are too few sentences.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise Refused(f"{path} cannot be read ({error}): name a text file in UTF-8") from error
    rows = _json_lines(text, path) if path.suffix == ".jsonl" else _bio(text, path)
    found = []
    for where, tokens, tags in rows:
        _check(where, tokens, tags)
        if not extend:
            _check_known(where, tags, labels)
        found.append(Example(tokens, tags))
    if len(found) < LEAST_SENTENCES:
        raise Refused(
            f"{path} holds {len(found)} sentences, at least {LEAST_SENTENCES} are needed, as every"
            f" {TEST_EVERY}th is kept for the test: label more"
        )
    return found


def _json_lines(text: str, path: Path) -> Iterator[tuple[str, list[str], list[str]]]:
    for number, line in enumerate(text.splitlines(), 1):
        where = f"{path} line {number}"
        if not line.strip():
            continue
        try:
            row = json.loads(line)
        except json.JSONDecodeError as error:
            raise Refused(
                f"{where} is not JSON ({error.msg} at column {error.colno}): write one object a"
                " line"
            ) from error
        fields = row if isinstance(row, dict) else {}
        tokens, tags = _texts(fields.get("tokens")), _texts(fields.get("labels"))
        if tokens is None or tags is None:
            raise Refused(
                f"{where} has no 'tokens' and 'labels' that are lists of texts: write"
                ' {"tokens": ["the", "cup"], "labels": ["O", "B-object"]}'
            )
        yield where, tokens, tags


def _texts(value: object) -> list[str] | None:
    if isinstance(value, list) and all(isinstance(item, str) for item in value):
        return value
    return None


def _bio(text: str, path: Path) -> Iterator[tuple[str, list[str], list[str]]]:
    tokens: list[str] = []
    tags: list[str] = []
    start = 1
    for number, line in enumerate([*text.splitlines(), ""], 1):
        parts = line.split()
        if parts and len(parts) != 2:
            raise Refused(
                f"{path} line {number} has {len(parts)} columns: write a token and its label,"
                " as 'cup B-object', and an empty line between sentences"
            )
        if parts:
            start = start if tokens else number
            tokens.append(parts[0])
            tags.append(parts[1])
        elif tokens:
            yield f"{path} line {start}", tokens, tags
            tokens, tags = [], []


def _check(where: str, tokens: Sequence[str], tags: Sequence[str]) -> None:
    if not tokens or len(tokens) > MAX_TOKENS:
        raise Refused(f"{where} has {len(tokens)} tokens: write 1 to {MAX_TOKENS} a sentence")
    if len(tokens) != len(tags):
        raise Refused(
            f"{where} has {len(tokens)} tokens and {len(tags)} labels: write a label per token"
        )
    if any(not token or any(char.isspace() for char in token) for token in tokens):
        raise Refused(f"{where} has an empty token or one with a space in it: write single words")
    previous = OUTSIDE
    for place, tag in enumerate(tags, 1):
        if not _well_formed(tag):
            raise Refused(
                f"{where} has the label '{tag}' at token {place}: write O, B-type or I-type, the"
                " type in lower-case letters, digits, - and _"
            )
        if not may_follow(previous, tag):
            raise Refused(
                f"{where} has {tag} at token {place} after {previous}: begin with B-{tag[2:]}"
            )
        previous = tag


def _well_formed(tag: str) -> bool:
    kind = tag[2:]
    plain = all(char in _TYPE_MARKS or (char.isascii() and char.isalnum() and char == char.lower())
                for char in kind)  # fmt: skip
    return tag == OUTSIDE or (tag[:2] in ("B-", "I-") and bool(kind) and plain)


def _check_known(where: str, tags: Sequence[str], labels: Sequence[str]) -> None:
    for tag in tags:
        if tag not in labels:
            known = ", ".join(label[2:] for label in labels if label.startswith("B-"))
            raise Refused(
                f"{where} has the label '{tag}', which the tagger does not know: its types are"
                f" {known}; correct it, or add --extend to learn it"
            )


def extended(labels: Sequence[str], examples: Sequence[Example]) -> list[str]:
    """Return the labels with B- and I- of the new types behind, in the order of the text."""
    found = list(labels)
    for example in examples:
        for tag in example.labels:
            if tag != OUTSIDE and f"B-{tag[2:]}" not in found:
                found += [f"B-{tag[2:]}", f"I-{tag[2:]}"]
    return found


def split(examples: Sequence[Example], seed: int) -> Split:
    """Return the sentences shuffled, every fifth held out; equal sentences stay together."""
    groups: dict[tuple[str, ...], list[Example]] = {}
    for example in examples:
        groups.setdefault(tuple(token.lower() for token in example.tokens), []).append(example)
    order = list(groups.values())
    Random(seed).shuffle(order)
    test = [item for group in order[::TEST_EVERY] for item in group]
    kept = [group for at, group in enumerate(order) if at % TEST_EVERY]
    return Split([item for group in kept for item in group], test)
