"""The baseline's rows: which captions each of them reads, judged by which truth."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import pytest

from doro_evaluation.baseline import Baseline
from doro_evaluation.baseline.configurations import aggregated, run
from doro_evaluation.chain import Language, Room
from doro_evaluation.context import Context
from doro_evaluation.maps import MappedRoom
from doro_evaluation.queries.pairs import Pair
from doro_evaluation.runs import prepare
from doro_nlu.core import Nlu
from doro_nlu.settings import NluSettings
from doro_schemas.graph import ObjectGraph, Relation
from doro_schemas.messages import DepthFrame, Instance, SimDetection, SimDetections
from doro_sim_feeder.rooms.truth import TrueInstance

RED, BLUE = "Cup|red", "Cup|blue"


class Listener:
    """Stands for the trained model: notes what it is to read."""

    def __init__(self) -> None:
        self.read: list[list[list[str]]] = []

    def answer(self, captions: list[str], instruction: str) -> str:
        return self.answer_views([captions], instruction)

    def answer_views(self, captions: list[list[str]], instruction: str) -> str:
        self.read.append(captions)
        return "Okay, I will take the red cup."


def _frame(number: int, names: list[str]) -> SimDetections:
    return SimDetections(
        stamp_ns=number,
        episode="e",
        frame=number,
        height_px=300,
        width_px=300,
        detections=[
            SimDetection(
                object_id=name,
                object_type="Cup",
                box_px=[20.0 + 100 * k, 20.0, 80.0 + 100 * k, 80.0],
                attributes={"color": name.split("|")[1]},
            )
            for k, name in enumerate(names)
        ],
    )


def _thing(name: str, at_m: float) -> TrueInstance:
    return TrueInstance(
        number=1,
        object_id=name,
        object_type="Cup",
        attributes={"color": name.split("|")[1]},
        center_m=[at_m, 0.0, 0.0],
        size_m=[0.1, 0.1, 0.1],
        receptacle="",
        relations=[],
        views=1,
    )


@pytest.fixture(scope="module")
def nlu() -> Nlu:
    return Nlu(NluSettings())


def test_rows_read_their_captions(nlu: Nlu) -> None:
    context = Context()
    prepare(context)
    frames = (_frame(0, [RED]), _frame(1, [BLUE]), _frame(2, [RED]))
    depths = cast("tuple[DepthFrame, ...]", ())
    room = Room("r", "FloorPlan301", "e", depths, frames, (_thing(RED, 0.0), _thing(BLUE, 2.0)))
    graphs = Language(nlu=NluSettings()).graphs(room)
    merged = [
        Instance("cup-1", ObjectGraph("cup", {"color": "red"}), [0.0] * 3, [0.1] * 3),
        Instance("cup-2", ObjectGraph("cup", {"color": "blue"}), [2.0, 0, 0], [0.1] * 3),
    ]
    mapped = SimpleNamespace(
        room=room,
        context=context,
        graphs=lambda errors: graphs,
        found=lambda finder, errors: SimpleNamespace(instances=tuple(merged)),
    )
    pair = Pair("p", "r", "name", "true", "bring me a cup", "bring", ObjectGraph("cup"))
    listener = Listener()
    outcomes = run(cast("MappedRoom", mapped), [pair], cast("Baseline", listener), nlu, errors="gt")
    one_view, joined, whole = listener.read
    assert joined == [["a red cup"], ["a blue cup"], ["a red cup"]]
    assert one_view in ([["a red cup"]], [["a blue cup"]])
    assert whole == [["a red cup", "a blue cup"]]
    by_row = {(one.system, one.view): one.verdict for one in outcomes}
    # In one view there is one cup, in the room there are two.
    assert by_row["baseline", "single-view"].true == "CONFIRM"
    assert by_row["baseline", "one-view"].fault == "state"
    assert by_row["baseline_captions", "multi-view"].true == "INFORM-AMBIGUITY"
    assert len(by_row) == len(outcomes) == 5


def test_an_instance_becomes_a_caption() -> None:
    table = ObjectGraph("table", {"material": "wood"})
    graph = ObjectGraph("cup", {"color": "orange"}, [Relation("is-on", table)])
    assert aggregated([graph, table]) == [
        "an orange cup on the wooden table",
        "a wooden table",
    ]
