"""The baseline's training data: never a test room, the same every time, text there and back."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from doro_evaluation.baseline.batches import Line, batches, build_vocabulary, thinned
from doro_evaluation.baseline.examples import CONFIGURATIONS, Example, examples
from doro_evaluation.baseline.rooms import BaseRoom, base_rooms, object_types, training_rooms
from doro_evaluation.baseline.text import (
    BEGIN,
    END,
    INPUT_PIECES,
    PAD,
    Vocabulary,
    about,
    joined,
    noun_of,
)
from doro_nlu.wordpiece import SPECIALS
from doro_schemas.errors import Refused
from doro_sim_feeder.rooms.evaluation_set import plan_set
from doro_sim_feeder.rooms.more_sets import plan_part

ROOM = "FloorPlan301"


@pytest.fixture(scope="module")
def base() -> BaseRoom:
    return next(iter(base_rooms([ROOM])))


@pytest.fixture(scope="module")
def made(base: BaseRoom) -> list[Example]:
    return list(itertools.islice(examples([base], object_types([ROOM]), 7), 150))


def test_no_test_room_is_trained_on(made: list[Example]) -> None:
    rows = [*plan_set(), *plan_part("extra")]
    tested = {row.room for row in rows if row.part != "validation"}
    assert len(tested) == 34
    names = training_rooms()
    assert len(names) == len(set(names)) == 90 - 34
    assert not tested & set(names)
    assert {one.room for one in made} <= set(names)


def test_examples_are_the_same_for_a_seed_and_differ_for_another(
    base: BaseRoom, made: list[Example]
) -> None:
    types = object_types([ROOM])
    assert list(itertools.islice(examples([base], types, 7), 150)) == made
    assert list(itertools.islice(examples([base], types, 8), 150)) != made


def test_every_configuration_and_state_occurs(made: list[Example]) -> None:
    assert {one.configuration for one in made} == set(CONFIGURATIONS)
    states = {"CONFIRM", "INFORM-MISMATCH", "INFORM-AMBIGUITY", "INFORM-MISSING"}
    assert {one.state for one in made} == states
    for one in made:
        if one.state == "INFORM-MISSING":
            assert one.target.startswith("I could not find")
        else:
            assert one.captions, "something is found that no caption tells of"


def test_captions_are_filtered_by_noun_and_twins_stay() -> None:
    seen = [
        "a red cup on the white table",
        "a white table near the red cup",
        "a red cup on the white table",
        "a brown arm chair near the wooden table",
    ]
    assert about(seen, "bring me the red cup on the table") == [seen[0], seen[2]]
    assert about(seen, "find a chair") == [seen[3]]
    assert about(seen, "") == about([], "bring the cup") == []
    assert noun_of("pick up a plastic cup next to the sink") == "cup"
    assert joined([["a", "b"], [], ["c"]]) == "a ; b | c"


def test_text_there_and_back(made: list[Example]) -> None:
    lines = [Line(e.configuration, e.state, e.instruction, e.captions, e.target) for e in made]
    # A base vocabulary of whole words and characters stands for BERT's.
    words = {w.lower() for e in made for w in e.target.replace(",", " ").split()}
    characters = [chr(code) for code in range(33, 127) if not chr(code).isupper()]
    base_names = [*SPECIALS, *characters, *(f"##{c}" for c in characters if c.isalnum())]
    names, _ = build_vocabulary(lines, [*base_names, *sorted(words - set(base_names))])
    vocabulary = Vocabulary(names)
    for one in made:
        ids = vocabulary.target(one.target)
        assert ids[-1] == END
        assert vocabulary.text(ids) == one.target
    batch = next(batches(lines, vocabulary, 2000, 0))
    assert sum(batch.pieces.shape[1:] + batch.written.shape[1:]) * len(batch.pieces) <= 2000
    assert (batch.written[:, 0] == BEGIN).all()
    assert ((batch.pieces != PAD) == (batch.mask > 0)).all()


def test_long_input_is_cut_and_vocabulary_is_checked() -> None:
    vocabulary = Vocabulary([*SPECIALS, *"abcdefghijklmnopqrstuvwxyz;|"])
    ids = vocabulary.input([["a b c"] * 100] * 9, "d e")
    assert len(ids) == INPUT_PIECES
    assert (ids[0], ids[-1], ids.count(END)) == (BEGIN, END, 2)
    with pytest.raises(Refused, match="begins with"):
        Vocabulary(["a", "b"])


def test_a_share_of_the_long_ones_is_kept() -> None:
    lines = [Line(CONFIGURATIONS[k % 3], "CONFIRM", "a", [], "b") for k in range(900)]
    kept = [line.configuration for line in thinned(lines, 0.4, 7)]
    assert kept.count("one view") == kept.count("our aggregator") == 300
    assert 90 <= kept.count("captions joined") <= 150
    assert np.array_equal(kept, [line.configuration for line in thinned(lines, 0.4, 7)])
