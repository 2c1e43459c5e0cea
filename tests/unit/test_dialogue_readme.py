"""The README is tested against the code: where paper_literal differs, and the settings."""

from __future__ import annotations

import re
from pathlib import Path

import msgspec
import pytest

from doro_dialogue.decide_lines import decide_record
from doro_dialogue.settings import DialogueSettings

README = (Path(__file__).resolve().parents[2] / "services/dialogue/README.md").read_text("utf-8")


def rows(heading: str) -> list[list[str]]:
    """The rows of the first table under a heading, without its head."""
    section = README.split(f"## {heading}", 1)[1].split("\n## ", 1)[0]
    lines = [line for line in section.splitlines() if line.startswith("|")][2:]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


LITERAL = rows("Where `paper_literal` differs")


@pytest.mark.parametrize("row", LITERAL, ids=[row[0] for row in LITERAL])
def test_ours_and_the_papers_formulas_are_as_the_readme_says(row):
    seen, ours, literal, _ = row
    colors = [] if seen == "nothing" else seen.split(", ")
    record = {
        "id": 1,
        "graph": {"name": "cup", "attributes": {"color": "red"}},
        "instances": [
            {"id": i, "graph": {"name": "cup", "attributes": {} if c == "?" else {"color": c}}}
            for i, c in enumerate(colors)
        ],
    }
    for flag, said in ((False, ours), (True, literal)):
        result = decide_record(record, paper_literal=flag)
        assert f"{result['state']} `{result['reason']}`" == said


def test_the_table_has_rows_that_differ_and_rows_that_do_not():
    same = [row for row in LITERAL if row[1] == row[2]]
    assert len(LITERAL) - len(same) >= 7
    assert len(same) >= 4
    assert all(row[3] for row in LITERAL)


def test_every_setting_is_described_with_its_default():
    told = {row[0].strip("`"): row[1] for row in rows("Settings")}
    fields = {field.name: field.default for field in msgspec.structs.fields(DialogueSettings)}
    assert set(told) == set(fields)
    for name, default in fields.items():
        words = {"": "empty", "False": "false", "True": "true"}
        text = words.get(str(default), str(default).removesuffix(".0"))
        assert told[name] == text, name


def test_the_files_that_the_readme_names_are_there():
    package = Path(__file__).resolve().parents[2] / "services/dialogue/doro_dialogue"
    named = set(re.findall(r"`(\w+\.py)`", README))
    assert named
    assert not {name for name in named if not (package / name).exists()}
