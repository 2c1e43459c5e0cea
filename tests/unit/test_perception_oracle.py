"""The oracle says what the simulator knows, in English that has one reading per object."""

import pytest

from doro_perception.caption import caption
from doro_perception.core import Perception
from doro_perception.settings import PerceptionSettings
from doro_schemas.errors import Refused
from doro_schemas.graph import ObjectGraph, Relation
from doro_schemas.messages import FrameCaptions, SimDetection, SimDetections, SimRelation

BOX = [10.0, 20.0, 60.0, 80.0]


def frame_of(*detections: SimDetection) -> SimDetections:
    return SimDetections(
        stamp_ns=77,
        episode="e1",
        camera="left",
        frame=5,
        height_px=100,
        width_px=120,
        detections=list(detections),
    )


def captions_of(frame: SimDetections, **settings: object) -> FrameCaptions:
    (output,) = Perception(PerceptionSettings(**settings)).sim_detections(frame)
    assert isinstance(output, FrameCaptions)
    return output


def thing(object_type: str, box_px: list[float] = BOX, **values: object) -> SimDetection:
    return SimDetection(
        object_id=f"{object_type}|1", object_type=object_type, box_px=box_px, **values
    )


RED_CUP = {"material": "plastic", "color": "red"}
TABLE = SimRelation("is-on", "DiningTable", {"color": "white", "material": "wood"})


@pytest.mark.parametrize(
    ("detection", "text"),
    [
        (thing("Cup"), "a cup"),
        (thing("Apple"), "an apple"),
        (thing("AlarmClock"), "an alarm clock"),
        (thing("Cup", attributes={"color": "orange"}), "an orange cup"),
        (thing("Cup", attributes=RED_CUP), "a red plastic cup"),
        (thing("Chair", attributes={"material": "wood"}), "a wooden chair"),
        (thing("Cup", attributes={"color": "red", "size": "small"}), "a small red cup"),
        (thing("Bread", attributes={"color": "brown"}), "brown bread"),
        (thing("CoffeeTable"), "a coffee table"),
        (thing("ArmChair", attributes={"color": "grey"}), "a gray arm chair"),
        (thing("Fridge"), "a refrigerator"),
        (thing("Cup", relations=[TABLE]), "a cup on the white wooden dining table"),
        (thing("Egg", relations=[SimRelation("is-at", "Fridge")]), "an egg in the refrigerator"),
        (
            thing("Cup", attributes=RED_CUP, relations=[TABLE, SimRelation("is-near", "Sink")]),
            "a red plastic cup on the white wooden dining table and near the sink",
        ),
    ],
)
def test_captions_are_fluent(detection: SimDetection, text: str) -> None:
    (box,) = captions_of(frame_of(detection)).detections
    assert (box.caption, box.score, box.graph) == (text, 1.0, None)


def test_relations_can_be_joined_without_and() -> None:
    cup = thing("Cup", relations=[SimRelation("is-on", "Shelf"), SimRelation("is-near", "Sink")])
    (box,) = captions_of(frame_of(cup), relation_joiner="").detections
    assert box.caption == "a cup on the shelf near the sink"


@pytest.mark.parametrize(
    ("phrase", "text"), [("unicorn", "a unicorn"), ("umbrella", "an umbrella"), ("oven", "an oven")]
)
def test_the_article_follows_the_sound(phrase: str, text: str) -> None:
    assert caption(ObjectGraph(name=phrase)) == text


def test_a_relation_without_english_words_is_refused() -> None:
    graph = ObjectGraph(name="cup", relations=[Relation("is-under", ObjectGraph(name="lid"))])
    with pytest.raises(Refused, match="relation type 'is-under' of 'cup'"):
        caption(graph)


def test_graphs_are_sent_on_demand() -> None:
    cup = thing("Cup", attributes=RED_CUP, relations=[TABLE])
    (box,) = captions_of(frame_of(cup), emit="graphs").detections
    table = ObjectGraph(name="dining table", attributes={"color": "white", "material": "wood"})
    assert box.caption == ""
    assert box.graph == ObjectGraph(
        name="cup", attributes=RED_CUP, relations=[Relation("is-on", table)]
    )


def test_structure_and_small_boxes_are_left_out_and_counted() -> None:
    core = Perception(PerceptionSettings(leave_out=("Floor",)))
    frame = frame_of(
        thing("Floor", relations=[]),
        thing("Pen", [10.0, 10.0, 15.0, 90.0]),
        thing("Coin", [10.0, 10.0, 17.0, 17.0]),
        thing("Cup", [112.0, 50.0, 120.4, 60.0]),
        thing("Mug", relations=[SimRelation("is-on", "Floor")]),
    )
    (output,) = core.sim_detections(frame)
    assert isinstance(output, FrameCaptions)
    assert [box.caption for box in output.detections] == ["a cup", "a mug on the floor"]
    assert output.detections[0].box_px == [112.0, 50.0, 120.0, 60.0]
    assert core.counters == {"frames": 1, "detections": 2, "left_out": 3}


def test_frame_data_is_copied_and_an_empty_frame_still_sends() -> None:
    output = captions_of(frame_of())
    assert output == FrameCaptions(
        stamp_ns=77, episode="e1", camera="left", frame=5, height_px=100, width_px=120
    )
    assert output.timing_us == {}


@pytest.mark.parametrize(
    ("detection", "reason"),
    [
        (thing("Cup|+1.0"), "objectType 'Cup|.1.0' of object .* frame 5 is no class name"),
        (thing(""), "objectType '' .* is no class name"),
        (thing("колба"), "is no class name"),
        (thing("Cup", attributes={"color": "#ff0000"}), "attribute 'color' .* has the value"),
        (thing("Cup", relations=[SimRelation("is-on", "\n")]), "is no class name"),
    ],
)
def test_unusable_text_is_refused_in_one_sentence(detection: SimDetection, reason: str) -> None:
    with pytest.raises(Refused, match=reason) as caught:
        captions_of(frame_of(detection))
    assert (caught.value.episode, caught.value.frame) == ("e1", 5)
    assert "\n" not in caught.value.reason
