"""Things side by side in one view: left, middle and right as the robot saw them.

Left and right mean something only from somewhere. That is one frame in which all of the
things are seen; the question names sides only with it (``Query.seen_from``).
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import pairwise

import msgspec

from doro_dialogue.facts import Candidate
from doro_schemas.messages.map import Evidence
from doro_schemas.messages.talk import SeenFrom

SIDES = {
    2: ("on the left", "on the right"),
    3: ("on the left", "in the middle", "on the right"),
}
FROM_LEFT = ("first", "second", "third", "fourth", "fifth", "sixth")
MAX_ROW = len(FROM_LEFT)
IN_ROW = re.compile(r", (on the (?:left|right)|in the middle|the \w+ from the left)$")
"""How the clause of something in a row ends."""

MAX_OVERLAP = 0.25
"""Share of the narrower box by which two neighbors may overlap and still be side by side."""


class Row(msgspec.Struct, frozen=True):
    """Instances from left to right in one view.

    Attributes:
        ids: from left to right.
        sides: what each is called ("on the left").
        words: all of it in a sentence ("one on the left and one on the right as I saw them").
        seen_from: the view.
    """

    ids: list[str]
    sides: list[str]
    words: str
    seen_from: SeenFrom


def row_of(members: Sequence[Candidate]) -> Row | None:
    """Return the row that the strongest common view shows; None where none shows one."""
    if not 2 <= len(members) <= MAX_ROW:
        return None
    for first in members[0].views:
        views = [_view_in(one, first) for one in members]
        boxes = {
            one.id: view.box_px
            for one, view in zip(members, views, strict=True)
            if view is not None
        }
        if len(boxes) < len(members):
            continue
        ids = sorted(boxes, key=lambda name: (_center(boxes[name]), name))
        if all(_beside(boxes[a], boxes[b]) for a, b in pairwise(ids)):
            return _row(ids, SeenFrom(first.camera, first.frame))
    return None


def _row(ids: list[str], seen_from: SeenFrom) -> Row:
    count = len(ids)
    if count in SIDES:
        sides = list(SIDES[count])
        each = [f"one {side}" for side in sides]
        words = f"{', '.join(each[:-1])} and {each[-1]} as I saw them"
        return Row(ids, sides, words, seen_from)
    sides = [f"the {number} from the left" for number in FROM_LEFT[:count]]
    return Row(ids, sides, "side by side, counted from the left as I saw them", seen_from)


def _view_in(one: Candidate, view: Evidence) -> Evidence | None:
    """Return the view of a candidate in the same frame; a box seen twice is no view of two."""
    same = [own for own in one.views if (own.camera, own.frame) == (view.camera, view.frame)]
    return same[0] if same else None


def _center(box_px: list[float]) -> float:
    return (box_px[0] + box_px[2]) / 2


def _beside(left: list[float], right: list[float]) -> bool:
    """Tell whether two boxes stand side by side, not behind or above each other."""
    narrower = min(left[2] - left[0], right[2] - right[0])
    across_px = _center(right) - _center(left)
    up_px = abs(right[1] + right[3] - left[1] - left[3]) / 2
    return left[2] - right[0] <= MAX_OVERLAP * narrower and up_px <= across_px
