"""Scores of a study made by hand, against values worked out by hand."""

from __future__ import annotations

import json
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from doro_console.__main__ import main
from doro_evaluation.study.agreement import krippendorff_alpha
from doro_evaluation.study.files import key_path, read_answers, read_key, write_key
from doro_evaluation.study.report import figures_of, report
from doro_evaluation.study.score import Scores, read_all, score_study
from doro_nlu.core import Nlu
from doro_nlu.settings import NluSettings
from doro_schemas.errors import Refused
from tests.unit.study_files import answers, rating, small_study, write

STUDY = small_study()
FIRST = [rating("s01q1", 5, 4, "the blue one"), rating("s02q1", 4, 4, "yes please")]
SECOND = [rating("s01q1", 4, 2, "the red one"), rating("s02q1", 4, 5, "the big one")]
THIRD = [rating("s01q2", 1, 3), rating("s02q1", 5, 4, "yes")]


@pytest.fixture(scope="module")
def nlu() -> Nlu:
    return Nlu(NluSettings())


@pytest.fixture
def files(tmp_path: Path) -> list[Path]:
    inattentive = {"checks": [{"id": "c1", "informative": 3, "natural": 4}]}
    return [
        write(tmp_path, "1.json", answers(STUDY, "p1", FIRST)),
        write(tmp_path, "2.json", answers(STUDY, "p2", SECOND)),
        write(tmp_path, "3.json", answers(STUDY, "p3", THIRD)),
        write(tmp_path, "4.json", answers(STUDY, "p4", FIRST, **inattentive)),
    ]


@pytest.fixture
def scores(files: list[Path], nlu: Nlu) -> Scores:
    good, problems = read_all(files, STUDY)
    return score_study(STUDY, good, problems, lambda text: nlu.parse_text(text).graph)


def test_means_and_medians_are_those_worked_out_by_hand(scores: Scores) -> None:
    ours, curt = scores.by_system["ours"], scores.by_system["curt"]
    # ours: scene 1 by p1 and p2, scene 2 by all three; curt: scene 1 by p3, scene 2 by all.
    assert ours["informative"].count == 5
    assert ours["informative"].mean == pytest.approx((5 + 4 + 4 + 4 + 5) / 5)
    assert ours["informative"].median == 4
    assert ours["natural"].mean == pytest.approx((4 + 2 + 4 + 5 + 4) / 5)
    assert curt["informative"].mean == pytest.approx((1 + 4 + 4 + 5) / 4)
    assert curt["informative"].median == 4
    assert scores.by_item["ours"]["s01"]["informative"].mean == pytest.approx(4.5)
    assert scores.by_item["curt"]["s01"]["natural"].mean == pytest.approx(3)
    difference = scores.differences["curt"]["informative"].mean
    assert difference == pytest.approx(22 / 5 - 14 / 4)


def test_a_reply_counts_by_what_the_dialogue_makes_of_it(scores: Scores) -> None:
    # "the blue one" is what was wanted, "the red one" is not, nobody knows "the big one".
    assert scores.replies["ours"] == {"resolved": 3, "wrong": 1, "asked_again": 1, "cannot_tell": 0}
    assert scores.by_system["ours"]["reply"].mean == pytest.approx(3 / 5)
    assert scores.replies["curt"]["cannot_tell"] == 1
    assert scores.by_system["curt"]["reply"].mean == pytest.approx(2 / 4)


def test_failed_checks_are_left_out_and_counted(scores: Scores) -> None:
    assert scores.participants == ["p1", "p2", "p3"]
    assert scores.failed == ["p4"]
    assert figures_of(scores)["study/all/failed_checks"] == 1
    assert figures_of(scores)["study/all/participants"] == 3


def test_agreement_is_over_texts_and_only_once_where_two_systems_say_the_same(
    scores: Scores,
) -> None:
    expected = krippendorff_alpha([[5, 4], [1], [4, 4, 5]])
    assert scores.agreement["informative"]["ordinal"] == pytest.approx(expected)


def test_alpha_is_that_of_the_published_example() -> None:
    none = 0
    observers = [
        [1, 2, 3, 3, 2, 1, 4, 1, 2, none, none, none],
        [1, 2, 3, 3, 2, 2, 4, 1, 2, 5, none, 3],
        [none, 3, 3, 3, 2, 3, 4, 2, 2, 5, 1, none],
        [1, 2, 3, 3, 2, 4, 4, 1, 2, 5, 1, none],
    ]
    units = [[one[k] for one in observers if one[k]] for k in range(12)]
    # K. Krippendorff, Computing Krippendorff's Alpha-Reliability, 2011, example C.
    assert krippendorff_alpha(units, "ordinal") == pytest.approx(0.815, abs=5e-4)
    assert krippendorff_alpha(units, "interval") == pytest.approx(0.849, abs=5e-4)


@pytest.mark.parametrize("units", [[], [[3], [4]], [[3, 3], [3, 3]]])
def test_alpha_is_undefined_where_nothing_can_be_compared(units: list[list[int]]) -> None:
    assert krippendorff_alpha(units) is None


def test_the_interval_holds_the_mean_and_repeats(scores: Scores, files: list[Path]) -> None:
    ours = scores.by_system["ours"]["informative"]
    assert 4 <= ours.low <= ours.mean <= ours.high <= 5
    assert ours.low < ours.high
    good, _ = read_all(files, STUDY)
    again = score_study(STUDY, good, [], lambda _: None)
    assert again.by_system["ours"]["informative"] == ours


def test_equal_ratings_have_an_interval_of_one_point(tmp_path: Path) -> None:
    ratings = [rating("s01q1", 3, 3), rating("s02q1", 3, 3)]
    paths = [write(tmp_path, f"{k}.json", answers(STUDY, f"p{k}", ratings)) for k in range(3)]
    good, _ = read_all(paths, STUDY)
    found = score_study(STUDY, good, [], lambda _: None).by_system["ours"]["natural"]
    assert (found.low, found.mean, found.high) == (3, 3, 3)


def test_nobody_left_gives_no_figure_instead_of_a_wrong_one() -> None:
    empty = score_study(STUDY, [], [], lambda _: None)
    assert np.isnan(empty.by_system["ours"]["informative"].mean)
    assert "study/ours/informative/mean" not in figures_of(empty)
    assert "0 participants" in report(STUDY, empty)


BAD: list[tuple[str, Any, str]] = [
    ("other digest", {"study": {"id": "x", "digest": "0"}}, "answers study 'x'"),
    ("no consent", {"consent": False}, "did not consent"),
    ("no participant", {"participant": " "}, "has no id"),
    ("check missing", {"checks": []}, "check c1 is not answered"),
    ("scene missing", {"answers": FIRST[:1]}, "scene s02 is not rated"),
    ("twice", {"answers": [*FIRST, FIRST[0]]}, "rated twice"),
    ("unknown", {"answers": [*FIRST, rating("s09q1", 1, 1)]}, "is not in the study"),
    ("range", {"answers": [FIRST[0], rating("s02q1", 6, 1)]}, "outside 1 to 5"),
    ("type", {"answers": [FIRST[0], {**FIRST[1], "natural": "5"}]}, "is no file of answers"),
    ("version", {"version": 2}, "has version 2"),
    ("schema", {"schema": "x"}, "is no file of answers"),
]


@pytest.mark.parametrize(("change", "sentence"), [one[1:] for one in BAD], ids=[b[0] for b in BAD])
def test_a_bad_file_gets_one_sentence(tmp_path: Path, change: Any, sentence: str) -> None:
    path = write(tmp_path, "bad.json", {**answers(STUDY, "p", FIRST), **change})
    with pytest.raises(Refused, match=sentence) as caught:
        read_answers(path, STUDY)
    assert "bad.json" in caught.value.reason
    assert "\n" not in caught.value.reason


def test_bad_files_are_told_and_the_others_scored(tmp_path: Path, files: list[Path]) -> None:
    garbage = tmp_path / "garbage.json"
    garbage.write_bytes(b"\xff\x00{")
    good, problems = read_all([garbage, files[0], files[0], tmp_path / "none.json"], STUDY)
    assert [one.participant for one in good] == ["p1"]
    assert len(problems) == 3
    assert "the answers of 'p1' are there already" in problems[1]


def test_a_key_that_was_changed_or_is_missing_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "study.json"
    write_key(path, STUDY)
    assert read_key(path) == read_key(tmp_path / "study.html") == STUDY
    path.write_text(path.read_text().replace("INFORM-MISMATCH", "CONFIRM"))
    with pytest.raises(Refused, match="was changed"):
        read_key(path)
    with pytest.raises(Refused, match="must lie beside"):
        read_key(tmp_path / "other.html")


def test_all_texts_of_a_scene_are_asked_for_in_the_design_all(tmp_path: Path) -> None:
    study = small_study("all")
    path = write(tmp_path, "p.json", answers(study, "p", FIRST))
    with pytest.raises(Refused, match="scene s01 is not rated"):
        read_answers(path, study)


def test_the_command_scores_and_writes_figures_and_report(
    tmp_path: Path, files: list[Path]
) -> None:
    page, figures, out = (tmp_path / name for name in ("study.html", "f.json", "r.html"))
    write_key(key_path(page), STUDY)
    arguments = ["study", "score", str(page), *map(str, files), str(tmp_path / "none.json")]
    done = CliRunner().invoke(main, [*arguments, "--json", str(figures), "--report", str(out)])
    assert done.exit_code == 0, done.output
    written = json.loads(figures.read_text())
    assert set(written) == {"figures", "command", "seed", "version"}
    assert written["figures"]["study/ours/informative/mean"] == pytest.approx(4.4)
    assert written["figures"]["study/ours/resolves/mean"] == pytest.approx(0.6)
    assert written["figures"]["study/all/bad_files"] == 1
    text = out.read_text(encoding="utf-8")
    HTMLParser().feed(text)
    assert "none.json" in text
    assert "http" not in text


def test_the_command_fails_where_nothing_is_left(tmp_path: Path) -> None:
    write_key(tmp_path / "study.json", STUDY)
    arguments = ["study", "score", str(tmp_path / "study.json"), str(tmp_path / "none.json")]
    assert CliRunner().invoke(main, arguments).exit_code == 1
