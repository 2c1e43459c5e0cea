"""The questionnaire made of the sample room: whole, blind, and true to the room."""

from __future__ import annotations

import base64
import json
import re
from collections import Counter
from html.parser import HTMLParser
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import cv2
import numpy as np
import pytest
from click.testing import CliRunner

import doro_sim_feeder
from doro_console.__main__ import main
from doro_evaluation.chain import load_room
from doro_evaluation.study.files import Asked, Study
from doro_evaluation.study.make import make_study, page, units_of
from doro_evaluation.study.scenes import Scene, choose, possible_scenes, scenes_of
from doro_evaluation.study.systems import Asker, check_systems, read_queries
from doro_evaluation.study.views import Photographer, views_for
from doro_nlu.core import Nlu
from doro_nlu.settings import NluSettings
from doro_schemas.errors import Refused
from doro_schemas.messages import SimDetection, SimDetections
from doro_sim_feeder.recording import Recorder
from tests.unit.study_files import small_study

SAMPLE = Path(doro_sim_feeder.__file__).parent / "data" / "sample-kitchen.mcap"
VOID = {"meta", "link", "br", "img", "input", "hr"}
SYSTEMS = ("ours", "paper_literal", "reference")


@pytest.fixture(scope="module")
def scenes() -> list[Scene]:
    return choose(possible_scenes(SAMPLE, 0), 6, 0)


@pytest.fixture(scope="module")
def made(scenes: list[Scene]) -> tuple[Study, str]:
    asker = Asker(SYSTEMS, 0, Nlu(NluSettings()))
    return make_study(scenes, asker, name="t", design="one", checks=2)


class Reader(HTMLParser):
    """Collects what a page refers to, and whether its elements close."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.references: list[str] = []
        self.texts: dict[str, str] = {}
        self._id = ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        names = ("src", "href", "action", "srcset", "poster", "background")
        self.references += [value or "" for name, value in attrs if name in names]
        self._id = given.get("id") or tag
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.texts[self._id] = self.texts.get(self._id, "") + data


def read(html: str) -> Reader:
    reader = Reader()
    reader.feed(html)
    reader.close()
    assert reader.open == []
    return reader


def data_of(html: str) -> dict[str, Any]:
    data: dict[str, Any] = json.loads(read(html).texts["data"])
    return data


def test_the_page_is_whole_and_reaches_for_nothing(made: tuple[Study, str]) -> None:
    html = made[1]
    reader = read(html)
    assert reader.references == []
    assert "default-src 'none'" in html
    assert not re.search(r"https?:|//[a-z]+\.|@import|url\(", html)
    for call in ("fetch(", "XMLHttpRequest", "WebSocket", "sendBeacon", "import("):
        assert call not in html
    assert "/*" + "DATA" not in html


def test_its_data_parse_and_every_picture_opens(made: tuple[Study, str]) -> None:
    study, html = made
    data = data_of(html)
    assert data["study"] == {"id": "t", "digest": study.digest}
    assert len(data["items"]) == 6
    for item in data["items"]:
        pictures = item["pictures"]
        assert 2 <= len(pictures) <= 5
        shown = {letter for one in pictures if "plan" not in one for letter in one["letters"]}
        assert shown == set(item["letters"])
        for picture in pictures:
            kind, _, text = picture["source"].partition(";base64,")
            raw = base64.b64decode(text)
            if picture.get("plan"):
                assert kind == "data:image/svg+xml"
                assert ElementTree.fromstring(raw).tag.endswith("svg")
            else:
                image = cv2.imdecode(np.frombuffer(raw, np.uint8), cv2.IMREAD_COLOR)
                assert image is not None
                assert image.shape == (480, 480, 3)
                assert image.std() > 10


def test_participants_cannot_see_who_asks(made: tuple[Study, str]) -> None:
    study, html = made
    for word in (*SYSTEMS, "asked", "state", "intended"):
        assert f'"{word}"' not in html
    units = [unit for item in data_of(html)["items"] for unit in item["units"]]
    assert all(set(unit) == {"id", "text"} for unit in units)
    # The number in the id does not tell the system either.
    numbers = {u.id[-1] for item in study.items for u in item.units if "paper_literal" in u.asked}
    assert len(numbers) > 1


def test_the_same_seed_gives_the_same_bytes(scenes: list[Scene], made: tuple[Study, str]) -> None:
    asker = Asker(SYSTEMS, 0, Nlu(NluSettings()))
    assert make_study(scenes, asker, name="t", design="one", checks=2) == made


def test_what_is_wanted_is_true_and_found_in_the_map(made: tuple[Study, str]) -> None:
    states = Counter(item.state for item in made[0].items)
    assert states["INFORM-AMBIGUITY"] == 3
    for item in made[0].items:
        asked = {system: one for unit in item.units for system, one in unit.asked.items()}
        assert set(asked) == set(SYSTEMS)
        assert bool(item.wanted) == bool(item.marks) == (item.state != "INFORM-MISSING")
        truth = {one.id: one.graph for one in asked["reference"].instances}
        found = {one.id: one.graph for one in asked["ours"].instances}
        wanted = {item.marks[letter] for letter in item.wanted}
        assert {*asked["reference"].intended} == wanted
        true_own = sorted(sorted(truth[one].attributes.items()) for one in wanted)
        own = sorted(sorted(found[one].attributes.items()) for one in asked["ours"].intended)
        assert own == true_own


def test_everybody_sees_every_system_equally_often() -> None:
    asked = {name: Asked(f"text of {name}") for name in SYSTEMS}
    items = [units_of(f"s{number:02}", asked, 0) for number in range(1, 7)]
    for turn in range(3):
        seen = Counter(next(iter(units[turn].asked)) for units in items)
        assert seen == dict.fromkeys(SYSTEMS, 2)


def test_systems_that_say_the_same_are_rated_once() -> None:
    asked = {"a": Asked("same"), "b": Asked("other"), "c": Asked("same")}
    units = units_of("s01", asked, 0)
    assert sorted(sorted(unit.asked) for unit in units) == [["a", "c"], ["b"]]


def test_no_text_can_end_the_data() -> None:
    study = small_study()
    shown = [{"id": "s01", "instruction": "</script><b>\u2028", "units": []}]
    html = page(study, shown)  # type: ignore[arg-type]
    assert data_of(html)["items"] == shown


def frame(number: int, **boxes: list[float]) -> SimDetections:
    found = [SimDetection(object_id=name, object_type="Cup", box_px=b) for name, b in boxes.items()]
    return SimDetections(frame=number, height_px=100, width_px=100, detections=found)


def test_views_show_everything_and_prefer_whole_things() -> None:
    small, good, cut = [50.0, 50.0, 52.0, 52.0], [45.0, 45.0, 55.0, 55.0], [0.0, 45.0, 10.0, 55.0]
    frames = [frame(0, a=small), frame(1, a=cut), frame(2, a=good), frame(3, b=good), frame(4)]
    assert set(views_for(frames, {"a": [], "b": []})) == {2, 3}
    assert views_for(frames, {"a": []})[0] == 2
    assert set(views_for(frames, {})) == {2, 3}
    with_lamp = [frame(0, a=good), frame(1, a=good, lamp=good)]
    assert views_for(with_lamp, {"a": ["lamp"]})[0] == 1


def test_a_recording_without_colour_that_cannot_be_rendered_again_is_refused(
    tmp_path: Path,
) -> None:
    room = load_room(SAMPLE)
    path = tmp_path / "walk.mcap"
    with Recorder(path) as recorder:
        recorder.add(room.depths[0])
        recorder.add(room.detections[0])
    with pytest.raises(Refused, match=r"walk\.mcap has no colour frames"):
        Photographer(path, room).images([0])


def test_too_few_scenes_and_no_recordings_are_refused(tmp_path: Path) -> None:
    nlu = Nlu(NluSettings())
    with pytest.raises(Refused, match="scenes, 500 are asked for"):
        scenes_of(None, [SAMPLE], [], nlu, count=500, seed=0)
    with pytest.raises(Refused, match="has no recordings"):
        scenes_of(tmp_path, [], [], nlu, count=1, seed=0)
    with pytest.raises(Refused, match="is not understood"):
        scenes_of(None, [SAMPLE], ["hello there"], nlu, count=1, seed=0)


def test_own_instructions_and_other_systems_queries(tmp_path: Path) -> None:
    line = {"system": "baseline", "recording": "sample-kitchen"}
    line |= {"instruction": "bring me the red cup", "text": "which cup?"}
    queries = tmp_path / "q.jsonl"
    queries.write_text(json.dumps(line) + "\n")
    out = tmp_path / "own.html"
    arguments = ["study", "make", "--recording", str(SAMPLE), "-i", "bring me the red cup"]
    arguments += ["--queries", str(queries), "--systems", "ours,baseline", "--out", str(out)]
    done = CliRunner().invoke(main, arguments)
    assert done.exit_code == 0, done.output
    texts = {unit["text"] for unit in data_of(out.read_text(encoding="utf-8"))["items"][0]["units"]}
    assert "which cup?" in texts
    assert (tmp_path / "own.json").is_file()


def test_a_queries_file_that_does_not_fit_and_unknown_systems_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "q.jsonl"
    path.write_text('\n{"system": 1}\n')
    with pytest.raises(Refused, match="line 2 of"):
        read_queries([path])
    with pytest.raises(Refused, match="there is no system 'theirs'"):
        check_systems(["theirs"], {})


def test_a_page_that_would_be_its_own_key_is_refused(tmp_path: Path) -> None:
    arguments = ["study", "make", "--recording", str(SAMPLE), "--out", str(tmp_path / "s.json")]
    done = CliRunner().invoke(main, arguments)
    assert done.exit_code == 1
    assert not list(tmp_path.iterdir())
