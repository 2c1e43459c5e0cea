"""The perception README tells the steps of training as the file of figures has them."""

from __future__ import annotations

from pathlib import Path

import pytest

from doro_evaluation.perception.steps import PICTURE, TARGETS, draw, read_steps, table
from doro_schemas.errors import Refused

README = Path(__file__).resolve().parents[2] / "services" / "perception" / "README.md"


def test_the_readme_has_the_table_of_the_file() -> None:
    assert table(read_steps()) in README.read_text(encoding="utf-8"), (
        "copy the output of 'python -m doro_evaluation.perception.steps' into it"
    )
    assert PICTURE.name in README.read_text(encoding="utf-8")


def test_the_curve_is_drawn_with_every_target(tmp_path: Path) -> None:
    steps = read_steps()
    assert all(0 <= getattr(step, name) <= 1 for step in steps for name in TARGETS)
    draw(steps, tmp_path / "steps.png")
    assert (tmp_path / "steps.png").read_bytes().startswith(b"\x89PNG")


def test_a_damaged_file_is_refused_with_its_name(tmp_path: Path) -> None:
    (tmp_path / "steps.json").write_text('[{"trained": 3}]', encoding="utf-8")
    with pytest.raises(Refused, match=r"steps\.json cannot be read"):
        read_steps(tmp_path / "steps.json")
