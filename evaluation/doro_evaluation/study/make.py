"""``doro study make``: scenes, queries and pictures become a key and one HTML page."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from importlib.resources import files
from itertools import groupby
from string import ascii_uppercase
from typing import Any, Literal

import msgspec
import numpy as np

from doro_evaluation.study.files import SCALES, Asked, Check, Item, Study, Unit, with_digest
from doro_evaluation.study.plan import draw_plan
from doro_evaluation.study.scenes import Scene
from doro_evaluation.study.systems import Asker
from doro_evaluation.study.views import Photographer, shot, views_for

TEMPLATE = "study_page"


class Shown(msgspec.Struct, frozen=True):
    """What a participant sees of a scene; no word of who asked.

    Attributes:
        pictures: data URIs with the letters each shows, the views first, then the plan.
        noun: what the instruction is about.
    """

    id: str
    instruction: str
    noun: str
    letters: list[str]
    wanted: list[str]
    pictures: list[dict[str, Any]]
    units: list[dict[str, str]]


def make_study(
    scenes: Sequence[Scene],
    asker: Asker,
    *,
    name: str,
    design: Literal["one", "all"],
    checks: int,
    done: Callable[[str], None] = lambda _: None,
) -> tuple[Study, str]:
    """Return the key and the page.

    Args:
        scenes: in any order; participants see them in an order of their own.
        asker: the systems, seeded.
        name: the study's id.
        checks: number of attention checks.
        done: told the recording of every scene that is done.

    Raises:
        Refused: a recording cannot be shown, or a system has no query for a scene.
    """
    numbered = [(f"s{number:02}", scene) for number, scene in enumerate(scenes, 1)]
    items: dict[str, Item] = {}
    shown: dict[str, Shown] = {}
    by_recording = sorted(numbered, key=lambda pair: (pair[1].path, pair[0]))
    for _, group in groupby(by_recording, key=lambda pair: pair[1].path):
        for item_id, scene in group:
            items[item_id] = _item(item_id, scene, asker)
            shown[item_id] = _shown(items[item_id], scene, asker)
            done(scene.path.stem)
    order = [item_id for item_id, _ in numbered]
    study = with_digest(
        Study(
            id=name,
            seed=asker.seed,
            design=design,
            systems=list(asker.systems),
            items=[items[one] for one in order],
            checks=_checks(checks, asker.seed),
        )
    )
    return study, page(study, [shown[one] for one in order])


def _item(item_id: str, scene: Scene, asker: Asker) -> Item:
    marks = dict(zip(ascii_uppercase, [one.object_id for one in scene.candidates], strict=False))
    wanted = {one.object_id for one in scene.wanted}
    return Item(
        id=item_id,
        recording=scene.path.stem,
        instruction=scene.instruction,
        task=scene.task,
        graph=scene.graph,
        state=scene.state,
        marks=marks,
        wanted=[letter for letter, object_id in marks.items() if object_id in wanted],
        units=units_of(item_id, asker.ask(scene, f"{scene.path.stem}/{item_id}"), asker.seed),
    )


def units_of(item_id: str, asked: Mapping[str, Asked], seed: int) -> list[Unit]:
    """Return the texts to rate; systems that say the same share one.

    The order turns by one with every scene: whoever sees the k-th of each scene sees every
    system equally often. The numbers in the ids are seeded, as participants could read them.
    """
    turn = int(item_id[1:])
    texts = list(dict.fromkeys(one.text for one in asked.values()))
    texts = [texts[(turn + k) % len(texts)] for k in range(len(texts))]
    numbers = np.random.default_rng([seed, turn]).permutation(len(texts)) + 1
    return [
        Unit(
            id=f"{item_id}q{number}",
            text=text,
            asked={system: one for system, one in asked.items() if one.text == text},
        )
        for number, text in zip(numbers.tolist(), texts, strict=True)
    ]


def _shown(item: Item, scene: Scene, asker: Asker) -> Shown:
    room = asker.room(scene)
    landmarks = {
        one.object_id: [relation.object_id for relation in one.relations]
        for one in scene.candidates
    }
    views = views_for(room.detections, landmarks)
    images = Photographer(scene.path, room).images(views)
    shots = [
        shot(image, room.detections[view], item.marks, item.wanted)
        for image, view in zip(images, views, strict=True)
    ]
    pictures: list[dict[str, Any]] = [
        {"source": one.source, "letters": one.letters} for one in shots
    ]
    if item.marks:
        plan = draw_plan(room.truth, item.marks, item.wanted)
        pictures.append({"source": plan, "letters": list(item.marks), "plan": True})
    return Shown(
        id=item.id,
        instruction=item.instruction,
        noun=item.graph.name,
        letters=list(item.marks),
        wanted=item.wanted,
        pictures=pictures,
        units=[{"id": unit.id, "text": unit.text} for unit in item.units],
    )


def _checks(count: int, seed: int) -> list[Check]:
    """Return seeded checks; the two ratings asked for are never the same."""
    rng = np.random.default_rng([seed, 5])
    made = []
    for number in range(1, count + 1):
        informative, natural = (int(one) + 1 for one in rng.permutation(5)[:2])
        made.append(Check(f"c{number}", informative, natural))
    return made


def page(study: Study, shown: Sequence[Shown]) -> str:
    """Return the questionnaire: one HTML file with its styles, script, pictures and data."""
    data = {
        "study": {"id": study.id, "digest": study.digest},
        "design": study.design,
        "scales": SCALES,
        "items": msgspec.to_builtins(shown),
        "checks": msgspec.to_builtins(study.checks),
    }
    # "<" cannot end the script element, and the two separators cannot end a line of script.
    text = json.dumps(data, ensure_ascii=True, separators=(",", ":")).replace("<", "\\u003c")
    folder = files("doro_evaluation") / TEMPLATE
    html = (folder / "study.html").read_text(encoding="utf-8")
    for mark, part in (
        ("/*STYLE*/", (folder / "study.css").read_text(encoding="utf-8")),
        ("/*SCRIPT*/", (folder / "study.js").read_text(encoding="utf-8")),
        ("/*DATA*/", text),
    ):
        html = html.replace(mark, part)
    return html
