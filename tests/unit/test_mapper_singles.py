"""What one view alone saw, and how little may speak for a thing."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from mapper_scene import Frame, Seen, Thing, messages, observe, room, shoot, table, walk

from doro_mapper.core import Mapper
from doro_mapper.existence import enough, probability
from doro_mapper.settings import MapperSettings
from doro_mapper.tracks.singles import believed
from doro_schemas.camera import pose_from_ai2thor
from doro_schemas.graph import ObjectGraph
from doro_schemas.messages import InstancesRequest

VASE = Thing("vase", (0.0, 0.1, 2.3), (0.12, 0.2, 0.12), {"color": "blue"})
"""By the wall: seen from nearby, too small from the other side of the room."""
MUG = Thing("mug", (0.0, 0.8, 0.0), (0.09, 0.10, 0.09), {"color": "red"})


@pytest.fixture(scope="module")
def observed() -> list[Frame]:
    things = [*room(), table((0, 0)), MUG, VASE]
    near = observe(things, pose_from_ai2thor((0.0, 1.2, 1.4), 0.0, 30.0))
    frames = [
        replace(frame, seen=[seen for seen in frame.seen if things[seen.thing] is not VASE])
        for frame in shoot(things, walk(23, 1, radius_m=1.5))
    ]
    assert any(things[seen.thing] is VASE for seen in near.seen)
    return [*frames, near]


def counts(frames: list[Frame]) -> Counter[str]:
    mapper = Mapper(MapperSettings(few_views=10))
    for depth, graphs in messages(frames):
        mapper.depth_frame(depth)
        mapper.frame_graphs(graphs)
    return Counter(one.graph.name for one in mapper.instances(InstancesRequest()).instances)


def test_what_one_view_saw_counts_where_the_detector_is_hardly_ever_wrong(
    observed: list[Frame],
) -> None:
    assert counts(observed) == Counter({"dining table": 1, "mug": 1, "vase": 1})


def test_it_does_not_where_views_refute_such_things(observed: list[Frame]) -> None:
    wrong = list(observed)
    for number, name in enumerate(("bowl", "pot", "pan", "apple", "book")):
        false = Seen((110.0, 120.0, 190.0, 190.0), ObjectGraph(name, {}), -1)
        frame = wrong[3 * number]
        wrong[3 * number] = replace(frame, seen=[*frame.seen, false])
    assert counts(wrong) == Counter({"dining table": 1, "mug": 1})


def test_the_refuted_stand_for_those_that_no_view_could_refute() -> None:
    assert believed(0, 1)
    assert not believed(1, 1)
    assert believed(1, 2)
    assert not believed(10, 10)


@pytest.mark.parametrize(
    ("hits", "misses", "counted"), [(2, 0, True), (2, 3, True), (2, 5, False), (9, 30, False)]
)
def test_a_thing_must_be_likely(hits: int, misses: int, counted: bool) -> None:
    assert enough((hits, misses), 100, MapperSettings()) is counted
    assert np.isclose(probability(hits, misses), 1 - 1 / (1 + _odds(hits, misses)))


def _odds(hits: int, misses: int) -> float:
    return float((0.6 / 0.02) ** hits * (0.4 / 0.98) ** misses / 9)


@pytest.mark.parametrize(
    ("longest_m", "doubt", "counted"),
    [(0.3, 2.0, False), (0.9, 2.0, True), (0.9, 8.5, False), (0.9, 0.0, True)],
)
def test_an_erring_detector_may_overlook_furniture_more_often(
    longest_m: float, doubt: float, *, counted: bool
) -> None:
    """Ten views of 25: enough for furniture, not for a cup; not where too few are certain."""
    use = MapperSettings(min_certain=2.0, min_certain_share=0.5, min_certain_share_furniture=0.35)
    assert enough((10, 15), 100, use, doubt, longest_m=longest_m) is counted


@pytest.mark.parametrize(
    ("hits", "misses", "counted"),
    [(20, 28, True), (20, 32, False), (12, 17, False), (12, 11, True)],
)
def test_many_certain_views_may_be_missed_by_more(hits: int, misses: int, *, counted: bool) -> None:
    """A chair behind a table is seen from one side of the room; few views of it are not enough."""
    use = MapperSettings(many_certain=16.0, many_certain_share=0.4)
    assert enough((hits, misses), 100, use, doubt=1.0) is counted
