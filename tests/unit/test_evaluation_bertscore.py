"""BERTScore without torch: against values of the package bert-score, and the formula by hand."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from doro_evaluation.queries import bertscore
from doro_evaluation.queries.bertscore import MODEL, MODEL_DIR, VOCABULARY, Similarity, _f1
from doro_schemas.errors import Refused

QUERY = "I found one red cup on top of the table, and one blue cup near the sink; which one?"


def test_equal_texts_score_one_and_word_order_counts() -> None:
    assert bertscore.bertscore([QUERY], [[QUERY]])[0] == pytest.approx(1.0, abs=1e-6)
    assert bertscore.cosine([QUERY], [[QUERY]])[0] == pytest.approx(1.0, abs=1e-6)
    swapped = QUERY.replace("red", "x").replace("blue", "red").replace("x", "blue")
    assert bertscore.bertscore([QUERY], [[swapped]])[0] < 0.999


def test_values_are_those_of_bert_score() -> None:
    lines = (MODEL_DIR / "bert_score.jsonl").read_text().splitlines()
    pairs = [json.loads(line) for line in lines]
    assert len(pairs) == 50
    own = bertscore.bertscore(
        [pair["candidate"] for pair in pairs], [[pair["reference"]] for pair in pairs]
    )
    off = np.array(own) - [pair["f1"] for pair in pairs]
    # The shipped weights are int8, bert-score's float32.
    assert np.abs(off).max() < 0.005
    assert abs(off.mean()) < 0.001


def test_formula_by_hand() -> None:
    """Pieces between begin and end count; begin and end may be what is most similar."""
    begin, end = [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]
    one = np.array([begin, [0.0, 0.0, 1.0], [0.6, 0.0, 0.8], end], np.float32)
    other = np.array([begin, [0.0, 0.0, 1.0], end], np.float32)
    # precision: 1 and max(0.6 with begin, 0.8) = 0.8; recall: 1
    assert _f1(one, other) == pytest.approx(2 * 0.9 * 1.0 / 1.9)
    # no piece between the marks: nothing to compare
    assert _f1(np.array([begin, end], np.float32), other) == 0.0


def test_best_of_the_references_and_none() -> None:
    best = bertscore.bertscore([QUERY, QUERY, ""], [["Okay.", QUERY], [], [QUERY]])
    assert best[0] == pytest.approx(1.0, abs=1e-6)
    assert best[1:] == [0.0, 0.0]
    assert bertscore.cosine([QUERY], [[]]) == [0.0]


def test_a_text_scores_the_same_in_any_company() -> None:
    alone = Similarity().f1(QUERY, "I could not find a red cup.")
    crowd = Similarity()
    crowd.embed([QUERY.replace("red", color) for color in ("green", "white", "black")])
    assert crowd.f1(QUERY, "I could not find a red cup.") == pytest.approx(alone, abs=1e-6)


def test_missing_and_damaged_files_are_told_in_a_sentence(tmp_path: Path) -> None:
    assert bertscore.available() == ""
    assert "vocabulary.json" in bertscore.available(tmp_path)
    shutil.copy(MODEL_DIR / VOCABULARY, tmp_path)
    with pytest.raises(Refused, match="cannot be read"):
        Similarity(tmp_path)
    (tmp_path / MODEL).write_bytes((MODEL_DIR / MODEL).read_bytes()[:-100])
    with pytest.raises(Refused, match="is not the file"):
        Similarity(tmp_path)
