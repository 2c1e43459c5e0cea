"""Failures with pictures: what was true, what was counted or said, and why."""

from __future__ import annotations

import base64
import io
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import msgspec
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure as Plot
from matplotlib.patches import Rectangle

from doro_evaluation.chain import Room, load_room
from doro_evaluation.context import Recorded
from doro_evaluation.counting.metrics import Item, items
from doro_evaluation.counting.reasons import reasons_of
from doro_evaluation.outcomes import CLASS_OF_NAME, Outcome, Thing
from doro_evaluation.queries.systems import QueryOutcome
from doro_evaluation.study.views import Photographer, shot, views_for
from doro_schemas.errors import Refused

COUNTED, ASKED = 12, 8
MOST_VIEWS = 2
LEAST_SPAN_M = 2.0
LETTERS = "ABCDEFGHIJKLMNOPQRSTUVWXYZ"


class Failure(msgspec.Struct, frozen=True):
    """A wrong item or pair.

    Attributes:
        recording: where; object_type: the class; title: one line; lines: what happened.
        cause: by which failures are spread; wanted: object ids that were missed.
        outcome: the counting behind it.
    """

    recording: str
    object_type: str
    title: str
    lines: tuple[str, ...]
    cause: str
    outcome: Outcome


class Shown(msgspec.Struct, frozen=True):
    """A failure with its pictures as data URIs: from above first, then views."""

    failure: Failure
    pictures: tuple[str, ...]
    note: str = ""


def counting_failures(outcomes: Sequence[Outcome]) -> list[Failure]:
    """Return the wrong items of a system under an error model."""
    found = []
    for outcome in outcomes:
        for item in items(outcome):
            if item.true == item.found:
                continue
            causes = reasons_of(outcome, item.object_type)
            title = (
                f"{outcome.recording}, {item.object_type}: {item.true} true, {item.found} found"
                f" ({outcome.errors})"
            )
            told = (*(f"{one}." for one in dict.fromkeys(causes)), _views_of(outcome, item))
            found.append(
                Failure(outcome.recording, item.object_type, title, told, causes[0], outcome)
            )
    return found


def _views_of(outcome: Outcome, item: Item) -> str:
    """Return in words how many views show each true instance, by its letter."""
    true = [one for one in outcome.truth if one.object_type == item.object_type]
    told = [f"{letter} {one.views}" for letter, one in zip(LETTERS, true, strict=False)]
    return f"Views that show each, of {outcome.frames}: {', '.join(told)}." if told else ""


def query_failures(asked: Sequence[QueryOutcome], outcomes: Mapping[str, Outcome]) -> list[Failure]:
    """Return the wrong pairs on all views.

    Args:
        outcomes: the counting behind them, by recording.
    """
    found = []
    for one in sorted(asked, key=lambda one: one.pair.id):
        verdict, pair = one.verdict, one.pair
        if one.view != "multi-view" or verdict.right or pair.episode not in outcomes:
            continue
        lines = (
            f"Said: {verdict.text}",
            f"True: {verdict.references[0] if verdict.references else verdict.true}",
            f"Wrong by {verdict.fault}: {verdict.why}.",
        )
        object_type = CLASS_OF_NAME.get(pair.graph.name, "")
        title = f"{pair.episode}: “{pair.instruction}”"
        found.append(
            Failure(pair.episode, object_type, title, lines, verdict.fault, outcomes[pair.episode])
        )
    return found


def spread_over_causes(failures: Sequence[Failure], most: int) -> list[Failure]:
    """Return at most so many, causes in turns, a recording once as long as there are others."""
    by_cause: dict[str, list[Failure]] = defaultdict(list)
    for one in failures:
        by_cause[one.cause].append(one)
    chosen: list[Failure] = []
    while len(chosen) < most and any(by_cause.values()):
        for own in by_cause.values():
            taken = {one.recording for one in chosen}
            if own and len(chosen) < most:
                fresh = next((k for k, one in enumerate(own) if one.recording not in taken), 0)
                chosen.append(own.pop(fresh))
    return chosen


def pictured(failures: Sequence[Failure], recordings: Mapping[str, Recorded]) -> Iterator[Shown]:
    """Yield failures with a picture from above and up to two views, as they are made."""
    for one in failures:
        above = from_above(one)
        recorded = recordings.get(one.recording)
        if recorded is None:
            yield Shown(one, (above,), "its recording is not there")
            continue
        try:
            views = _views(one, Path(recorded.path))
        except (Refused, ImportError) as error:
            yield Shown(one, (above,), f"no views: {error}")
        else:
            yield Shown(one, (above, *views))


def _views(failure: Failure, path: Path) -> tuple[str, ...]:
    """Return views that show the true things of the class, with letters."""
    room: Room = load_room(path)
    true = [one for one in failure.outcome.truth if one.object_type == failure.object_type]
    letters = dict(zip(LETTERS, (one.name for one in true), strict=False))
    chosen = views_for(room.detections, {one.name: () for one in true})[:MOST_VIEWS]
    images = Photographer(path, room).images(chosen)
    return tuple(
        shot(image, room.detections[view], letters, []).source
        for view, image in zip(chosen, images, strict=True)
    )


def from_above(failure: Failure) -> str:
    """Return the class' true boxes (filled, with letter and number of views) and found ones."""
    plot = Plot(figsize=(3.2, 3.2), layout="constrained")
    axis: Axes = plot.subplots()
    draw_above(axis, failure)
    FigureCanvasAgg(plot)
    file = io.BytesIO()
    plot.savefig(file, dpi=90, format="png", metadata={"Software": None})
    return f"data:image/png;base64,{base64.b64encode(file.getvalue()).decode()}"


def draw_above(axis: Axes, failure: Failure) -> None:
    """Draw a failure from above into an axis."""
    kind, outcome = failure.object_type, failure.outcome
    true = [one for one in outcome.truth if one.object_type == kind]
    for letter, one in zip(LETTERS, true, strict=False):
        axis.add_patch(_footprint(one, {"facecolor": "#9ecae1", "edgecolor": "none"}))
        x, z = one.center_m[0], one.center_m[2]
        at = (4, 4 - 9 * (ord(letter) % 2))
        axis.annotate(letter, (x, z), fontsize=8, xytext=at, textcoords="offset points")
    for one in outcome.found:
        if one.object_type == kind:
            style = {"fill": False, "edgecolor": "#cb181d", "linewidth": 1.5}
            axis.add_patch(_footprint(one, style))
    axis.margins(0.15)
    axis.autoscale_view()
    for low, high, limit in ((*axis.get_xlim(), axis.set_xlim), (*axis.get_ylim(), axis.set_ylim)):
        more = max(0.0, LEAST_SPAN_M - (high - low)) / 2
        limit(low - more, high + more)
    axis.set_aspect("equal", adjustable="box")
    axis.tick_params(labelsize=6)
    axis.set_xlabel("x, m", fontsize=7)
    axis.set_ylabel("z, m", fontsize=7)


def _footprint(thing: Thing, style: Mapping[str, object]) -> Rectangle:
    (x, _, z), (width, _, depth) = thing.center_m, thing.size_m
    return Rectangle((x - width / 2, z - depth / 2), width, depth, **style)  # type: ignore[arg-type]
