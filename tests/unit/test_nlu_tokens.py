"""The tokenizer follows the annotation guide."""

import json
from pathlib import Path

import pytest

from doro_nlu.labels import LABELS, may_follow
from doro_nlu.tokens import tokenize

SHARED = Path(__file__).parents[3] / "shared" / "data" / "language" / "gold_dev.jsonl"


@pytest.mark.parametrize(
    ("text", "tokens"),
    [
        ("Bring me the red cup.", ["Bring", "me", "the", "red", "cup", "."]),
        ("the yellow-handled knife", ["the", "yellow-handled", "knife"]),
        ("grab the cylinder that's in it", ["grab", "the", "cylinder", "that's", "in", "it"]),
        ("the baby's cup", ["the", "baby's", "cup"]),
        ("there 's a cup", ["there", "'s", "a", "cup"]),
        ("i 'd like it", ["i", "'d", "like", "it"]),
        ("red/white, (really)!?", ["red/white", ",", "(", "really", ")", "!", "?"]),
        ("the baby\u2019s cup", ["the", "baby's", "cup"]),
        ("level 2", ["level", "2"]),
        ("", []),
        (" \t\n", []),
    ],
)
def test_tokens(text: str, tokens: list[str]) -> None:
    assert tokenize(text) == tokens


def test_tokens_of_the_gold_sentences() -> None:
    if not SHARED.is_file():
        pytest.skip("the labelled sentences are not on this machine")
    for line in SHARED.read_text(encoding="utf-8").splitlines():
        row = json.loads(line)
        assert tokenize(row["text"]) == row["tokens"]


def test_labels_are_bio_over_seven_types() -> None:
    assert len(LABELS) == 15
    assert may_follow("B-color", "I-color")
    assert may_follow("I-color", "I-color")
    assert not may_follow("O", "I-color")
    assert not may_follow("B-object", "I-color")
