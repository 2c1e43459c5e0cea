"""Things of the map that are worth another look, and what a look at each is worth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from doro_mapper.finder import attributes_agree, names_agree
from doro_mapper.planner.settings import PlannerSettings
from doro_mapper.planner.space import noticed
from doro_mapper.views import Camera, Floats
from doro_schemas.graph import ObjectGraph
from doro_schemas.vocabulary import name_satisfies

MOST_THINGS = 96
MOST_PAIRS = 128
MOST_FROM = 8
AFTER = (1.0, 1.0, 0.4, 0.15)
"""What is left of the worth of a further look after 0, 1, 2, 3 hits; then nothing."""
TWIN_REACH_M = 0.6
"""Beyond it, two alike are hardly taken for one: worth falls by 1/e per so much gap."""
UNCLEAR_M = 0.10
"""A centre that is uncertain by so much is worth a look from another side."""
SIGHT_STEPS = 16
UNKNOWN_ATTRIBUTE = 0.4
LEAST_WORTH = 1e-3


@dataclass(frozen=True, slots=True)
class Thing:
    """An instance or track as the planner sees it; map axes, metres.

    Attributes:
        hits: frames that saw it.
        spread_m: standard error of its centre.
        seen_in: serials of those frames.
        from_m: (n, 3) camera positions of its latest sightings.
    """

    name: str
    attributes: dict[str, str]
    related: bool
    center_m: Floats
    size_m: Floats
    hits: int
    spread_m: float
    seen_in: frozenset[int]
    from_m: Floats


@dataclass(frozen=True, slots=True)
class Worth:
    """What looking at things is worth; arrays over m things and p pairs.

    Attributes:
        center_m, radius_m, width_m: (m, 3), (m,), (m,) where and how large; the last is what
            must be large enough in the image.
        tentative, unclear: (m,) worth of seeing it once more, of seeing it from a new side.
        from_m: (m, MOST_FROM, 3) where it was seen from, padded by repeats.
        pairs, twins: (p, 2) things and (p,) worth of seeing both in one view.
        names: classes, for people.
    """

    center_m: Floats
    radius_m: Floats
    width_m: Floats
    tentative: Floats
    unclear: Floats
    from_m: Floats
    pairs: NDArray[np.int64]
    twins: Floats
    names: list[str]

    def __len__(self) -> int:
        return len(self.names)


def worth_of(
    things: Sequence[Thing], asked: ObjectGraph | None, settings: PlannerSettings
) -> Worth:
    """Return what another look at each thing, and at each pair of twins, is worth."""
    tentative = np.array([_tentative(thing, asked, settings) for thing in things])
    unclear = np.array([_unclear(thing, asked, settings) for thing in things])
    pairs, twins = _twins(things, asked, settings)
    single = tentative + unclear
    if len(pairs):
        np.maximum.at(single, pairs.ravel(), LEAST_WORTH * 2)
    kept = np.argsort(-single, kind="stable")[:MOST_THINGS]
    kept = np.sort(kept[single[kept] > LEAST_WORTH])
    place = np.full(len(things), -1)
    place[kept] = np.arange(len(kept))
    pairs = place[pairs] if len(pairs) else np.zeros((0, 2), np.int64)
    whole = (pairs >= 0).all(axis=1)
    chosen = [things[int(i)] for i in kept]
    n = len(chosen)
    return Worth(
        center_m=np.array([thing.center_m for thing in chosen]).reshape(n, 3),
        radius_m=np.array([np.linalg.norm(thing.size_m) / 2 for thing in chosen]),
        width_m=np.array([_width(thing.size_m) for thing in chosen]),
        tentative=tentative[kept],
        unclear=unclear[kept],
        from_m=np.array([_padded(thing) for thing in chosen]).reshape(n, MOST_FROM, 3),
        pairs=pairs[whole],
        twins=twins[whole],
        names=[thing.name for thing in chosen],
    )


def _width(size_m: Floats) -> float:
    """Return the side of a square as large as the middle one of a box's three faces."""
    ordered = np.sort(np.maximum(size_m, 0.03))
    return float(np.sqrt(ordered[0] * ordered[2]))


def _padded(thing: Thing) -> Floats:
    """Return MOST_FROM places; where none is known, one above, which makes every side new."""
    latest = thing.from_m[-MOST_FROM:] if len(thing.from_m) else thing.center_m[None] + (0, 0, 9)
    return np.asarray(latest[np.minimum(np.arange(MOST_FROM), len(latest) - 1)])


@lru_cache(maxsize=4096)
def _alike(a: str, b: str) -> bool:
    return names_agree(a, b)


def _is_asked(name: str, asked: ObjectGraph | None) -> bool:
    return asked is not None and name_satisfies(asked.name, name)


def _tentative(thing: Thing, asked: ObjectGraph | None, settings: PlannerSettings) -> float:
    left = AFTER[thing.hits] if thing.hits < len(AFTER) else 0.0
    return settings.tentative * left * (settings.asked if _is_asked(thing.name, asked) else 1.0)


def _unclear(thing: Thing, asked: ObjectGraph | None, settings: PlannerSettings) -> float:
    worth = settings.unclear * min(1.0, (thing.spread_m / UNCLEAR_M) ** 2)
    if asked is not None and _is_asked(thing.name, asked):
        unknown = sum(kind not in thing.attributes for kind in asked.attributes)
        unknown += bool(asked.relations) and not thing.related
        worth = settings.asked * (worth + UNKNOWN_ATTRIBUTE * unknown)
    return worth


def _twins(
    things: Sequence[Thing], asked: ObjectGraph | None, settings: PlannerSettings
) -> tuple[NDArray[np.int64], Floats]:
    """Return pairs that may be one thing and were never seen together, most worth first."""
    n = len(things)
    if n < 2:
        return np.zeros((0, 2), np.int64), np.zeros(0)
    center = np.array([thing.center_m for thing in things])
    half = np.array([np.linalg.norm(thing.size_m) / 2 for thing in things])
    gap = np.linalg.norm(center[:, None] - center[None], axis=2) - half[:, None] - half[None]
    found: list[tuple[float, int, int]] = []
    for i, j in zip(*np.nonzero(np.triu(gap < 3 * TWIN_REACH_M, 1)), strict=True):
        a, b = things[i], things[j]
        if not _alike(a.name, b.name) or not a.seen_in.isdisjoint(b.seen_in):
            continue
        if not attributes_agree(a.attributes, b.attributes):
            continue
        worth = settings.twins * float(np.exp(-max(0.0, gap[i, j]) / TWIN_REACH_M))
        worth *= settings.asked if _is_asked(a.name, asked) else 1.0
        found.append((-worth, int(i), int(j)))
    found = sorted(found)[:MOST_PAIRS]
    pairs = np.array([(i, j) for _, i, j in found], np.int64).reshape(-1, 2)
    return pairs, np.array([-worth for worth, _, _ in found])


def shown(
    worth: Worth, position_m: Floats, rotation: Floats, camera: Camera, settings: PlannerSettings
) -> Floats:
    """Return the chance (n, m) that views show and find things, if nothing is in the way."""
    offset = worth.center_m[None] - position_m[:, None]
    local = offset @ rotation.transpose(0, 2, 1)
    z = np.maximum(local[..., 2], 1e-3)
    lens, (width, height) = camera.intrinsics, camera.size_px
    u = local[..., 0] / z * lens.fx + lens.cx
    v = local[..., 1] / z * lens.fy + lens.cy
    side_px = worth.width_m * lens.fy / z
    # Not only the centre: a thing cut off at the border is measured badly.
    edge = np.minimum(0.5 * side_px, 0.25 * min(width, height))
    inside = (u > edge) & (u < width - edge) & (v > edge) & (v < height - edge)
    inside &= (local[..., 2] > worth.radius_m) & (z < settings.sight_m)
    chance = noticed(1.0, z / worth.width_m, lens.fy, settings.least_px)
    return np.where(inside, chance, 0.0)


def novelty(worth: Worth, position_m: Floats) -> Floats:
    """Return how new (n, m) each view's side of each thing is: 0 seen so, 1 from 60 degrees on."""

    def unit(offset: Floats) -> Floats:
        length = np.linalg.norm(offset, axis=-1, keepdims=True)
        return np.asarray(offset / np.maximum(length, 1e-6))

    new = unit(worth.center_m[None] - position_m[:, None])
    old = unit(worth.center_m[:, None] - worth.from_m)
    # (m, n, 3) @ (m, 3, f)
    cosine = (new.transpose(1, 0, 2) @ old.transpose(0, 2, 1)).max(axis=2, initial=-1.0).T
    return np.asarray(np.clip(2.0 * (1.0 - cosine), 0.0, 1.0))
