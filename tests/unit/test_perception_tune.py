"""The choice of the map's thresholds for a detector that errs (no rendering)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from doro_evaluation.chain import Room
from doro_evaluation.counting.metrics import tally
from doro_evaluation.outcomes import Outcome, Thing
from doro_evaluation.perception import chain, tune
from doro_evaluation.perception.tuning_rooms import kind_of, rows
from doro_mapper.settings import MapperSettings
from doro_perception.settings import PerceptionSettings
from doro_schemas.messages import CaptionedBox, ClassProbability, FrameCaptions
from doro_sim_feeder.rooms.evaluation_set import plan_set


def test_no_tuning_room_is_a_test_room_and_every_recording_has_its_own_name() -> None:
    tested = {row.room for row in plan_set() if row.part in {"default", "copies"}}
    made = rows()
    assert not tested & {row.room for row in made}
    assert len({row.name for row in made}) == len(made)
    # A part of the list holds every room once before it holds one twice.
    rooms = [row.room for row in made]
    assert len(set(rooms[: len(set(rooms))])) == len(set(rooms))
    assert {kind_of(room) for room in rooms} == {"kitchen", "living room", "bedroom"}


def test_a_room_is_rendered_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    row, asked = rows()[0], []

    def render(row: object, views: int | None) -> chain.ColorRoom:
        asked.append(views)
        return chain.ColorRoom(Room("a", "FloorPlan14", "a", (), (), ()), ())

    monkeypatch.setattr(chain, "render", render)
    first = chain.kept_or_rendered(row, None, tmp_path)
    assert chain.kept_or_rendered(row, None, tmp_path) == first
    assert asked == [None]
    chain.kept_or_rendered(row, 60, tmp_path)  # fewer views are another room
    chain.kept_or_rendered(row, None, None)
    assert asked == [None, 60, None]


def outcome(room: str, true: int, found: int) -> Outcome:
    def things(count: int) -> tuple[Thing, ...]:
        return tuple(Thing("Cup", (float(k), 0.0, 0.0), (0.1,) * 3, 5) for k in range(count))

    return Outcome(room, room, "tune", "fused", "captioner", 9, things(true), things(found))


def test_each_kind_of_room_weighs_the_same_and_the_best_comes_first(
    capsys: pytest.CaptureFixture[str],
) -> None:
    good: tune.Key = ("fused", 0.5, 2.0, 0.25, 0.25)
    bad: tune.Key = ("fused", 0.7, 2.0, 0.25, 0.25)
    others: list[tune.Key] = [(name, 0.5, 2.0, 0.25, 0.25) for name in ("votes", "single frames")]

    def room(name: str, right: bool) -> tuple[str, dict[tune.Key, tune.Floats]]:
        one, two = tally(outcome(name, 2, 2)), tally(outcome(name, 2, 1))
        return name, {good: one if right else two, bad: two} | dict.fromkeys(others, two)

    rooms = [room("FloorPlan14", True), room("FloorPlan4", False), room("FloorPlan211", True)]
    f1 = tune.by_kind(rooms, good)
    assert f1["living room"] == 1.0
    assert 0.0 < f1["kitchen"] < 1.0
    tune.print_best(rooms)
    lines = capsys.readouterr().out.splitlines()
    assert lines[1].startswith("fused          0.50 2.0 0.25 0.25")
    mean = np.mean(list(f1.values()))
    wide = (mean + tune.means(rooms, [bad])[bad]) / 2
    assert f"| {mean:.3f} {wide:.3f} all" in lines[1]
    assert sum(line.startswith("votes") for line in lines) == 2


def test_a_setting_is_judged_with_those_around_it() -> None:
    scores = {0.4: 0.6, 0.5: 0.9, 0.55: 0.6, 0.6: 0.8, 0.65: 0.8, 0.7: 0.8}
    table: dict[tune.Key, float] = {
        ("votes", score, 3, 0.25, 0.25): f1 for score, f1 in scores.items()
    }
    table["votes", 0.5, 4, 0.25, 0.25] = 0.3
    found = {(key[1], key[2]): value for key, value in tune.around(table).items()}
    assert found[0.5, 3] == pytest.approx((0.6 + 0.9 + 0.6 + 0.3) / 4)
    assert found[0.65, 3] == pytest.approx(0.8)
    assert max(found, key=lambda place: found[place])[0] in (0.65, 0.7)


def test_a_way_takes_boxes_above_its_score_with_or_without_distributions() -> None:
    boxes = [
        CaptionedBox([0.0, 0.0, 9.0, 9.0], score, "a cup", None, [ClassProbability("cup", 1.0)])
        for score in (0.4, 0.6)
    ]
    said = FrameCaptions(
        stamp_ns=0, episode="e", camera="c", frame=0, width_px=10, height_px=10, detections=boxes
    )
    (left,) = chain.taken([said], chain.Way(0.5, MapperSettings(), distributions=True))
    assert left.detections == [boxes[1]]
    (bare,) = chain.taken([said], chain.Way(0.5, MapperSettings()))
    assert [(box.score, box.caption, box.classes) for box in bare.detections] == [
        (0.6, "a cup", [])
    ]


def test_the_detector_looks_low_enough_for_every_way_and_fused_is_what_is_shipped() -> None:
    assert chain.lowest_score() == min(way.score for way in chain.WAYS.values())
    fused = chain.WAYS["fused"]
    assert fused.score == PerceptionSettings().captioner_threshold
    assert fused.mapper == MapperSettings()
    assert not any(chain.WAYS[name].distributions for name in ("votes", "single frames"))
