"""What a study comes to: flat figures, a table for the terminal, and a page to pass on."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from html import escape

import numpy as np
from rich.table import Table

from doro_evaluation.figures import Figure
from doro_evaluation.study.files import LIKERT, SCALES, Study
from doro_evaluation.study.score import OUTCOMES, REPLY, Score, Scores

TITLES = {"informative": "informative", "natural": "natural", REPLY: "reply resolves"}
OUTCOME_WORDS = {
    "resolved": "got what was wanted",
    "wrong": "got something else",
    "asked_again": "asked again, or nothing",
    "cannot_tell": "could not tell what to answer",
}
STYLE = """
:root { --ink: #1b1d21; --soft: #5a606b; --line: #d4d7dc; --page: #fbfbf9; --bar: #3b78c9; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #eceef1; --soft: #a9b0bb; --line: #454a53; --page: #17191d; --bar: #8ab4f8; }
}
body { margin: 0 auto; padding: 1rem; max-width: 60rem; background: var(--page); color: var(--ink);
  font: 1rem/1.5 system-ui, "Segoe UI", Roboto, Arial, sans-serif; }
h1 { font-size: 1.4rem; } h2 { font-size: 1.1rem; margin-top: 2rem; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
th, td { padding: .3rem .9rem .3rem 0; text-align: left; border-bottom: 1px solid var(--line);
  vertical-align: top; }
td.number { text-align: right; white-space: nowrap; }
td.said { min-width: 16rem; }
.soft { color: var(--soft); }
svg { display: block; } svg .axis { stroke: var(--line); } svg .range { stroke: var(--bar); }
svg circle { fill: var(--bar); } svg text { fill: var(--soft); font-size: 11px; }
"""
PLOT_PX = (220, 26)


def figures_of(scores: Scores) -> Mapping[str, Figure]:
    """Return the flat figures; what is not defined is left out."""
    figures: dict[str, Figure] = {
        "study/all/participants": len(scores.participants),
        "study/all/failed_checks": len(scores.failed),
        "study/all/bad_files": len(scores.problems),
    }
    for system, by_scale in scores.by_system.items():
        for what, score in by_scale.items():
            name = "resolves" if what == REPLY else what
            figures[f"study/{system}/{name}/count"] = score.count
            for field in ("mean", "median", "low", "high"):
                value = float(getattr(score, field))
                if not np.isnan(value):
                    figures[f"study/{system}/{name}/{field}"] = round(value, 4)
        for outcome, count in scores.replies[system].items():
            figures[f"study/{system}/replies/{outcome}"] = count
    for scale, levels in scores.agreement.items():
        for level, alpha in levels.items():
            if alpha is not None:
                figures[f"study/all/{scale}/alpha_{level}"] = round(alpha, 4)
    return figures


def table_of(study: Study, scores: Scores) -> Table:
    """Return the scores by system, for the terminal."""
    table = Table("system", "scale", "n", "mean", "95 % interval", "median", title=_people(scores))
    for system in study.systems:
        for what, score in scores.by_system[system].items():
            table.add_row(system, TITLES[what], *_cells(score, what))
    for scale in SCALES:
        alpha = scores.agreement[scale]
        table.add_row("agreement", f"alpha, {scale}", "", _number(alpha["ordinal"]), "", "")
    return table


def item_table(study: Study, scores: Scores) -> Table:
    """Return the means of every scene, by system."""
    table = Table("scene", "state", "system", *(TITLES[what] for what in (*SCALES, REPLY)))
    for item in study.items:
        for system in study.systems:
            by_scale = scores.by_item[system][item.id]
            if by_scale[SCALES[0]].count:
                means = (_mean(by_scale[what]) for what in (*SCALES, REPLY))
                table.add_row(item.id, item.state, system, *means)
    return table


def report(study: Study, scores: Scores) -> str:
    """Return the report: one HTML page without script, pictures or network."""
    parts = [
        f"<h1>Study {escape(study.id)}</h1>",
        f"<p>{escape(_people(scores))}. Intervals: 95 %, participants and scenes drawn again"
        f' together. <span class="soft">Key {study.digest}.</span></p>',
        "<h2>By system</h2>",
        *_system_rows(study, scores),
        "<h2>What the replies came to</h2>",
        *_reply_rows(study, scores),
        "<h2>Agreement (Krippendorff's alpha; 1 full, 0 chance)</h2>",
        *_agreement_rows(scores),
        "<h2>By scene</h2>",
        *_scene_rows(study, scores),
    ]
    if scores.problems:
        lines = "".join(f"<li>{escape(one)}</li>" for one in scores.problems)
        parts += ["<h2>Files that do not count</h2>", f"<ul>{lines}</ul>"]
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>Study {escape(study.id)}</title><style>{STYLE}</style></head>"
        f"<body>{''.join(parts)}</body></html>\n"
    )


def _people(scores: Scores) -> str:
    failed, bad = len(scores.failed), len(scores.problems)
    return (
        f"{len(scores.participants)} participants; {failed} failed an attention check and"
        f" {bad} files do not fit, neither counted"
    )


def _system_rows(study: Study, scores: Scores) -> Iterator[str]:
    yield '<div class="wide"><table><tr><th>system<th>scale<th>n<th>mean<th>95 %<th>median<th></tr>'
    for system in study.systems:
        for what, score in scores.by_system[system].items():
            numbers = "".join(f'<td class="number">{one}</td>' for one in _cells(score, what))
            yield (
                f"<tr><td>{escape(system)}</td><td>{TITLES[what]}</td>{numbers}"
                f"<td>{_plot(score, what)}</td></tr>"
            )
    for system, by_scale in scores.differences.items():
        for what, score in by_scale.items():
            name = f"{study.systems[0]} minus {system}"
            numbers = "".join(f'<td class="number">{one}</td>' for one in _cells(score, ""))
            yield f"<tr><td>{escape(name)}</td><td>{TITLES[what]}</td>{numbers}<td></td></tr>"
    yield "</table></div>"


def _plot(score: Score, what: str) -> str:
    """Return mean and interval on the scale, as SVG."""
    if not score.count:
        return ""
    first, last = (0.0, 1.0) if what == REPLY else (float(LIKERT[0]), float(LIKERT[-1]))
    width, height = PLOT_PX

    def at(value: float) -> float:
        return 10 + (value - first) / (last - first) * (width - 20)

    middle = height / 2
    ticks = "".join(
        f'<line class="axis" x1="{at(one):.1f}" x2="{at(one):.1f}" y1="6" y2="{height - 6}"/>'
        for one in np.linspace(first, last, 5)
    )
    return (
        f'<svg width="{width}" height="{height}" role="img" aria-label="mean {score.mean:.2f} on a'
        f' scale from {first:g} to {last:g}">{ticks}<line class="range" stroke-width="4"'
        f' x1="{at(score.low):.1f}" x2="{at(score.high):.1f}" y1="{middle}" y2="{middle}"/>'
        f'<circle cx="{at(score.mean):.1f}" cy="{middle}" r="5"/></svg>'
    )


def _reply_rows(study: Study, scores: Scores) -> Iterator[str]:
    head = "".join(f"<th>{OUTCOME_WORDS[one]}" for one in OUTCOMES)
    yield f'<div class="wide"><table><tr><th>system{head}</tr>'
    for system in study.systems:
        cells = "".join(
            f'<td class="number">{scores.replies[system][outcome]}</td>' for outcome in OUTCOMES
        )
        yield f"<tr><td>{escape(system)}</td>{cells}</tr>"
    yield "</table></div>"


def _agreement_rows(scores: Scores) -> Iterator[str]:
    yield "<table><tr><th>scale<th>ordinal<th>interval</tr>"
    for scale, levels in scores.agreement.items():
        cells = "".join(f'<td class="number">{_number(one)}</td>' for one in levels.values())
        yield f"<tr><td>{scale}</td>{cells}</tr>"
    yield "</table>"


def _scene_rows(study: Study, scores: Scores) -> Iterator[str]:
    scales = "".join(f"<th>{TITLES[what]}" for what in (*SCALES, REPLY))
    yield f'<div class="wide"><table><tr><th>scene<th>what was said<th>by{scales}</tr>'
    for item in study.items:
        for unit in item.units:
            by_scale = scores.by_item[next(iter(unit.asked))][item.id]
            cells = "".join(
                f'<td class="number">{_mean(by_scale[what])}</td>' for what in (*SCALES, REPLY)
            )
            yield (
                f'<tr><td>{item.id}</td><td class="said"><span class="soft">'
                f"{escape(item.instruction)}</span><br>{escape(unit.text)}</td>"
                f"<td>{escape(', '.join(unit.asked))}</td>{cells}</tr>"
            )
    yield "</table></div>"


def _cells(score: Score, what: str) -> list[str]:
    median = "" if what == REPLY or not score.count else f"{score.median:g}"
    between = f"{score.low:.2f} to {score.high:.2f}" if score.count else ""
    return [str(score.count), _mean(score), between, median]


def _mean(score: Score) -> str:
    return f"{score.mean:.2f}" if score.count else "-"


def _number(value: float | None) -> str:
    return "not defined" if value is None else f"{value:.2f}"
