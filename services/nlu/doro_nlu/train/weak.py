"""Weak labels on human sentences: what a teacher is sure of and the parser can build."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

from doro_nlu.language import not_english
from doro_nlu.parser import parse
from doro_nlu.tagger import Tagger
from doro_nlu.tokens import tokenize
from doro_nlu.train.annotate import Example

_MAX_TOKENS = 30


def read_texts(paths: Sequence[Path]) -> list[str]:
    """Return the different texts of JSON-lines files with ``text``, in order."""
    texts: dict[str, None] = {}
    for path in paths:
        for line in path.read_text(encoding="utf-8").splitlines():
            texts.setdefault(json.loads(line)["text"].strip())
    return list(texts)


def weak_examples(teacher: Tagger, texts: Sequence[str], least_probability: float) -> list[Example]:
    """Return the texts with the teacher's labels, kept where all of these hold.

    Every label has at least ``least_probability``, the text is English, and the parser makes a
    graph that uses every relation label (a connector without landmark is a sign of a wrong label).
    """
    kept = []
    for start in range(0, len(texts), 64):
        chunk = [tokenize(text) for text in texts[start : start + 64]]
        for tagged in teacher.tag([tokens for tokens in chunk if 0 < len(tokens) <= _MAX_TOKENS]):
            if min(tagged.probabilities) < least_probability:
                continue
            if not_english(tagged.tokens, teacher.knows):
                continue
            found = parse(tagged, "").graph
            connectors = sum(label.startswith("B-is-") for label in tagged.labels)
            if found is not None and _relations(found) >= connectors:
                kept.append(Example(tagged.tokens, tagged.labels))
    return kept


def _relations(graph: object) -> int:
    relations = getattr(graph, "relations", [])
    return sum(1 + _relations(relation.target) for relation in relations)
