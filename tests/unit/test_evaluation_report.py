"""The report: tables, plots and headline of made-up figures, and a gallery of a failure."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path

import pytest

from doro_evaluation.outcomes import Outcome, Thing
from doro_evaluation.queries.judge import Verdict
from doro_evaluation.queries.pairs import Pair
from doro_evaluation.queries.systems import QueryOutcome
from doro_evaluation.report.gallery import (
    Failure,
    counting_failures,
    pictured,
    query_failures,
    spread_over_causes,
)
from doro_evaluation.report.grids import grids
from doro_evaluation.report.headline import MARKS, headline, read_figures, with_headline
from doro_evaluation.report.plots import plots
from doro_evaluation.report.write import Report, write_report
from doro_schemas.errors import Refused
from doro_schemas.graph import ObjectGraph

SIZE = (0.1, 0.1, 0.1)
FIGURES: dict[str, float | int | str] = {
    "counting/ours/gt/average/f1": 0.97,
    "counting/ours/gt/average/f1_low": 0.96,
    "counting/ours/gt/average/f1_high": 0.98,
    "counting/ours/gt/1/f1": 0.99,
    "counting/ours/gt/1/items": 60,
    "counting/ours/gt/3/f1": 0.96,
    "counting/ours/gt/3/items": 20,
    "counting/ours/gt/accuracy": 0.95,
    "counting/paper_literal/gt/average/f1": 0.41,
    "causes/ours/gt/wrong_items": 2,
    "causes/ours/gt/one_thing_counted_twice": 3,
    "multi-view/ours/qa": 0.94,
    "multi-view/ours/pairs": 600,
    "seen/ours/gt/21/found": 0.99,
    "seen/ours/gt/21/things": 40,
    "speed/machine": "a machine",
    "speed/aggregation/p50_ms": 2.5,
}


def test_tables_have_ours_the_papers_and_what_was_wanted() -> None:
    tables = {grid.title: grid for grid in grids(FIGURES, "not installed: make it")}
    counting = next(grid for title, grid in tables.items() if title.startswith("Table II:"))
    rows = {row[0]: row for row in counting.rows}
    assert rows["exact boxes (GT): ours"][1] == "0.990, 60"
    assert rows["exact boxes (GT): ours"][6] == "0.970 (0.96-0.98)"
    assert rows["exact boxes (GT): paper: DoRO"][1:3] == ["0.97", "0.88"]
    assert rows["wanted"][3] == "0.95"
    asked = next(grid for title, grid in tables.items() if title.startswith("Table IV"))
    told = {row[0]: row[1] for row in asked.rows}
    assert told["ours"] == "0.940"
    assert told["baseline, one view"] == "not installed: make it"
    assert told["paper: DoRO"] == "0.77"
    assert "Wanted and not reached" not in tables
    worse = {**FIGURES, "counting/ours/gt/3/f1": 0.9, "causes/ours/gt/of_3/lost": 2}
    (row,) = next(grids(worse)).rows
    assert row == ["counting, exact boxes (GT), 3 true", "0.900", "0.95", "lost 2"]
    causes = tables["Why items are counted wrongly (ours)"]
    assert ["one thing counted twice", "3"] in [list(row) for row in causes.rows]


def test_a_page_escapes_what_is_in_a_cell() -> None:
    (grid,) = (g for g in grids({**FIGURES, "speed/machine": "<b>&"}) if g.title == "Speed")
    assert "&lt;b&gt;&amp;" in grid.page()
    assert "<b>" not in grid.page()


def test_the_headline_stands_between_its_marks() -> None:
    start, end = MARKS
    text = with_headline(f"before\n{start}\nold\n{end}\nafter", FIGURES)
    assert text.startswith(f"before\n{start}\n|")
    assert text.endswith(f"{end}\nafter")
    assert "old" not in text
    assert "| all views: QA | 0.940 | 0.93 | 0.77 |  |  |" in text
    assert with_headline(text, FIGURES) == text
    assert not headline({}).rows


def test_plots_are_pictures_and_the_same_twice() -> None:
    made = plots(FIGURES)
    assert list(made) == ["f1_by_count.png", "f1_by_error.png", "found_by_views.png"]
    assert all(png.startswith(b"\x89PNG") for _, png in made.values())
    assert plots(FIGURES) == made
    assert plots({}) == {}


def thing(kind: str, x: float, name: str = "") -> Thing:
    return Thing(kind, (x, 0.8, 0.0), SIZE, 5, name)


WRONG = Outcome(
    "default-FloorPlan1", "FloorPlan1", "default", "ours", "gt", 9,
    (thing("Cup", 0, "Cup|1"), thing("Cup", 2, "Cup|2")), (thing("Cup", 0),),
)  # fmt: skip


def pair_outcome(fault: str) -> QueryOutcome:
    pair = Pair(
        "p/1", WRONG.recording, "name", "true", "bring the cup", "bring", ObjectGraph("cup")
    )
    verdict = Verdict(fault, "CONFIRM", "INFORM-AMBIGUITY", "Okay.", ["I found two cups."], "why")  # type: ignore[arg-type]
    return QueryOutcome(pair, "ours", "multi-view", verdict)


def test_failures_are_told_and_drawn() -> None:
    (counted,) = counting_failures([WRONG])
    assert "2 true, 1 found" in counted.title
    assert counted.lines[0] == "not found, though three views or more show it."
    assert counted.lines[1] == "Views that show each, of 9: A 5, B 5."
    behind = {WRONG.recording: WRONG}
    (asked,) = query_failures([pair_outcome("state"), pair_outcome("")], behind)
    assert asked.lines[1] == "True: I found two cups."
    shown = list(pictured([counted], {}))
    assert shown[0].note == "its recording is not there"
    assert shown[0].pictures[0].startswith("data:image/png;base64,")


def test_causes_take_turns_and_recordings_too() -> None:
    def failure(cause: str, recording: str) -> Failure:
        return Failure(recording, "Cup", "", (), cause, WRONG)

    many = [failure("a", "r1"), failure("a", "r1"), failure("a", "r2"), failure("b", "r3")]
    chosen = spread_over_causes(many, 3)
    assert Counter(one.cause for one in chosen) == {"a": 2, "b": 1}
    assert {one.recording for one in chosen} == {"r1", "r2", "r3"}


def test_a_report_is_one_page_and_markdown(tmp_path: Path) -> None:
    report = Report(
        figures=FIGURES, command="doro eval all", counted={("ours", "gt"): [WRONG]},
        asked=[pair_outcome("state")], recordings={}, missing="not installed",
    )  # fmt: skip
    paths = [path for path in write_report(report, tmp_path / "out", tmp_path / "pub") if path]
    assert [path.name for path in paths] == [
        "report.html", "report.md", "README.md", "wrong.jsonl", "wrong.jsonl", "figures.json",
    ]  # fmt: skip
    page = paths[0].read_text()
    assert "1 wrong items" in page
    # Self-contained: every picture lies inside, nothing is fetched.
    assert "http" not in page
    assert page.count("data:image/png;base64,") == 3 + 1
    assert "](f1_by_count.png)" in paths[2].read_text()
    assert (tmp_path / "pub" / "f1_by_count.png").exists()
    wrong = [json.loads(line) for line in paths[3].read_text().splitlines()]
    assert [one["case"].split(":")[0] for one in wrong] == ["default-FloorPlan1, Cup", "p/1"]
    assert read_figures(paths[5]) == json.loads(paths[5].read_text())["figures"] == FIGURES
    again = [path for path in write_report(report, tmp_path / "two", None) if path]
    assert again[0].read_bytes() == paths[0].read_bytes()


def test_figures_that_are_not_there_are_refused(tmp_path: Path) -> None:
    with pytest.raises(Refused, match="doro eval all"):
        read_figures(tmp_path / "figures.json")
