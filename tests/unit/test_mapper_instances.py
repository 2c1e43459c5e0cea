"""Instance messages: ids, queries, relations, evidence."""

from __future__ import annotations

import numpy as np
import pytest
from mapper_scene import Frame, Thing, messages, room, shoot, table, walk

from doro_mapper.core import Mapper
from doro_mapper.finder import Found
from doro_mapper.relations import captioned_relations, relations_of, spatial_relations
from doro_mapper.settings import MapperSettings
from doro_mapper.sightings import Sighting
from doro_mapper.votes import Votes, voted_name
from doro_schemas.graph import ObjectGraph, Relation
from doro_schemas.messages import Instance, InstancesRequest

BLUE = {"color": "blue"}


@pytest.fixture(scope="module")
def mapper() -> Mapper:
    things = [
        *room(),
        table((0, 0)),
        Thing("cup", (-0.5, 0.8, -0.2), (0.09, 0.1, 0.09), BLUE),
        Thing("mug", (0.3, 0.8, 0.2), (0.09, 0.1, 0.09), {"color": "grey"}),
        Thing("desk lamp", (0.55, 0.95, 0.2), (0.2, 0.4, 0.2), {"color": "white"}),
        Thing("coffee table", (1.8, 0.2, 0.0), (0.6, 0.4, 0.9)),
        Thing("Books", (1.8, 0.45, 0.2), (0.2, 0.1, 0.25), {"color": "green"}),
    ]
    core = Mapper(MapperSettings())
    for depth, graphs in messages(shoot(things, walk(30, radius_m=1.4))):
        core.depth_frame(depth)
        core.frame_graphs(graphs)
    return core


def ask(mapper: Mapper, name: str) -> list[Instance]:
    return mapper.instances(InstancesRequest(name=name)).instances


@pytest.mark.parametrize(
    ("name", "ids"),
    [
        ("cup", ["cup-1"]),
        ("mug", ["mug-1"]),
        ("lamp", ["desk-lamp-1"]),
        ("table", ["coffee-table-1", "dining-table-1"]),
        ("tables", ["coffee-table-1", "dining-table-1"]),
        ("coffee table", ["coffee-table-1"]),
        ("book", ["book-1"]),
        ("sofa", []),
    ],
)
def test_a_query_finds_the_class_and_its_kinds(mapper: Mapper, name: str, ids: list[str]) -> None:
    assert [instance.instance_id for instance in ask(mapper, name)] == ids


def test_names_and_values_are_canonical(mapper: Mapper) -> None:
    assert ask(mapper, "mug")[0].graph.attributes == {"color": "gray"}
    assert ask(mapper, "book")[0].graph.name == "book"


def test_all_instances_are_listed_for_no_name(mapper: Mapper) -> None:
    reply = mapper.instances(InstancesRequest())
    assert [i.instance_id for i in reply.instances] == [
        "book-1",
        "coffee-table-1",
        "cup-1",
        "desk-lamp-1",
        "dining-table-1",
        "mug-1",
    ]
    assert (reply.frames_merged, reply.last_frame, len(reply.digest)) == (30, 29, 32)


def test_relations_are_measured_between_instances(mapper: Mapper) -> None:
    def relations(name: str) -> list[tuple[str, str]]:
        return [(r.type, r.target.name) for r in ask(mapper, name)[0].graph.relations]

    assert relations("cup") == [("is-on", "dining table")]
    assert relations("mug") == [("is-on", "dining table"), ("is-near", "desk lamp")]
    assert relations("book")[0] == ("is-on", "coffee table")
    on_table = ask(mapper, "cup")[0].graph.relations[0].target
    assert on_table == ObjectGraph("dining table", {"color": "brown", "material": "wood"})


def test_evidence_is_the_best_views_with_their_captions(mapper: Mapper) -> None:
    (cup,) = ask(mapper, "cup")
    assert len(cup.evidence) == 5
    assert cup.evidence[0].caption == "a cup"
    sizes = [(e.box_px[2] - e.box_px[0]) * (e.box_px[3] - e.box_px[1]) for e in cup.evidence]
    assert min(sizes) > 100
    assert cup.hits >= 20
    assert cup.confidence > 0.999
    assert cup.status == "confirmed"


def test_cells_lie_under_the_instance(mapper: Mapper) -> None:
    (cup,) = ask(mapper, "cup")
    centers = (np.array(cup.cells) + 0.5) * [0.05, 0.05, 0.10]
    assert len(cup.cells) >= 2
    assert np.abs(centers - [-0.5, -0.2, 0.8]).max() < 0.12


def found(name: str, center: tuple[float, float, float], size: tuple[float, float, float]) -> Found:
    middle, half = np.array(center), np.array(size) / 2
    return Found(name, middle, middle - half, middle + half, 0, 0, Votes())


def test_nearest_landmarks_only_and_equal_ones_once() -> None:
    things = [found("cup", (0, 0, 0.8), (0.1, 0.1, 0.1))]
    things += [found("lamp", (0.15 * (1 + i), 0, 0.8), (0.1, 0.1, 0.1)) for i in range(3)]
    things += [found("box", (0, 3, 0.8), (0.1, 0.1, 0.1))]
    graphs = [
        ObjectGraph("cup"),
        ObjectGraph("lamp", BLUE),
        ObjectGraph("lamp", BLUE),
        ObjectGraph("lamp"),
        ObjectGraph("box"),
    ]
    own = spatial_relations(things, graphs, 3)[0]
    assert own == [Relation("is-near", graphs[1]), Relation("is-near", graphs[3])]
    assert spatial_relations(things, graphs, 1)[0] == [Relation("is-near", graphs[1])]
    assert spatial_relations(things, graphs, 3)[4] == []


def told(thing: Found, *graphs: ObjectGraph) -> Found:
    """Return the thing with one view by graph."""
    for serial, graph in enumerate(graphs):
        thing.votes.add(Sighting(serial, "cam0", serial, (0, 0, 9, 9), 1.0, "", graph))
    thing.hits = len(graphs)
    return thing


def test_captioned_relations_need_a_good_share_of_the_views() -> None:
    window = ObjectGraph("window", {"color": "white"})
    near = ObjectGraph("cup", {}, [Relation("is-near", window)])
    plain = ObjectGraph("cup")

    def voted(*graphs: ObjectGraph) -> list[Relation]:
        return captioned_relations(told(found("cup", (0, 0, 0), (1, 1, 1)), *graphs), 0.3)

    assert voted(near) == [Relation("is-near", window)]
    assert voted(near, plain, plain) == []
    assert voted(near, near, plain, plain, plain) == [Relation("is-near", window)]
    assert voted(*[near] * 2, *[plain] * 8) == []


def test_captions_win_over_boxes_about_holders_and_the_same_landmark() -> None:
    def relations(*stated: Relation) -> list[Relation]:
        graph = ObjectGraph("cup", {}, list(stated))
        cup = told(found("cup", (0, 0, 0.8), (0.1, 0.1, 0.1)), graph, graph, graph)
        desk = found("desk", (0, 0, 0.375), (1.0, 1.0, 0.75))
        lamp = found("lamp", (0.3, 0, 0.95), (0.2, 0.2, 0.4))
        graphs = [ObjectGraph("cup"), ObjectGraph("desk", BLUE), ObjectGraph("lamp")]
        return relations_of([cup, desk, lamp], graphs, MapperSettings())[0]

    desk, lamp = ObjectGraph("desk", BLUE), ObjectGraph("lamp")
    measured = [Relation("is-on", desk), Relation("is-near", lamp)]
    assert relations() == measured
    assert relations(Relation("is-on", ObjectGraph("desk"))) == measured
    tray = Relation("is-on", ObjectGraph("tray"))
    assert relations(tray) == [tray, measured[1]]
    beside = Relation("is-near", ObjectGraph("desk"))
    assert relations(beside) == [beside, measured[1]]


def test_a_kind_seen_often_enough_names_the_thing() -> None:
    assert voted_name({"lamp": 6.0, "desk lamp": 4.0}) == "desk lamp"
    assert voted_name({"lamp": 9.0, "desk lamp": 1.0}) == "lamp"
    assert voted_name({"cup": 2.0, "mug": 2.0}) == "cup"


def test_a_thing_called_by_class_and_by_kind_is_one() -> None:
    things = [*room(), table((0, 0)), Thing("lamp", (0, 0.95, 0), (0.2, 0.4, 0.2))]
    frames = []
    for number, frame in enumerate(shoot(things, walk(10))):
        seen = [
            type(s)(s.box_px, ObjectGraph("desk lamp" if number % 2 else "lamp"), s.thing)
            if s.graph.name == "lamp"
            else s
            for s in frame.seen
        ]
        frames.append(Frame(frame.pose, frame.depth_m, seen))
    core = Mapper(MapperSettings())
    for depth, graphs in messages(frames):
        core.depth_frame(depth)
        core.frame_graphs(graphs)
    (lamp,) = ask(core, "lamp")
    # The id is the one given at the first view; what the thing is called now is its graph.
    assert (lamp.instance_id, lamp.graph.name) == ("lamp-1", "desk lamp")
    assert [one.name for one in lamp.classes] == ["desk lamp", "lamp"]
