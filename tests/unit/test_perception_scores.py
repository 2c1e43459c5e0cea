"""The figures of perception, on detections made by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from doro_evaluation.dressing.frames import CALIBRATION, HELD_OUT, rooms_of
from doro_evaluation.perception.scores import (
    Tally,
    Truth,
    add_image,
    average_precision,
    calibration_error,
    mean_precision,
    reliability,
)
from doro_perception.backend import Detection
from doro_sim_feeder.rooms.evaluation_set import plan_set

A, B, C = (0.0, 0.0, 10.0, 10.0), (20.0, 0.0, 30.0, 10.0), (40.0, 0.0, 50.0, 10.0)


def truth(*names: str, ignore: tuple[bool, ...] = ()) -> Truth:
    boxes = np.array([A, B, C][: len(names)])
    return Truth(
        boxes=boxes,
        names=tuple(frozenset(name.split("/")) for name in names),
        ignore=np.array(ignore or [False] * len(names)),
        colours=("red",) * len(names),
        materials=(frozenset({"glass", "metal"}),) * len(names),
    )


def seen(box: tuple[float, float, float, float], score: float, *names: str) -> Detection:
    shares = [0.6, 0.25, 0.1, 0.05]
    return Detection(
        box_px=box,
        score=score,
        name=names[0] if names else "",
        classes=tuple(zip(names, shares, strict=False)),
        colors=(("red", 0.9), ("pink", 0.1)),
        materials=(("wood", 0.9),),
    )


def test_a_perfect_detector_has_a_precision_of_one() -> None:
    tally = Tally()
    for _ in range(3):
        add_image(tally, truth("cup", "mug"), [seen(A, 0.9, "cup"), seen(B, 0.8, "mug")])
    assert mean_precision(tally) == (1.0, {"cup": 1.0, "mug": 1.0})
    assert [tally.share(name) for name in ("recall", "top1", "top3")] == [1.0, 1.0, 1.0]
    assert (tally.share("colour"), tally.share("material")) == (1.0, 0.0)


def test_swapped_names_count_as_third_choice_and_misses() -> None:
    tally = Tally()
    found = [seen(A, 0.9, "mug", "bowl", "cup"), seen(B, 0.8, "cup")]
    for _ in range(3):
        add_image(tally, truth("cup", "mug"), found)
    # The cup comes third of all that is called a cup (.15 of .9), behind the wrong one.
    assert mean_precision(tally)[1] == pytest.approx({"cup": 0.5, "mug": 0.0})
    assert (tally.share("top1"), tally.share("top3")) == (0.0, 0.5)
    assert tally.share("recall") == 1.0


def test_what_is_ignored_counts_neither_way() -> None:
    tally = Tally()
    for _ in range(3):
        image = truth("cup", "cup", ignore=(False, True))
        add_image(tally, image, [seen(A, 0.5, "cup"), seen(B, 0.9, "cup")])
    assert mean_precision(tally)[0] == 1.0
    assert tally.truths == {"cup": 3}


def test_a_second_box_on_a_thing_is_wrong_and_any_of_several_names_right() -> None:
    tally = Tally()
    for _ in range(3):
        add_image(tally, truth("desk/table"), [seen(A, 0.9, "desk"), seen(A, 0.8, "table")])
    precision = mean_precision(tally)[1]
    assert precision["desk/table"] == pytest.approx(1.0)  # the second comes after all are found
    assert sum(hit for _, hit in tally.rows["desk/table"]) == 3
    assert len(tally.rows["desk/table"]) == 6


def test_nameless_regions_are_recall_and_no_names() -> None:
    tally = Tally()
    add_image(tally, truth("cup"), [seen(A, 0.9)])
    assert tally.share("recall") == 1.0
    assert math.isnan(tally.share("top1"))
    assert tally.rows == {}
    add_image(tally, truth("cup"), [])
    assert tally.share("recall") == 0.5


def test_average_precision_by_hand() -> None:
    rows = [(0.9, True), (0.8, False), (0.7, True)]
    assert average_precision(rows, 2) == pytest.approx(0.5 * 1 + 0.5 * 2 / 3)
    assert average_precision(rows, 4) == pytest.approx(0.25 * 1 + 0.25 * 2 / 3)
    assert average_precision([], 3) == 0.0


def test_calibration_error_by_hand() -> None:
    certain = [(0.85, True)] * 3 + [(0.85, False)] + [(0.25, False)] * 4
    rows = reliability(certain)
    assert [(count, share) for _, share, count in rows] == [(4, 0.0), (4, 0.75)]
    assert calibration_error(certain) == pytest.approx((0.25 * 4 + 0.10 * 4) / 8)
    assert math.isnan(calibration_error([]))


def test_rooms_of_training_calibration_and_test_are_apart() -> None:
    train, held, tuned = (rooms_of(part) for part in ("train", "held-out", "calibration"))
    measured = {row.room for row in plan_set()}
    assert not set(train) & (measured | set(held) | set(tuned))
    assert not set(held) & (measured | set(tuned))
    assert not set(tuned) & measured
    assert (len(held), len(tuned)) == (len(HELD_OUT), len(CALIBRATION))
