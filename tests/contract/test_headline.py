"""The README's headline table is that of the published figures."""

from __future__ import annotations

from doro_evaluation.report.headline import MARKS, headline, read_figures, with_headline
from tools.generate import FIGURES, HEADLINE, ROOT


def test_the_readme_shows_the_published_figures() -> None:
    text = (ROOT / HEADLINE).read_text(encoding="utf-8")
    figures = read_figures(FIGURES)
    assert all(mark in text for mark in MARKS)
    assert len(headline(figures).rows) >= 13
    assert text == with_headline(text, figures), "run 'make generate'"
