"""The shipped baseline: the same answer every time, and one sentence for what cannot be loaded."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from doro_evaluation.baseline import MISSING, MODEL_DIR, Baseline, available, load
from doro_evaluation.baseline.model import DECODER, ENCODER, VOCABULARY
from doro_evaluation.baseline.reading import read_query
from doro_evaluation.baseline.text import VocabularyFile, read_vocabulary
from doro_schemas.errors import Refused
from doro_schemas.graph import ObjectGraph

CUPS = ["a red plastic cup on the white wooden table", "a blue plastic cup near the gray sink"]


@pytest.fixture(scope="module")
def baseline() -> Baseline:
    return load()


def state_of(text: str) -> str:
    return read_query(text, lambda phrase: ObjectGraph("cup")).state


def test_answers_are_the_same_every_time(baseline: Baseline) -> None:
    said = baseline.answer(CUPS, "bring me a cup")
    assert said == baseline.answer(CUPS, "bring me a cup") == load().answer(CUPS, "bring me a cup")
    assert baseline.answer_views([CUPS], "bring me a cup") == said


def test_answers_are_the_templates_sentences(baseline: Baseline) -> None:
    """Not that they are right: that a state can be read from them."""
    assert state_of(baseline.answer(CUPS, "bring me a cup")) == "INFORM-AMBIGUITY"
    assert state_of(baseline.answer(CUPS[:1], "bring me a cup")) == "CONFIRM"
    assert state_of(baseline.answer([], "bring me a cup")) == "INFORM-MISSING"


def test_other_nouns_are_not_read(baseline: Baseline) -> None:
    others = ["a red paper book on the white wooden table", "a white wooden table near the cup"]
    assert baseline.answer([*others, *CUPS], "get a cup") == baseline.answer(CUPS, "get a cup")


@pytest.mark.parametrize("captions", [[], [""], ["?!"], ["\ud800 cup"], ["cup " * 5000]])
def test_odd_captions_get_an_answer(baseline: Baseline, captions: list[str]) -> None:
    assert isinstance(baseline.answer(captions, "bring me the cup"), str)


def test_views_beyond_the_input_are_cut(baseline: Baseline) -> None:
    assert baseline.answer_views([CUPS] * 300, "bring me a cup") == baseline.answer_views(
        [CUPS] * 400, "bring me a cup"
    )


def test_no_instruction_is_refused(baseline: Baseline) -> None:
    with pytest.raises(Refused, match="empty"):
        baseline.answer(CUPS, " ")


def test_what_cannot_be_loaded_is_told_in_a_sentence(tmp_path: Path) -> None:
    assert available() == ""
    assert available(tmp_path) == MISSING
    shutil.copy(MODEL_DIR / VOCABULARY, tmp_path)
    with pytest.raises(Refused, match="cannot be read"):
        load(tmp_path)
    shutil.copy(MODEL_DIR / DECODER, tmp_path)
    (tmp_path / ENCODER).write_bytes(b"damaged")
    with pytest.raises(Refused, match="is not the file"):
        load(tmp_path)
    assert "is not the file" in available(tmp_path)
    (tmp_path / VOCABULARY).write_bytes(b"{")
    with pytest.raises(Refused, match="is damaged"):
        load(tmp_path)


def test_a_file_that_is_no_model_is_told_in_a_sentence(tmp_path: Path) -> None:
    import hashlib

    import msgspec

    found = read_vocabulary(MODEL_DIR / VOCABULARY)
    (tmp_path / ENCODER).write_bytes(b"damaged")
    digest = hashlib.sha256(b"damaged").hexdigest()
    changed = VocabularyFile(found.pieces, {**found.sha256, ENCODER: digest})
    (tmp_path / VOCABULARY).write_bytes(msgspec.json.encode(changed))
    with pytest.raises(Refused, match="no usable ONNX file"):
        load(tmp_path)
