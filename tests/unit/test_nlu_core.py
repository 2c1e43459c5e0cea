"""The core: instructions, frames of captions, the cache; with a scripted tagger."""

from collections.abc import Sequence

import pytest

from doro_nlu.core import Nlu
from doro_nlu.service import wire
from doro_nlu.settings import NluSettings
from doro_nlu.tagger import Tagged
from doro_schemas.errors import Refused
from doro_schemas.graph import ObjectGraph, Relation
from doro_schemas.messages import (
    CaptionedBox,
    ClassProbability,
    FrameCaptions,
    FrameGraphs,
    Instruction,
    InstructionGraph,
    ParseRequest,
)

KINDS = {"cup": "B-object", "red": "B-color", "on": "B-is-on", "table": "B-related"}


class ScriptedTagger:
    """Labels four words; counts its batches."""

    labels = ("O", *KINDS.values())

    def __init__(self) -> None:
        self.batches: list[list[str]] = []

    def tag(self, sentences: Sequence[Sequence[str]]) -> list[Tagged]:
        self.batches.append([" ".join(tokens) for tokens in sentences])
        return [
            Tagged(list(tokens), [KINDS.get(t, "O") for t in tokens], [0.8] * len(tokens))
            for tokens in sentences
        ]

    def knows(self, word: str) -> bool:
        return word in KINDS


@pytest.fixture
def tagger() -> ScriptedTagger:
    return ScriptedTagger()


def captions(*boxes: CaptionedBox) -> FrameCaptions:
    return FrameCaptions(
        stamp_ns=5, episode="e", camera="left", frame=3, height_px=300, width_px=300,
        detections=list(boxes),
    )  # fmt: skip


def box(caption: str = "", graph: ObjectGraph | None = None, score: float = 0.5) -> CaptionedBox:
    classes = [ClassProbability("cup", 0.7)]
    return CaptionedBox([1.0, 2.0, 30.0, 40.0], score, caption, graph, classes)


def graphs(nlu: Nlu, message: FrameCaptions) -> FrameGraphs:
    (reply,) = nlu.captions(message)
    assert isinstance(reply, FrameGraphs)
    return reply


def test_instruction_carries_stamp_and_graph(tagger: ScriptedTagger) -> None:
    nlu = Nlu(NluSettings(), tagger)
    (reply,) = nlu.instruction(Instruction(stamp_ns=9, episode="e", text="bring the red cup"))
    assert isinstance(reply, InstructionGraph)
    assert (reply.stamp_ns, reply.episode) == (9, "e")
    assert reply.graph == ObjectGraph("cup", {"color": "red"})
    assert (reply.task, reply.confidence, reply.reason) == ("bring", 0.8, "")
    assert reply.labels == ["O", "O", "B-color", "B-object"]


def test_instruction_without_object_has_a_reason(tagger: ScriptedTagger) -> None:
    nlu = Nlu(NluSettings(), tagger)
    (reply,) = nlu.instruction(Instruction(text="put it on the table"))
    assert isinstance(reply, InstructionGraph)
    assert reply.graph is None
    assert "no object to fetch or find was named" in reply.reason
    assert nlu.counters["not_understood"] == 1


def test_unsure_object_is_not_taken(tagger: ScriptedTagger) -> None:
    nlu = Nlu(NluSettings(min_object_probability=0.9), tagger)
    reply = nlu.parse(ParseRequest(stamp_ns=4, text="bring the cup"))
    assert reply.graph is None
    assert reply.stamp_ns == 4
    assert "not clear" in reply.reason


def test_a_frame_is_one_batch_and_keeps_its_boxes(tagger: ScriptedTagger) -> None:
    nlu = Nlu(NluSettings(), tagger)
    tagger.batches.clear()
    ready = ObjectGraph("Couches", {"color": "grey"}, [Relation("is-near", ObjectGraph("TV"))])
    reply = graphs(
        nlu,
        captions(box("a red cup", score=0.9), box(graph=ready), box("the table"), box("a cup")),
    )
    assert tagger.batches == [["a red cup", "the table", "a cup"]]
    assert (reply.stamp_ns, reply.episode, reply.camera, reply.frame) == (5, "e", "left", 3)
    assert [item.graph for item in reply.detections] == [
        ObjectGraph("cup", {"color": "red"}),
        ObjectGraph("sofa", {"color": "gray"}, [Relation("is-near", ObjectGraph("television"))]),
        ObjectGraph("cup"),
    ]
    assert reply.not_understood == ["the table"]
    first = reply.detections[0]
    assert (first.score, first.caption, first.box_px) == (0.9, "a red cup", [1.0, 2.0, 30.0, 40.0])
    assert first.classes == [ClassProbability("cup", 0.7)]


def test_an_empty_frame_is_answered(tagger: ScriptedTagger) -> None:
    reply = graphs(Nlu(NluSettings(), tagger), captions())
    assert reply.detections == []
    assert reply.not_understood == []


def test_captions_are_cached_up_to_the_bound(tagger: ScriptedTagger) -> None:
    nlu = Nlu(NluSettings(cache_size=2), tagger)
    tagger.batches.clear()
    graphs(nlu, captions(box("a cup"), box("a cup"), box("a red cup")))
    graphs(nlu, captions(box("a cup")))
    assert nlu.counters["cache_hits"] == 1
    graphs(nlu, captions(box("cup")))  # "a red cup" is the least recently used
    graphs(nlu, captions(box("a cup"), box("a red cup")))
    assert tagger.batches == [["a cup", "a red cup"], ["cup"], ["a red cup"]]


def test_more_captions_than_the_cache_holds(tagger: ScriptedTagger) -> None:
    nlu = Nlu(NluSettings(cache_size=0), tagger)
    reply = graphs(nlu, captions(box("a cup"), box("a red cup"), box("a cup")))
    assert [item.graph.attributes for item in reply.detections] == [{}, {"color": "red"}, {}]


class RecordingShell:
    """Stands for the shell: notes what a service wires."""

    def __init__(self) -> None:
        self.handlers: dict[type, object] = {}
        self.read_counters = dict

    def on(self, kind: type, handler: object, *, by_one: bool) -> None:
        assert by_one
        self.handlers[kind] = handler

    def answer(self, kind: type, handler: object) -> None:
        self.handlers[kind] = handler

    def counters(self, read) -> None:
        self.read_counters = read


def test_wiring_loads_the_model_and_takes_three_kinds() -> None:
    shell = RecordingShell()
    wire(shell, NluSettings())
    assert set(shell.handlers) == {Instruction, FrameCaptions, ParseRequest}
    reply = shell.handlers[ParseRequest](ParseRequest(text="find the bed"))
    assert reply.graph == ObjectGraph("bed")
    assert shell.read_counters()["captions"] == 0


def test_a_missing_model_is_refused(tmp_path) -> None:
    with pytest.raises(Refused, match="cannot be read"):
        wire(RecordingShell(), NluSettings(model_dir=str(tmp_path)))


@pytest.mark.parametrize(
    "text", ["take the cup and the plate", "bring me the red cup and the small blue plate"]
)
def test_two_targets_are_not_understood(text: str) -> None:
    reply = Nlu(NluSettings()).parse_text(text)
    assert reply.graph is None
    assert reply.reason == ("two targets were named, 'cup' and 'plate': ask for one at a time")


@pytest.mark.parametrize("text", ["a cup and a plate", "take the cup and put it on the table"])
def test_one_target_in_captions_and_with_side_actions(text: str) -> None:
    graph = Nlu(NluSettings()).parse_text(text, caption=text.startswith("a ")).graph
    assert graph is not None
    assert graph.name == "cup"
