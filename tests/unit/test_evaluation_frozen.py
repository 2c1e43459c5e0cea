"""Five rooms with frozen figures: fails when mapper or dialogue get worse."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest

from doro_dialogue.decision import paper_literal
from doro_evaluation.context import Recorded
from doro_evaluation.queries.systems import DECIDERS
from doro_evaluation.regression import (
    ROOMS,
    Frozen,
    fallen,
    make_slice,
    measure_slice,
    read_frozen,
)
from doro_mapper.settings import MapperSettings

MISSING = [
    name for name in ("embreex", "procthor", "PIL") if importlib.util.find_spec(name) is None
]
needs_render = pytest.mark.skipif(
    bool(MISSING), reason=f"the extra 'render' is not installed: no {', '.join(MISSING)}"
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("frozen")


@pytest.fixture(scope="module")
def rooms(folder: Path) -> list[Recorded]:
    return make_slice(folder)


@needs_render
def test_the_slice_is_as_good_as_frozen_and_the_same_twice(
    rooms: list[Recorded], folder: Path
) -> None:
    assert len(rooms) == len(ROOMS) == 5
    figures = measure_slice(rooms, folder / "cache")
    assert fallen(figures, read_frozen()) == []
    # The second run reads what was kept; two rooms are made twice.
    assert measure_slice(rooms, folder / "cache") == figures
    assert measure_slice(rooms[:2], folder / "one") == measure_slice(rooms[:2], folder / "again")


@needs_render
def test_a_worse_mapper_falls(rooms: list[Recorded], folder: Path) -> None:
    worse = MapperSettings(without=("observability",))
    told = fallen(measure_slice(rooms, folder / "worse", worse), read_frozen())
    assert any(line.startswith("counting/ours/all/average/f1") for line in told)
    blind = MapperSettings(min_hits=4)
    told = fallen(measure_slice(rooms, folder / "blind", blind), read_frozen())
    assert any(line.startswith("counting/ours/gt/average/f1") for line in told)
    assert any(line.startswith("multi-view/ours/qa") for line in told)


@needs_render
def test_a_worse_dialogue_falls(
    rooms: list[Recorded], folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(DECIDERS, "ours", paper_literal)
    told = fallen(measure_slice(rooms, folder / "cache"), read_frozen())
    assert any(line.startswith("multi-view/ours/qa") for line in told)
    assert not any(line.startswith("counting") for line in told)


def test_what_falls_or_is_gone_is_told() -> None:
    frozen = {"a/f1": Frozen(0.9, 0.03), "a/items": Frozen(5, 0), "b/f1": Frozen(0.5, 0.03)}
    assert fallen({"a/f1": 0.88, "a/items": 5, "b/f1": 0.9}, frozen) == []
    told = fallen({"a/f1": 0.86, "a/items": 6}, frozen)
    assert [line.split(" ")[0] for line in told] == ["a/f1", "a/items", "b/f1"]
