"""The two hash maps, their deltas and their digest."""

from __future__ import annotations

import numpy as np
import pytest
from mapper_scene import LENS, SIZE_PX, Thing, messages, room, shoot, table, walk

from doro_mapper.core import Mapper
from doro_mapper.maps.hashmaps import HashMaps
from doro_mapper.settings import MapperSettings
from doro_mapper.views import Views, camera_of
from doro_schemas.camera import pose_from_ai2thor
from doro_schemas.graph import ObjectGraph, Relation
from doro_schemas.messages import GridDelta, GridRequest

CUP = ObjectGraph("cup", {"color": "red"})


def view(views: Views, depth_m: float = 4.0, yaw_deg: float = 0.0) -> int:
    pose = pose_from_ai2thor((0.0, 1.0, 0.0), yaw_deg, 0.0)
    depth = np.full((SIZE_PX, SIZE_PX), depth_m, np.float32)
    return views.add(camera_of(LENS, pose, (SIZE_PX, SIZE_PX)), depth)


PLACE = [0.02, 2.02, 1.02]


def merge(maps: HashMaps, views: Views, serial: int, *seen: tuple[int, list[float]]) -> None:
    """Merge detections with samples of given weights, all in the cell at PLACE."""
    weights = np.array([weight for _, own in seen for weight in own])
    owner = np.array([k for k, (_, own) in enumerate(seen) for _ in own], dtype=np.int64)
    points = np.tile(PLACE, (len(weights), 1))
    maps.merge([graph for graph, _ in seen], (points, weights, owner), views, serial)


def test_cell_takes_the_mean_weight_and_counts_frequency_and_views() -> None:
    views, maps = Views(16), HashMaps(0.05, 0.10, 1000)
    cup, _ = maps.graph_id(CUP)
    view(views)  # in view before anything was seen there
    merge(maps, views, 0)
    merge(maps, views, view(views), (cup, [1.0, 0.5]))
    merge(maps, views, view(views, yaw_deg=180.0))  # looks away
    merge(maps, views, view(views, depth_m=1.0))  # occluded
    merge(maps, views, view(views), (cup, [0.25]))
    cells, weights = maps.published()
    assert cells.tolist() == [[cup, 0, 40, 10, 2, 3]]
    assert weights.tolist() == [1.0]


def test_order_of_seeing_and_looking_does_not_matter_for_observability() -> None:
    counts = []
    for hit in (0, 3):
        views, maps = Views(16), HashMaps(0.05, 0.10, 1000)
        cup, _ = maps.graph_id(CUP)
        for step in range(4):
            merge(maps, views, view(views), *([(cup, [1.0])] if step == hit else []))
        counts.append(maps.published()[0][0, 5])
    assert counts == [4, 4]


def test_graphs_are_identified_by_class_and_own_attributes() -> None:
    maps = HashMaps(0.05, 0.10, 1000)
    on_table = ObjectGraph("cup", {"color": "red"}, [Relation("is-on", ObjectGraph("table"))])
    assert maps.graph_id(CUP) == (0, True)
    assert maps.graph_id(on_table) == (0, False)
    assert maps.graph_id(ObjectGraph("cup", {"color": "blue"})) == (1, True)
    assert maps.graph_id(ObjectGraph("mug", {"color": "red"})) == (2, True)
    assert maps.graphs[0].relations == []


def test_different_graphs_share_no_cell() -> None:
    views, maps = Views(16), HashMaps(0.05, 0.10, 1000)
    cup, mug = maps.graph_id(CUP)[0], maps.graph_id(ObjectGraph("mug"))[0]
    merge(maps, views, view(views), (cup, [1.0]), (mug, [0.5]))
    assert maps.published()[0][:, 0].tolist() == [cup, mug]
    places, weights = maps.stacked([cup, mug])
    assert places.tolist() == [[0, 40, 10]]
    assert weights.tolist() == [1.5]


def test_bound_on_cells_is_kept_and_counted() -> None:
    views, maps = Views(4), HashMaps(0.05, 0.10, 2)
    cup, _ = maps.graph_id(CUP)
    points = np.array([[x, 2.0, 1.0] for x in (0.01, 0.06, 0.11, 0.16)])
    owner = np.zeros(4, np.int64)
    maps.merge([cup], (points, np.ones(4), owner), views, view(views))
    assert len(maps) == 2
    assert maps.cells_dropped == 2


def run(mapper: Mapper, count: int = 8) -> list[GridDelta]:
    things = [*room(), table((0, 0)), Thing("mug", (0.2, 0.8, 0.1), (0.09, 0.1, 0.09))]
    out: list[GridDelta] = []
    for depth, graphs in messages(shoot(things, walk(count))):
        for message in [*mapper.depth_frame(depth), *mapper.frame_graphs(graphs)]:
            assert isinstance(message, GridDelta)
            out.append(message)
    return out


def test_deltas_add_up_to_the_snapshot() -> None:
    mapper = Mapper(MapperSettings())
    deltas = run(mapper)
    state: dict[tuple[int, ...], tuple[int, ...]] = {}
    graphs: dict[int, ObjectGraph] = {}
    blocks: dict[tuple[int, ...], int] = {}
    for number, delta in enumerate(deltas):
        assert delta.seq == number
        if delta.reset:
            state, graphs, blocks = {}, {}, {}
        graphs.update((entry.graph_id, entry.graph) for entry in delta.new_graphs)
        for cell, weight in zip(delta.cells.tolist(), delta.weights.tolist(), strict=True):
            state[tuple(cell[:4])] = (cell[4], weight)
        blocks.update({tuple(row[:3]): row[3] for row in delta.blocks.tolist()})
    grid = mapper.grid(GridRequest())
    snapshot = {
        tuple(cell[:4]): (*cell[4:], weight)
        for cell, weight in zip(grid.cells.tolist(), grid.weights.tolist(), strict=True)
    }
    assert len(snapshot) > 100
    # What the wire spec says: observable is the larger of frequency and the block's count.
    read = {
        key: (often, max(often, blocks[key[1] // 5, key[2] // 5, key[3] // 2]), weight)
        for key, (often, weight) in state.items()
    }
    assert read == snapshot
    assert blocks == {tuple(row[:3]): row[3] for row in grid.blocks.tolist()}
    assert graphs == {entry.graph_id: entry.graph for entry in grid.graphs}
    assert (grid.cells[:, 5] >= 1).all()
    assert grid.frames_merged == 8 == len(grid.path_m)


def test_digest_is_equal_for_equal_maps_only() -> None:
    first, second, shorter = (Mapper(MapperSettings()) for _ in range(3))
    run(first), run(second), run(shorter, 7)
    digests = [mapper.grid(GridRequest()).digest for mapper in (first, second, shorter)]
    assert digests[0] == digests[1] != digests[2]
    assert len(digests[0]) == 32


def test_grid_of_a_class_has_its_kinds_only() -> None:
    mapper = Mapper(MapperSettings())
    run(mapper)
    grid = mapper.grid(GridRequest(name="table"))
    assert [entry.graph.name for entry in grid.graphs] == ["dining table"]
    assert set(grid.cells[:, 0].tolist()) == {entry.graph_id for entry in grid.graphs}
    assert mapper.grid(GridRequest(name="cup")).cells.shape == (0, 6)


def test_floor_lies_inside_the_room_and_most_of_it_is_seen() -> None:
    mapper = Mapper(MapperSettings())
    run(mapper, 12)
    grid = mapper.grid(GridRequest())
    assert np.abs((grid.floor + 0.5) * grid.cell_m).max() < 2.6
    assert 0.0 <= mapper._area.coverage.unseen_share() < 0.1


def test_unseen_share_counts_what_nobody_looked_at() -> None:
    mapper = Mapper(MapperSettings())
    assert mapper._area.coverage.unseen_share() == 1.0
    for depth, graphs in messages(shoot(room(), walk(12)[:1])):
        mapper.depth_frame(depth)
        mapper.frame_graphs(graphs)
    assert mapper._area.coverage.unseen_share() > 0.2


@pytest.mark.parametrize("field", ["cell_m", "sigma"])
def test_settings_that_make_no_map_are_refused(field: str) -> None:
    with pytest.raises(ValueError, match="must be > 0"):
        MapperSettings(**{field: 0.0})
