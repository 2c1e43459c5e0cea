"""The error models of the paper: their statistics, their seed, their independence of order."""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np
import pytest

from doro_perception.core import Perception
from doro_perception.settings import PerceptionSettings
from doro_schemas.detector_errors import (
    ErrorModels,
    disturb,
    parse_errors,
    pool_of,
    read_pool,
    room_of,
    write_pool,
)
from doro_schemas.errors import Refused
from doro_schemas.messages import FrameCaptions, SimDetection, SimDetections
from doro_schemas.settings import load_settings
from doro_sim_feeder.disturb import disturbed, pool_from_recordings
from doro_sim_feeder.recording import Recording, write_recording
from doro_sim_feeder.steps import INPUT_TOPICS, steps

FRAMES, PER_FRAME = 400, 25
SIDE_PX = 300


def frame_of(number: int, episode: str = "FloorPlan1-seed0", count: int = PER_FRAME):
    """A frame whose boxes stay far from the image's edge, so that nothing is clipped."""
    random = np.random.default_rng(number)
    detections = []
    for k in range(count):
        x, y = random.uniform(90, 150, 2)
        width, height = random.uniform(20, 60, 2)
        detections.append(
            SimDetection(
                object_id=f"Cup|{k}",
                object_type="Cup",
                box_px=[float(v) for v in (x, y, x + width, y + height)],
                attributes={"color": "red"},
            )
        )
    return SimDetections(
        episode=episode, frame=number, height_px=SIDE_PX, width_px=SIDE_PX, detections=detections
    )


@pytest.fixture(scope="module")
def frames() -> list[SimDetections]:
    return [frame_of(number) for number in range(FRAMES)]


@pytest.fixture(scope="module")
def pool():
    others = [frame_of(k, "FloorPlan7-seed1", 4) for k in range(5)]
    return pool_of([*others, *(frame_of(k, "FloorPlan1-seed9", 3) for k in range(5))])


def boxes_of(frames: list[SimDetections]) -> np.ndarray:
    return np.array([item.box_px for frame in frames for item in frame.detections])


def centers_and_sizes(boxes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return (boxes[:, :2] + boxes[:, 2:]) / 2, boxes[:, 2:] - boxes[:, :2]


def test_centroid_shift_over_ten_thousand_boxes(frames):
    models = ErrorModels(errors=("cs",), seed=5)
    center, size = centers_and_sizes(boxes_of(frames))
    moved, moved_size = centers_and_sizes(boxes_of([disturb(frame, models) for frame in frames]))
    assert len(center) == 10_000
    np.testing.assert_allclose(moved_size, size, atol=1e-9)
    shift = (moved - center) / size
    assert abs(np.abs(shift).mean() - 0.2) < 0.002
    assert abs(np.abs(shift).std() - 0.04) < 0.002
    quadrants = np.bincount((shift > 0) @ [1, 2], minlength=4) / len(shift)
    assert np.abs(quadrants - 0.25).max() < 0.02
    assert abs(np.corrcoef(np.abs(shift).T)[0, 1]) < 0.04


def test_shape_distortion_over_ten_thousand_boxes(frames):
    models = ErrorModels(errors=("sd",), seed=5)
    center, size = centers_and_sizes(boxes_of(frames))
    kept, changed = centers_and_sizes(boxes_of([disturb(frame, models) for frame in frames]))
    np.testing.assert_allclose(kept, center, atol=1e-9)
    change = changed / size - 1
    np.testing.assert_allclose(change[:, 0], change[:, 1], atol=1e-9)
    assert abs(np.abs(change).mean() - 0.2) < 0.002
    assert abs(np.abs(change).std() - 0.04) < 0.002
    assert abs((change[:, 0] > 0).mean() - 0.5) < 0.02


def test_false_negatives_delete_fifteen_percent(frames):
    models = ErrorModels(errors=("fn",), seed=5)
    left = [disturb(frame, models) for frame in frames]
    assert abs(1 - len(boxes_of(left)) / 10_000 - 0.15) < 0.01
    for before, after in zip(frames, left, strict=True):
        assert [item for item in before.detections if item in after.detections] == after.detections


def test_false_positives_come_from_another_room_in_fifteen_percent_of_the_frames(pool):
    models = ErrorModels(errors=("fp",), seed=5)
    count = 0
    for number in range(4000):
        frame = frame_of(number, count=1)
        after = disturb(frame, models, pool)
        assert after.detections[:1] == frame.detections
        for extra in after.detections[1:]:
            count += 1
            assert extra.object_id.startswith("FalsePositive|FloorPlan7|Cup|")
            assert extra.attributes == {"color": "red"}
        assert len(after.detections) <= 2
    assert abs(count / 4000 - 0.15) < 0.015


def test_pasted_boxes_keep_their_share_of_a_smaller_image(pool):
    models = ErrorModels(errors=("fp",), seed=1, extra_probability=1.0)
    frame = SimDetections(episode="FloorPlan1", frame=0, height_px=150, width_px=600)
    (extra,) = disturb(frame, models, pool).detections
    origin = next(
        one.box
        for view in pool.rooms["FloorPlan7"]
        for one in view
        if f"FalsePositive|FloorPlan7|{one.detection.object_id}" == extra.object_id
        and abs(one.box[0] * 600 - extra.box_px[0]) < 1e-6
    )
    np.testing.assert_allclose(extra.box_px, np.array(origin) * [600, 150, 600, 150])


def test_errors_depend_on_seed_episode_camera_and_frame_only(frames):
    models = ErrorModels(errors=("cs", "sd", "fn"), seed=5)
    forwards = [disturb(frame, models) for frame in frames[:20]]
    backwards = [disturb(frame, models) for frame in reversed(frames[:20])]
    assert forwards == backwards[::-1]
    one = frames[0]
    for other in (
        disturb(one, ErrorModels(errors=("cs", "sd", "fn"), seed=6)),
        disturb(msgspec.structs.replace(one, episode="FloorPlan2"), models),
        disturb(msgspec.structs.replace(one, camera="left"), models),
        disturb(msgspec.structs.replace(one, frame=399), models),
    ):
        assert other.detections != forwards[0].detections


def test_an_error_draws_the_same_with_and_without_the_others(frames, pool):
    alone = disturb(frames[3], ErrorModels(errors=("fn",), seed=2))
    together = disturb(frames[3], ErrorModels(errors=("cs", "sd", "fn", "fp"), seed=2), pool)
    ids = [item.object_id for item in together.detections if item.object_id.startswith("Cup")]
    assert ids == [item.object_id for item in alone.detections]


def test_boxes_are_clipped_and_slivers_dropped():
    corner = SimDetection("Cup|a", "Cup", [0.0, 0.0, 40.0, 40.0])
    sliver = SimDetection("Cup|b", "Cup", [100.0, 10.0, 101.5, 40.0])
    models = ErrorModels(errors=("cs",), seed=0)
    for number in range(50):
        frame = SimDetections(frame=number, height_px=60, width_px=200, detections=[corner, sliver])
        (kept,) = disturb(frame, models).detections
        assert kept.object_id == "Cup|a"
        assert kept.box_px[0] >= 0
        assert kept.box_px[3] <= 60


def test_no_errors_change_nothing(frames):
    assert disturb(frames[0], ErrorModels()) == frames[0]


def test_names_of_errors_and_rooms():
    assert parse_errors("fn, cs,sd") == ("cs", "sd", "fn")
    assert parse_errors("") == ()
    assert room_of("FloorPlan19-seed3") == "FloorPlan19"
    assert room_of("copies-FloorPlan5-Cup") == "FloorPlan5"
    assert room_of("FloorPlan301_physics") == "FloorPlan301"
    assert room_of("FloorPlan_Train1_2") == "FloorPlan_Train1_2"
    assert room_of("kitchen-2") == "kitchen"
    with pytest.raises(Refused, match="'xs' is unknown"):
        parse_errors("cs,xs")


def test_false_positives_without_another_room_are_refused(frames):
    models = ErrorModels(errors=("fp",))
    with pytest.raises(Refused, match="other rooms"):
        disturb(frames[0], models)
    with pytest.raises(Refused, match="other rooms"):
        disturb(frames[0], models, pool_of(frames[:2]))


def test_pool_files(tmp_path: Path, pool):
    path = tmp_path / "pool.json"
    write_pool(path, pool)
    assert read_pool(path) == pool
    path.write_text('{"rooms": {"FloorPlan1": [[]]}}')
    with pytest.raises(Refused, match="no false-positive pool"):
        read_pool(path)
    with pytest.raises(Refused, match="cannot be read"):
        read_pool(tmp_path / "none.json")


def test_the_oracle_makes_the_same_errors(frames, tmp_path: Path, pool):
    write_pool(tmp_path / "pool.json", pool)
    settings = PerceptionSettings(
        errors="cs,sd,fn,fp", error_seed=4, fp_pool=str(tmp_path / "pool.json")
    )
    core = Perception(settings, pool=pool)
    for frame in frames[:30]:
        (captions,) = core.sim_detections(frame)
        assert isinstance(captions, FrameCaptions)
        expected = disturb(frame, ErrorModels(errors=("cs", "sd", "fn", "fp"), seed=4), pool)
        assert [box.box_px for box in captions.detections] == [
            item.box_px for item in expected.detections
        ]


@pytest.mark.parametrize(
    ("override", "sentence"),
    [('perception.errors="cs,ab"', "'ab' is unknown"), ('perception.errors="fp"', "fp_pool")],
)
def test_wrong_settings_are_refused(override: str, sentence: str):
    with pytest.raises(Refused, match=sentence):
        load_settings("perception", PerceptionSettings, None, (override,))


def test_playing_with_errors_changes_detections_only(frames, tmp_path: Path):
    path = tmp_path / "room.mcap"
    write_recording(path, frames[:5])
    models = ErrorModels(errors=("cs", "fn"), seed=8)
    played = list(disturbed(steps(Recording(path), INPUT_TOPICS), models))
    messages = [sample.message() for step in played for sample in step.samples]
    assert messages == [disturb(frame, models) for frame in frames[:5]]
    assert sorted(pool_from_recordings([path]).rooms) == ["FloorPlan1"]
