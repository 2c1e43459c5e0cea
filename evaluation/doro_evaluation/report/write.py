"""Writes the report: HTML with failures, Markdown with plots beside it."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from importlib.metadata import version
from pathlib import Path

import msgspec

from doro_evaluation.context import Recorded
from doro_evaluation.figures import Figure
from doro_evaluation.outcomes import Outcome
from doro_evaluation.queries.systems import QueryOutcome
from doro_evaluation.report.gallery import (
    ASKED,
    COUNTED,
    Shown,
    counting_failures,
    pictured,
    query_failures,
    spread_over_causes,
)
from doro_evaluation.report.grids import grids
from doro_evaluation.report.headline import headline
from doro_evaluation.report.page import html_page, markdown_page
from doro_evaluation.report.plots import plots

SHOWN = {"gt": "Counting, exact boxes", "all": "Counting, all errors at once"}
QUERY_ERRORS = "cs+sd+fn"


class Report(msgspec.Struct, frozen=True, kw_only=True):
    """What the report is made of.

    Attributes:
        figures: of all tables; command: that gives them again.
        counted: outcomes by (system, error model); asked: of the pairs.
        recordings: by name, for pictures.
        missing: why the baseline has no figures; empty: it has.
    """

    figures: Mapping[str, Figure]
    command: str
    counted: Mapping[tuple[str, str], Sequence[Outcome]]
    asked: Sequence[QueryOutcome]
    recordings: Mapping[str, Recorded]
    missing: str = ""


def write_report(report: Report, out: Path, publish: Path | None) -> Iterator[Path | None]:
    """Write ``report.html`` and ``report.md`` with its plots below ``out``; yield their paths.

    Yields None for each picture made on the way.

    Args:
        publish: folder that gets Markdown, plots and figures as well.
    """
    tables = [headline(report.figures), *grids(report.figures, report.missing)]
    pictures = plots(report.figures)
    shown: dict[str, list[Shown]] = {}
    for heading, failures in _failures(report).items():
        shown[heading] = []
        for one in pictured(failures, report.recordings):
            shown[heading].append(one)
            yield None
    out.mkdir(parents=True, exist_ok=True)
    page = out / "report.html"
    page.write_text(html_page(tables, pictures, shown, _words(report)), encoding="utf-8")
    yield page
    for folder, name in ((out, "report.md"), (publish, "README.md")):
        if folder is None:
            continue
        folder.mkdir(parents=True, exist_ok=True)
        for file, (_, png) in pictures.items():
            (folder / file).write_bytes(png)
        path = folder / name
        path.write_text(markdown_page(tables, pictures, _words(report)), encoding="utf-8")
        yield path
    for folder in (out, *([publish] if publish is not None else [])):
        (folder / "wrong.jsonl").write_bytes(b"".join(_wrong(report)))
        yield folder / "wrong.jsonl"
    if publish is not None:
        figures = {"figures": dict(report.figures), "command": report.command}
        text = json.dumps({**figures, "version": version("doro-evaluation")}, indent=1)
        (publish / "figures.json").write_text(text + "\n", encoding="utf-8")
        yield publish / "figures.json"


def _wrong(report: Report) -> Iterator[bytes]:
    """Yield a JSON line for each item that we count wrongly, and each wrong pair on all views."""
    for (system, errors), outcomes in report.counted.items():
        for failure in counting_failures(outcomes) if system == "ours" else ():
            told = {"errors": errors, "case": failure.title, "why": failure.lines}
            yield msgspec.json.encode(told) + b"\n"
    ours = [one for one in report.asked if one.system == "ours" and one.view == "multi-view"]
    for one in sorted(ours, key=lambda one: one.pair.id):
        verdict = one.verdict
        if not verdict.right:
            why = (f"said: {verdict.text}", f"{verdict.fault}: {verdict.why}")
            case = f"{one.pair.id}: {one.pair.instruction}"
            told = {"errors": QUERY_ERRORS, "case": case, "why": why}
            yield msgspec.json.encode(told) + b"\n"


def _failures(report: Report) -> dict[str, list]:  # type: ignore[type-arg]
    found = {}
    for errors, heading in SHOWN.items():
        wrong = counting_failures(report.counted.get(("ours", errors), ()))
        title = f"{heading}: {len(wrong)} wrong items, some of each cause"
        found[title] = spread_over_causes(wrong, COUNTED // len(SHOWN))
    behind = {one.recording: one for one in report.counted.get(("ours", QUERY_ERRORS), ())}
    ours = [one for one in report.asked if one.system == "ours"]
    wrong = query_failures(ours, behind)
    found[f"Queries on all views: {len(wrong)} wrong pairs, some of each kind"] = (
        spread_over_causes(wrong, ASKED)
    )
    return {title: failures for title, failures in found.items() if failures}


def _words(report: Report) -> list[str]:
    counted = next(iter(report.counted.values()), ())
    rooms = len({one.room for one in counted})
    pairs = len({one.pair.id for one in report.asked})
    return [
        f"{len(counted)} recordings of {rooms} test rooms (iTHOR kitchens and living rooms,"
        f" rendered, one view a reachable cell), {pairs} pairs of recording and instruction."
        " Parameters were tuned on the validation bedrooms and own data only and then frozen;"
        " test rooms only measure. Seeds are fixed: a second run gives the same figures to the"
        " last digit, times apart.",
        "Ours: the services' own cores in process. paper_literal: the paper's region merging and"
        " decision as printed, on the same views and captions. Intervals are 95 % bootstrap"
        " intervals; rooms are drawn, as recordings of one room are not independent.",
        f"Made by: {report.command}",
    ]
