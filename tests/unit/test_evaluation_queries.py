"""The automatic rule of QA, the F1 of ambiguity, BLEU and intervals, on cases made by hand."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace

import msgspec
import pytest
from sacrebleu.metrics.bleu import BLEU

from doro_dialogue.decision import decide
from doro_dialogue.facts import Candidate
from doro_dialogue.question import compose
from doro_evaluation.bootstrap import Score, interval
from doro_evaluation.queries.judge import Truth, Verdict, identify, judge
from doro_evaluation.queries.pairs import Pair, select_pairs
from doro_evaluation.queries.scores import ambiguity_f1, bleu, score_queries, states_f1
from doro_evaluation.queries.systems import QueryOutcome
from doro_evaluation.tagging.labels import intervals
from doro_nlu.train.annotate import Example
from doro_schemas.errors import Refused
from doro_schemas.graph import ObjectGraph, Relation
from doro_schemas.messages import Evidence, Instance, SimDetection, SimDetections
from doro_sim_feeder.rooms.truth import TrueInstance, TrueRelation

ON_TABLE = TrueRelation("is-on", "Table|1", "DiningTable", {"color": "white"})


def thing(
    name: str, kind: str, color: str, center_m: tuple[float, float, float], side_m: float = 0.1
) -> TrueInstance:
    return TrueInstance(
        number=1,
        object_id=name,
        object_type=kind,
        attributes={"color": color},
        center_m=list(center_m),
        size_m=[side_m] * 3,
        receptacle="",
        relations=[ON_TABLE] if kind == "Cup" else [],
        views=9,
    )


TABLE = thing("Table|1", "DiningTable", "white", (0.0, 0.4, 0.0), 0.8)
RED = thing("Cup|1", "Cup", "red", (0.2, 0.85, 0.2))
BLUE = thing("Cup|2", "Cup", "blue", (-0.2, 0.85, -0.2))
LAMP = thing("Lamp|1", "DeskLamp", "black", (0.5, 0.85, 0.2))
ROOM = [TABLE, RED, BLUE, LAMP]
TRUTH = Truth.of(ROOM, {item.object_id for item in ROOM})
CUP = ObjectGraph("cup")


def found(name: str, graph: ObjectGraph, center_m: tuple[float, float, float]) -> Instance:
    return Instance(
        instance_id=name, graph=graph, position_m=list(center_m), extent_m=[0.1, 0.1, 0.1]
    )


def cup(color: str, *relations: Relation) -> ObjectGraph:
    return ObjectGraph("cup", {"color": color}, list(relations))


def verdict(said: ObjectGraph, instances: list[Instance], true: ObjectGraph | None = None):  # type: ignore[no-untyped-def]
    decision = decide(said, [Candidate(one.instance_id, one.graph) for one in instances])
    question = compose(decision)
    outcome = (decision, question, question.wordings[0])
    return judge(TRUTH, true or said, "", outcome, identify(instances, TRUTH))


RED_FOUND = found("cup-1", cup("red"), (0.25, 0.85, 0.2))
BLUE_FOUND = found("cup-2", cup("blue"), (-0.2, 0.9, -0.2))


def test_a_question_about_the_two_true_cups_is_right() -> None:
    assert verdict(CUP, [RED_FOUND, BLUE_FOUND]).fault == ""


def test_a_cup_too_few_is_another_state() -> None:
    assert verdict(CUP, [RED_FOUND]).fault == "state"


def test_a_cup_too_many_is_a_fault_of_the_instances() -> None:
    ghost = found("cup-3", cup("green"), (3.0, 0.85, 3.0))
    assert verdict(CUP, [RED_FOUND, BLUE_FOUND, ghost]).fault == "instances"


def test_two_found_cups_at_one_true_cup_are_a_fault_of_the_instances() -> None:
    twice = found("cup-2", cup("blue"), (0.3, 0.85, 0.2))
    assert verdict(CUP, [RED_FOUND, twice]).fault == "instances"


def test_a_confirmed_cup_half_a_metre_away_is_not_the_true_one() -> None:
    near = found("cup-1", cup("red"), (0.2, 0.85, 0.65))
    far = found("cup-1", cup("red"), (0.2, 0.85, 0.75))
    assert verdict(cup("red"), [near, BLUE_FOUND]).fault == ""
    assert verdict(cup("red"), [far, BLUE_FOUND]).fault == "instances"


def test_a_wrong_color_in_a_clause_is_a_fault_of_the_attributes() -> None:
    painted = found("cup-2", cup("green"), (-0.2, 0.85, -0.2))
    assert verdict(CUP, [RED_FOUND, painted]).fault == "attributes"


def test_a_relation_that_the_truth_does_not_list_counts_when_the_boxes_say_so() -> None:
    """The truth lists the table only; the lamp stands 20 cm from the red cup."""
    near_lamp = Relation("is-near", ObjectGraph("desk lamp"))
    far_sofa = Relation("is-near", ObjectGraph("sofa"))
    assert TRUTH.holds(ObjectGraph("cup", {}, [near_lamp]), "Cup|1")
    assert not TRUTH.holds(ObjectGraph("cup", {}, [far_sofa]), "Cup|1")
    assert not TRUTH.holds(ObjectGraph("cup", {}, [Relation("is-on", LAMP_GRAPH)]), "Cup|1")


LAMP_GRAPH = ObjectGraph("desk lamp")


def test_another_name_is_not_true_of_a_thing() -> None:
    assert TRUTH.untrue(ObjectGraph("cup"), "Cup|1") == ""
    assert TRUTH.untrue(ObjectGraph("plate"), "Cup|1") == "name: plate"


def test_a_landmark_of_another_color_is_not_the_one() -> None:
    on_black = Relation("is-on", ObjectGraph("dining table", {"color": "black"}))
    assert not TRUTH.holds(ObjectGraph("cup", {}, [on_black]), "Cup|1")


def test_twins_are_told_by_side_as_they_stand_in_the_frame() -> None:
    twins = [thing(f"Cup|{k}", "Cup", "red", (0.3 * k, 0.85, 0.0)) for k in (1, 2)]
    frame = SimDetections(
        camera="cam0", frame=7, width_px=300, height_px=300, stamp_ns=1,
        detections=[
            SimDetection(object_id=f"Cup|{k}", object_type="Cup", box_px=[x, 90.0, x + 20.0, 120.0])
            for k, x in ((1, 50.0), (2, 150.0))
        ],
    )  # fmt: skip
    truth = Truth.of([TABLE, *twins], {"Cup|1", "Cup|2"}, [frame])
    boxes = {"cup-1": (0.3, [51, 90, 70, 121]), "cup-2": (0.6, [149, 91, 170, 119])}
    instances = [found(name, cup("red"), (x, 0.85, 0.0)) for name, (x, _) in boxes.items()]

    def said(order: tuple[str, str]) -> Verdict:
        shown = {
            name: (Evidence("cam0", 7, [float(v) for v in boxes[of][1]]),)
            for name, of in zip(("cup-1", "cup-2"), order, strict=True)
        }
        decision = decide(
            CUP, [Candidate(o.instance_id, o.graph, shown[o.instance_id]) for o in instances]
        )
        question = compose(decision)
        outcome = (decision, question, question.wordings[0])
        return judge(truth, CUP, "", outcome, identify(instances, truth))

    right, wrong = said(("cup-1", "cup-2")), said(("cup-2", "cup-1"))
    assert "on the left" in right.text
    assert right.fault == ""
    assert any("one on the left and one on the right" in text for text in right.references)
    assert (wrong.fault, wrong.why) == ("attributes", "left and right")


def test_what_was_not_understood_is_wrong_and_has_the_true_state() -> None:
    result = judge(TRUTH, CUP, "", None, {})
    assert (result.fault, result.said, result.true) == ("not understood", "", "INFORM-AMBIGUITY")


def test_what_no_view_reports_is_not_in_the_truth() -> None:
    hidden = Truth.of(ROOM, {"Table|1", "Cup|1"})
    assert hidden.decide(CUP).state == "CONFIRM"


def outcome(said: str, true: str, text: str = "", references: tuple[str, ...] = ("",), room="r"):  # type: ignore[no-untyped-def]
    pair = Pair(f"{room}/{said}/{true}/{text}", room, "self", "true", "x", "", CUP)
    fault = "" if said == true else "state"
    return QueryOutcome(pair, "ours", "multi-view", Verdict(fault, said, true, text, [*references]))


def test_ambiguity_f1_counts_every_state_but_confirm_as_positive() -> None:
    rows = [
        outcome("CONFIRM", "CONFIRM"),
        outcome("INFORM-MISSING", "INFORM-AMBIGUITY"),  # positive either way: a hit
        outcome("CONFIRM", "INFORM-MISMATCH"),  # missed
        outcome("INFORM-AMBIGUITY", "CONFIRM"),  # false alarm
    ]
    assert ambiguity_f1(rows) == pytest.approx(2 * 1 / (2 + 2))


def test_states_f1_is_weighted_by_the_true_number() -> None:
    rows = [
        outcome("CONFIRM", "CONFIRM"),
        outcome("CONFIRM", "CONFIRM"),
        outcome("CONFIRM", "INFORM-MISSING"),
        outcome("INFORM-MISSING", "INFORM-MISSING"),
    ]
    confirm, missing = 2 * 2 / (2 + 3), 2 * 1 / (2 + 1)
    assert states_f1(rows) == pytest.approx((confirm * 2 + missing * 2) / 4)


def test_bleu_takes_the_wording_that_fits_best() -> None:
    said = "I found one red cup near the sink; which one do you mean?"
    right = [outcome("A", "A", said, ("Which of the two?", said))]
    wrong = [outcome("A", "A", said, ("I could not find any such thing in this room.",))]
    assert bleu(right).value == pytest.approx(1.0)
    assert bleu(wrong).value < 0.2


def test_bleu_of_many_is_sacrebleus_corpus_score() -> None:
    texts = ["I found one red cup.", "I could not find a mug.", "Got it, I will take the red cup."]
    meant = ["I found one blue cup.", "I could not find any mug.", "Got it, I take the red cup."]
    rows = [outcome("A", "A", *pair, room=f"r{k}") for k, pair in enumerate(
        (said, (true, "Which one?")) for said, true in zip(texts, meant, strict=True)
    )]  # fmt: skip
    wanted = BLEU().corpus_score(texts, [meant, ["Which one?"] * 3]).score / 100
    found = bleu(rows)
    assert found.value == pytest.approx(wanted)
    assert found.low <= found.value <= found.high


def test_recordings_of_one_room_are_drawn_together() -> None:
    """Two rooms, one all right and one all wrong: the interval is as wide as it can be."""
    rows = [
        outcome("CONFIRM", true, room=f"copies-{room}-{kind}")
        for room, true in (("FloorPlan1", "CONFIRM"), ("FloorPlan2", "INFORM-MISSING"))
        for kind in ("Cup", "Mug", "Bowl")
    ]
    qa = score_queries(rows).qa
    assert (qa.low, qa.value, qa.high) == (0.0, 0.5, 1.0)
    assert score_queries(rows) == score_queries(list(rows))


def test_scores_of_right_and_wrong_pairs() -> None:
    rows = [outcome("CONFIRM", "CONFIRM", "Okay.", ("Okay.",), room=f"r{k}") for k in range(3)]
    rows.append(outcome("CONFIRM", "INFORM-MISSING", "Okay.", ("I found none.",), room="r3"))
    scores = score_queries(rows)
    assert scores.qa.value == 0.75
    assert scores.qa.low <= 0.75 <= scores.qa.high <= 1.0
    assert scores.faults == {"state": 1}


def test_an_interval_of_equal_rooms_has_no_width_and_of_none_is_no_number() -> None:
    def mean(values: list[float]) -> float:
        return sum(values) / len(values)

    assert interval([[1.0, 0.0], [1.0, 0.0]], mean) == (0.5, 0.5)
    low, high = interval([[1.0], [0.0], [1.0], [0.0]], mean)
    assert low < 0.5 < high
    assert all(math.isnan(bound) for bound in interval([], mean))


def write_references(folder: Path, part: str, room: str, count: int) -> None:
    lines = []
    for k in range(count):
        for kind in ("self", "self_relation", "name"):
            pair = Pair(f"{part}-{room}/{kind}/{k}", f"{part}-{room}", kind, "true", "x", "", CUP)
            lines.append(msgspec.json.encode(pair))
    (folder / f"{part}-{room}.references.jsonl").write_bytes(b"\n".join(lines) + b"\n")


def test_pairs_are_a_third_of_each_kind_the_same_for_the_same_seed(tmp_path: Path) -> None:
    write_references(tmp_path, "default", "FloorPlan1", 20)
    write_references(tmp_path, "validation", "FloorPlan301", 20)
    write_references(tmp_path, "extra", "FloorPlan2", 20)
    chosen = select_pairs(tmp_path, "test", 7, 30)
    kinds = [pair.kind for pair in chosen]
    assert {kind: kinds.count(kind) for kind in kinds} == dict.fromkeys(
        ("self", "self_relation", "name"), 10
    )
    assert all(pair.episode.startswith("default") for pair in chosen)
    assert chosen == select_pairs(tmp_path, "test", 7, 30)
    assert chosen != select_pairs(tmp_path, "test", 8, 30)


def test_a_set_without_instructions_is_refused(tmp_path: Path) -> None:
    with pytest.raises(Refused, match="doro rooms set"):
        select_pairs(tmp_path, "test", 7)


class _Parrot:
    """Says what it is told, a list of labels for each sentence."""

    labels = ("O", "B-object", "B-color")

    def __init__(self, said: list[list[str]]) -> None:
        self._said = said

    def tag(self, sentences: list[list[str]]) -> list[SimpleNamespace]:
        return [SimpleNamespace(labels=self._said.pop(0)) for _ in sentences]


def test_tagging_intervals_are_of_f1_over_sentences() -> None:
    wanted = [["O", "B-object"], ["B-color", "B-object"]]
    examples = [Example(["a", "cup"], wanted[0]), Example(["red", "cup"], wanted[1])]
    found = intervals(_Parrot([["O", "B-object"], ["O", "B-object"]]), examples)  # type: ignore[arg-type]
    assert found["B-object/f1"] == Score(1.0, 1.0, 1.0)
    assert found["B-color/f1"].value == 0.0
    # Two objects right (1.0) and one color missed (0.0), by their number.
    assert found["weighted_f1"].value == pytest.approx(2 / 3)
    assert found["weighted_f1"].low == 0.5
    assert found["sentence_accuracy"] == Score(0.5, 0.0, 1.0)
