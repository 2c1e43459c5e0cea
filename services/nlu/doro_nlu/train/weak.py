"""Weak labels on human sentences: what the teachers agree on and the parser can build.

``python -m doro_nlu.train.weak --teacher DIR... --texts FILE... --out OUT.jsonl`` (no torch
needed). The first teacher's labels are written; sentences on which another one disagrees are not.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path

from doro_nlu.language import not_english
from doro_nlu.parser import parse
from doro_nlu.tagger import Tagged, Tagger, load_tagger
from doro_nlu.tokens import tokenize
from doro_nlu.train.annotate import Example

MAX_TOKENS = 30


def read_texts(paths: Sequence[Path]) -> list[str]:
    """Return the different texts of JSON-lines files with ``text``, in order."""
    texts: dict[str, None] = {}
    for path in paths:
        for line in path.read_text(encoding="utf-8").splitlines():
            texts.setdefault(json.loads(line)["text"].strip())
    return list(texts)


def weak_examples(
    teachers: Sequence[Tagger], texts: Sequence[str], least_probability: float
) -> list[Example]:
    """Return the texts with the teachers' labels, kept where all of these hold.

    Every label of every teacher has at least ``least_probability``, the teachers agree, the text
    is English, and if there is a graph, it uses every relation label (a connector without
    landmark is a sign of a wrong label).
    """
    kept = []
    for start in range(0, len(texts), 64):
        chunk = [tokenize(text) for text in texts[start : start + 64]]
        chunk = [tokens for tokens in chunk if 0 < len(tokens) <= MAX_TOKENS]
        for versions in zip(*(teacher.tag(chunk) for teacher in teachers), strict=True):
            if _agreed(versions, least_probability) and usable(versions[0], teachers[0]):
                kept.append(Example(versions[0].tokens, versions[0].labels))
    return kept


def _agreed(versions: Sequence[Tagged], least_probability: float) -> bool:
    return all(
        tagged.labels == versions[0].labels and min(tagged.probabilities) >= least_probability
        for tagged in versions
    )


def usable(tagged: Tagged, teacher: Tagger) -> bool:
    """Tell whether a sentence is English and its graph, if any, uses every relation label."""
    if not_english(tagged.tokens, teacher.knows):
        return False
    found = parse(tagged, "").graph
    connectors = sum(label.startswith("B-is-") for label in tagged.labels)
    return connectors == 0 if found is None else _relations(found) >= connectors


def _relations(graph: object) -> int:
    relations = getattr(graph, "relations", [])
    return sum(1 + _relations(relation.target) for relation in relations)


def read_labelled(path: Path) -> list[Example]:
    """Return the sentences of a JSON-lines file with ``tokens`` and ``labels``."""
    rows = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]
    return [Example(row["tokens"], row["labels"]) for row in rows]


def main() -> None:
    """Write the weakly labelled sentences."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--teacher", type=Path, action="append", required=True)
    parser.add_argument("--texts", type=Path, nargs="+", required=True)
    parser.add_argument("--sure", type=float, default=0.8, help="least probability of a label")
    parser.add_argument("--out", type=Path, required=True)
    arguments = parser.parse_args()
    texts = read_texts(arguments.texts)
    teachers = [load_tagger(directory) for directory in arguments.teacher]
    kept = weak_examples(teachers, texts, arguments.sure)
    lines = (json.dumps({"tokens": item.tokens, "labels": item.labels}) for item in kept)
    arguments.out.write_text("\n".join(lines) + "\n", encoding="utf-8")
    print(f"{len(kept)} of {len(texts)} sentences kept")


if __name__ == "__main__":
    main()
