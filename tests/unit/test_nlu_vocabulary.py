"""One table of canonical words: names, colours, materials, singular and plural."""

import ast
from pathlib import Path

import pytest

from doro_dialogue.surface import is_plural, plural
from doro_nlu.spelling import VALUES, repair
from doro_schemas import vocabulary
from doro_schemas.vocabulary import IRREGULAR_PLURAL, SAME_NAME, canonical_name, canonical_value

ROOT = Path(__file__).resolve().parents[2]
NAMES = {
    "couch": "sofa", "Couches": "sofa", "TV": "television", "TVs": "television",
    "fridge": "refrigerator", "knives": "knife", "book shelves": "bookshelf",
    "bookshelves": "bookshelf", "glasses": "glasses", "wine glasses": "wine glass",
    "glasses of water": "glass of water", "bars of soap": "bar of soap",
    "chest of drawers": "chest of drawers", "loaves of bread": "loaf of bread",
    "pair of slippers": "pair of slippers", "scissors": "scissors", "scarves": "scarf",
    "cookies": "cookie", "berries": "berry", "potatoes": "potato", "boxes": "box",
    "shoes": "shoe", "vases": "vase", "trousers": "trousers", "women": "woman",
    "tv remote": "remote control", "trash_can": "garbage can", "countertop": "counter top",
    "cup": "cup", "mug": "mug", "arm chair": "arm chair", "alarm clock": "alarm clock",
}  # fmt: skip
VALUES_OF = {
    "grey": "gray", "dark grey": "dark gray", "light-grey": "light gray", "wooden": "wood",
    "woollen": "wool", "metallic": "metal", "golden": "gold", "aluminium": "aluminum",
    "dark blue": "dark blue", "Red": "red",
}  # fmt: skip


@pytest.mark.parametrize(("word", "canonical"), NAMES.items())
def test_names(word: str, canonical: str) -> None:
    assert canonical_name(word) == canonical


@pytest.mark.parametrize(("word", "canonical"), VALUES_OF.items())
def test_values(word: str, canonical: str) -> None:
    assert canonical_value(word) == canonical


def test_what_is_canonical_stays() -> None:
    for name in [*NAMES.values(), *SAME_NAME.values(), *IRREGULAR_PLURAL.values()]:
        assert canonical_name(canonical_name(name)) == canonical_name(name)
    for kind, values in VALUES.items():
        for value in sorted(values):
            once = canonical_value(value)
            assert canonical_value(once) == once
            assert repair(value, kind) == value


def test_the_plural_that_the_dialogue_says_is_understood() -> None:
    names = {canonical_name(name) for name in (*NAMES.values(), *IRREGULAR_PLURAL.values())}
    for name in sorted(one for one in names if not is_plural(one)):
        assert canonical_name(plural(name)) == name, plural(name)


def test_no_other_table_maps_the_words_to_one_another() -> None:
    """A dict literal elsewhere with a row of the table in it would be a second one."""
    rows = {**vocabulary.SAME_NAME, **vocabulary.SAME_VALUE, **vocabulary.IRREGULAR_PLURAL}
    twice = []
    for path in sorted(ROOT.glob("*/**/doro_*/**/*.py")):
        if path.name == "vocabulary.py" or "train" in path.parts or ".venv" in path.parts:
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Dict):
                pairs = zip(node.keys, node.values, strict=True)
                said = {(getattr(a, "value", None), getattr(b, "value", None)) for a, b in pairs}
                twice += [(path.name, row) for row in rows.items() if row in said]
    assert twice == []
