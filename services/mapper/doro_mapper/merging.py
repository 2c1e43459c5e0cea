"""Tracks into instances: merging by mutual explanation, pruning, and existence.

MAPPER study, points 5 to 7. All three work on copies of the online tracks.
"""

from __future__ import annotations

import numpy as np

from doro_mapper.boxes import covered, distance
from doro_mapper.finder import Found, attributes_agree, extent, names_agree
from doro_mapper.settings import MapperSettings
from doro_mapper.track import NEVER, Track, boxes_of, graph_factor
from doro_mapper.views import Bools, Floats, Views

MERGE_GATE = 0.8
MERGE_FAR_GATE = 2.0
TOGETHER_SHARE = 0.1
"""Tracks seen together in more of the smaller one's frames are different things."""
COMMON_VIEWS = 3
EXPLAINED_SHARE = 0.6
PRUNE_SHARE = 0.7
PRUNE_COVER = 0.5
PRUNE_RATIO = 3.0
PRUNE_REACH_M = 0.5
EXPLAIN_COVER = 0.5
EXPLAIN_RATIO = 4.0
MERGE_RANGE_M = 1.5
"""Range assumed for the margin between two tracks."""


def merge(tracks: list[Track], views: Views) -> list[Track]:
    """Merge tracks of one family, closest first, until nothing more may be merged."""
    tracks = sorted(tracks, key=lambda track: -len(track.sightings))
    refused: set[tuple[int, int, int, int]] = set()
    while (pair := _next_pair(tracks, views, refused)) is not None:
        larger, smaller, measured = pair
        larger.join(smaller, measured)
        tracks = [track for track in tracks if track is not smaller]
    return tracks


def _next_pair(
    tracks: list[Track], views: Views, refused: set[tuple[int, int, int, int]]
) -> tuple[Track, Track, bool] | None:
    """Return the closest pair that may be merged, and whether its geometry is shared."""
    n = len(tracks)
    if n < 2:
        return None
    gaps = _gaps(tracks)
    for flat in np.argsort(gaps, axis=None, kind="stable"):
        i, j = divmod(int(flat), n)
        if gaps[i, j] >= NEVER / 2:
            return None
        larger, smaller = tracks[i], tracks[j]
        if len(smaller.sightings) > len(larger.sightings):
            larger, smaller = smaller, larger
        key = (id(larger), len(larger.sightings), id(smaller), len(smaller.sightings))
        if key in refused:
            continue
        decision = _may_merge(larger, smaller, float(gaps[i, j]), views)
        if decision is not None:
            return larger, smaller, decision
        refused.add(key)
    return None


def _gaps(tracks: list[Track]) -> Floats:
    """Return the symmetric distances (n, n), NEVER on and below the diagonal."""
    boxes = boxes_of(tracks)
    gaps = distance(boxes, boxes, np.full(len(tracks), MERGE_RANGE_M))
    factor = [
        [graph_factor(a.name, a.attributes, b.name, b.attributes) for b in tracks] for a in tracks
    ]
    gaps = np.minimum(gaps, gaps.T) * np.array(factor)
    gaps[np.tril_indices(len(tracks))] = NEVER
    return np.asarray(gaps)


def _may_merge(larger: Track, smaller: Track, gap: float, views: Views) -> bool | None:
    """Return None for no; else whether the smaller track's geometry is taken over."""
    seen_large, seen_small = larger.seen(views), smaller.seen(views)
    together = int((seen_large & seen_small).sum())
    if together > TOGETHER_SHARE * min(len(larger.sightings), len(smaller.sightings)):
        return None
    if gap < MERGE_GATE:
        return True
    if not agree(larger, smaller):
        return None
    if gap < MERGE_FAR_GATE:
        common = int((larger.expected(views) & smaller.expected(views)).sum())
        if common >= COMMON_VIEWS and together <= TOGETHER_SHARE * common:
            return True
    if together == 0 and explained(smaller, larger, views).mean() >= EXPLAINED_SHARE:
        return False
    return None


def agree(a: Track, b: Track) -> bool:
    """Tell whether two tracks' graphs may be of one thing."""
    return names_agree(a.name, b.name) and attributes_agree(a.attributes, b.attributes)


def explained(track: Track, by: Track, views: Views) -> Bools:
    """Return which sightings of a track lie where another track projects to."""
    slots = views.slots([sighting.serial for sighting in track.sightings])
    boxes, shows = views.project_box(by.low_m, by.high_m, slots)
    own = np.array([sighting.box_px for sighting in track.sightings])
    cover, ratio = covered(own, boxes)
    return np.asarray(shows & (cover >= EXPLAIN_COVER) & (ratio < EXPLAIN_RATIO))


def prune(tracks: list[Track], views: Views) -> list[Track]:
    """Reduce to the smallest explaining set, weakest first.

    A track of whose sightings most can be read as views of other tracks of its graph that are
    unmatched in those frames goes; they become the others' hits.
    """

    def strength(track: Track) -> float:
        missed = track.expected(views) & ~track.seen(views)
        return len(track.sightings) / (len(track.sightings) + int(missed.sum()) + 2.0)

    kept = list(tracks)
    for track in sorted(tracks, key=strength):
        others = [o for o in kept if o is not track and agree(o, track) and _in_reach(o, track)]
        if not others or len(track.sightings) < 2:
            continue
        readings = _readings(track, others, views)
        if len(readings) >= PRUNE_SHARE * len(track.sightings):
            kept = [other for other in kept if other is not track]
            for index, other in readings:
                other.append(track.sightings[index], track.weights[index], measured=False)
    return kept


def _in_reach(other: Track, track: Track) -> bool:
    reach = PRUNE_REACH_M + 2 * float(np.linalg.norm(other.high_m - other.low_m))
    return float(np.linalg.norm(other.center_m - track.center_m)) <= reach


def _readings(track: Track, others: list[Track], views: Views) -> list[tuple[int, Track]]:
    """Return (sighting, the other track that it may be a view of)."""
    slots = views.slots([sighting.serial for sighting in track.sightings])
    own = np.array([sighting.box_px for sighting in track.sightings])
    best = np.zeros(len(slots))
    by = np.full(len(slots), -1)
    for number, other in enumerate(others):
        boxes, shows = views.project_box(other.low_m, other.high_m, slots)
        cover, ratio = covered(own, boxes)
        fits = shows & ~other.seen(views)[slots] & (cover >= PRUNE_COVER) & (ratio < PRUNE_RATIO)
        better = fits & (cover > best)
        best[better] = cover[better]
        by[better] = number
    return [(int(index), others[by[index]]) for index in np.flatnonzero(by >= 0)]


def exists(track: Track, views: Views, settings: MapperSettings) -> Found | None:
    """Return the instance that a track stands for, or None where too little speaks for it."""
    seen = track.seen(views)
    hits = int(seen.sum())
    misses = int((track.expected(views) & ~seen).sum())
    if not enough(hits, misses, views, settings):
        return None
    order = sorted(range(len(track.sightings)), key=lambda i: track.sightings[i].serial)
    pairs = zip(track.sightings, track.measured, strict=True)
    low, high = extent([sighting.place for sighting, measured in pairs if measured])
    return Found(
        name=track.name,
        center_m=(track.center_m + (low + high) / 2) / 2,
        low_m=low,
        high_m=high,
        sightings=[track.sightings[i] for i in order],
        weights=[track.weights[i] for i in order],
        misses=misses,
        points_m=track.points_m(),
    )


def enough(hits: int, misses: int, views: Views, settings: MapperSettings) -> bool:
    """Tell whether hits against misses make an instance (study, point 7)."""
    if hits < settings.min_hit_share * (hits + misses):
        return False
    alone = hits >= 1 and misses == 0 and views.total < settings.few_views
    return hits >= settings.min_hits or alone
