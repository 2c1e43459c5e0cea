"""Algorithm 1 as the paper prints it, with what is odd about it."""

from __future__ import annotations

import numpy as np
from mapper_scene import Thing, messages, room, shoot, table, walk

from doro_mapper.core import Mapper
from doro_mapper.literal import algorithm_1
from doro_mapper.settings import MapperSettings
from doro_schemas.messages import GridRequest, InstancesRequest


def test_noise_is_suppressed_and_a_lone_peak_stays() -> None:
    scores = np.array([[0.9, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.1]])
    assert algorithm_1(scores, 0.2).tolist() == [[0.9, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0]]


def test_the_next_best_is_looked_up_by_the_regions_number() -> None:
    """Regions by score: 2, 1, 0. The seed 2 looks up RI[3]: there is none; 1 looks up RI[2] = 0."""
    scores = np.array([[0.2, 0.3, 0.5]])
    assert algorithm_1(scores, 0.01).tolist() == [[0.3, 0.3, 0.5]]
    # By rank, as it was meant: 2 takes 1, and 0 joins what was merged.
    assert algorithm_1(scores, 0.01, by_rank=True).tolist() == [[0.5, 0.5, 0.5]]


def test_equal_scores_are_one_instance_and_more_instances_are_noise() -> None:
    scores = np.zeros((1, 9))
    scores[0, [0, 4, 8]] = 1 / 3
    assert len(set(algorithm_1(scores, 0.1).ravel().tolist()) - {0.0}) == 1
    many = np.full((1, 99), 0.0)
    many[0, ::3] = 1 / 33
    assert (algorithm_1(many, 0.05) == 0).all()  # gamma eats them all


def test_it_runs_behind_the_same_interface() -> None:
    things = [*room(), table((0, 0)), Thing("mug", (0.4, 0.8, 0.1), (0.09, 0.1, 0.09))]
    mapper = Mapper(MapperSettings(finder="paper_literal"))
    for depth, graphs in messages(shoot(things, walk(12, radius_m=1.5))):
        mapper.depth_frame(depth)
        mapper.frame_graphs(graphs)
    found = mapper.instances(InstancesRequest(name="mug")).instances
    assert found
    assert [i.instance_id for i in found] == [f"mug-{k + 1}" for k in range(len(found))]
    gaps = [np.linalg.norm(np.subtract(i.position_m, (0.4, 0.8, 0.1))) for i in found]
    assert min(gaps) < 0.3


def test_region_scores_of_the_snapshot_are_the_papers() -> None:
    things = [*room(), table((0, 0)), Thing("mug", (0.4, 0.8, 0.1), (0.09, 0.1, 0.09))]
    mapper = Mapper(MapperSettings())
    for depth, graphs in messages(shoot(things, walk(6, radius_m=1.5))):
        mapper.depth_frame(depth)
        mapper.frame_graphs(graphs)
    grid = mapper.grid(GridRequest())
    assert (grid.region_m, len(grid.regions)) == (0.5, len(grid.region_scores))
    for entry in grid.graphs:
        own = grid.regions[:, 0] == entry.graph_id
        assert abs(float(grid.region_scores[own].sum()) - 1) < 1e-5
        cells = grid.cells[grid.cells[:, 0] == entry.graph_id]
        assert {(int(a) // 10, int(b) // 10) for a, b in cells[:, 1:3]} == {
            (int(a), int(b)) for a, b in grid.regions[own, 1:]
        }
