"""The report: one HTML file that needs nothing else, and the same as Markdown."""

from __future__ import annotations

import base64
import html
from collections.abc import Iterable, Mapping, Sequence

from doro_evaluation.report.gallery import Shown
from doro_evaluation.report.grids import Grid

Plots = Mapping[str, tuple[str, bytes]]
STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; color: #1b1b1b; max-width: 74rem; margin: 2rem auto;
       padding: 0 1rem; }
h1 { font-size: 1.6rem; } h2 { margin-top: 2.4rem; border-bottom: 1px solid #ccc; }
h3 { margin-bottom: .4rem; }
table { border-collapse: collapse; font-size: .85rem; }
th, td { border: 1px solid #d5d5d5; padding: .25rem .5rem; text-align: left; vertical-align: top; }
thead th { background: #f0f3f7; }
tr.paper td { color: #5b5b5b; background: #fafafa; } tr.wanted td { color: #2b6b2b; }
.wide { overflow-x: auto; } .note { color: #555; font-size: .85rem; max-width: 60rem; }
img { max-width: 100%; } figure { margin: 1rem 0; } figcaption { color: #555; font-size: .85rem; }
.failure { border: 1px solid #d5d5d5; border-radius: 6px; padding: .6rem .9rem; margin: 1rem 0; }
.failure h4 { margin: 0 0 .3rem; } .failure p { margin: .15rem 0; }
.pictures { display: flex; flex-wrap: wrap; gap: .6rem; margin-top: .5rem; }
.pictures img { height: 270px; }
"""
LEGEND = (
    "From above: true instances are filled, with a letter; found ones are outlined in red. In the"
    " views the letters stand on the same instances."
)


def html_page(
    grids: Sequence[Grid],
    plots: Plots,
    failures: Mapping[str, Sequence[Shown]],
    words: Iterable[str],
) -> str:
    """Return the report as one HTML file.

    Args:
        words: paragraphs of the introduction; grids: the headline first.
        failures: by heading, with pictures as data URIs.
    """
    headline, *rest = grids
    parts = ["<h1>DoRO: the paper's evaluation</h1>"]
    parts += [f"<p>{html.escape(text)}</p>" for text in words]
    parts += [headline.page(), "<h2>Plots</h2>"]
    for caption, png in plots.values():
        source = f"data:image/png;base64,{base64.b64encode(png).decode()}"
        text = html.escape(caption)
        parts.append(f'<figure><img src="{source}" alt="{text}">'
                     f"<figcaption>{text}</figcaption></figure>")  # fmt: skip
    parts += ["<h2>Tables</h2>", *(grid.page() for grid in rest)]
    if any(failures.values()):
        parts += ["<h2>Failures</h2>", f"<p>{LEGEND}</p>"]
    for heading, shown in failures.items():
        if shown:
            parts.append(f"<h3>{html.escape(heading)}</h3>")
            parts += [_failure(one) for one in shown]
    body = "\n".join(parts)
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>DoRO: the paper's evaluation</title><style>{STYLE}</style></head>"
        f"<body>\n{body}\n</body></html>\n"
    )


def markdown_page(grids: Sequence[Grid], plots: Plots, words: Iterable[str]) -> str:
    """Return the report as Markdown; plots are files beside it."""
    parts = ["# DoRO: the paper's evaluation", *words]
    headline, *rest = grids
    parts += [headline.markdown(), "## Plots"]
    parts += [f"![{caption}]({name})" for name, (caption, _) in plots.items()]
    parts += ["## Tables", *(grid.markdown() for grid in rest)]
    return "\n\n".join(part.rstrip() for part in parts) + "\n"


def _failure(one: Shown) -> str:
    lines = "".join(f"<p>{html.escape(line)}</p>" for line in one.failure.lines)
    note = f"<p class=note>{html.escape(one.note)}</p>" if one.note else ""
    alt = html.escape(one.failure.title)
    pictures = "".join(f'<img src="{source}" alt="{alt}">' for source in one.pictures)
    return (
        f"<div class=failure><h4>{html.escape(one.failure.title)}</h4>{lines}{note}"
        f"<div class=pictures>{pictures}</div></div>"
    )
