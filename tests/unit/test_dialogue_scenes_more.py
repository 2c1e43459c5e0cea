"""The specification goes on: nested landmarks, five instances, synonyms, tasks, odd nouns.

Notation as in ``test_dialogue_scenes``.
"""

from __future__ import annotations

import pytest

from doro_dialogue.decision import decide
from doro_dialogue.question import compose
from tests.unit import test_dialogue_readings, test_dialogue_rows, test_dialogue_scenes
from tests.unit.test_dialogue_scenes import (
    AMBIGUITY,
    CONFIRM,
    MISMATCH,
    MISSING,
    WHICH,
    candidates,
    graph,
)

# what it shows | said | seen | state | reason | numbers of the matches | first wording
SCENES = [
    # --- synonyms and kinds: what is the same, and what is not
    ("settee and sofa", "settee", ["sofa"], CONFIRM, "unique_match", [1],
     "Okay, I will take the sofa."),
    ("trash can and garbage can", "paper near[trash_can]", ["paper near[garbage_can]"], CONFIRM,
     "unique_match", [1], "Okay, I will take the paper near the garbage can."),
    ("counter and counter top", "cup on[counter]", ["cup on[counter_top]"], CONFIRM,
     "unique_match", [1], "Okay, I will take the cup on top of the counter top."),
    ("metallic and metal", "metal knife", ["metal knife"], CONFIRM, "unique_match", [1],
     "Okay, I will take the metal knife."),
    ("mobile phone and cell phone", "mobile_phone", ["cell_phone"], CONFIRM, "unique_match", [1],
     "Okay, I will take the cell phone."),
    ("a watch is no alarm clock", "watch", ["alarm_clock"], MISSING, "missing", [],
     "I could not find a watch."),
    ("a cup is no wine glass", "wine_glass", ["cup", "glass"], MISSING, "missing", [],
     "I could not find a wine glass."),
    ("a wine glass is a glass", "glass", ["wine_glass"], CONFIRM, "unique_match", [1],
     "Okay, I will take the wine glass."),
    ("a coffee table is a table", "table", ["coffee_table", "dining_table"], AMBIGUITY,
     "several_match", [1, 2], f"I found one coffee table, and one dining table; {WHICH}"),
    ("the coffee table is not the dining table", "coffee_table", ["dining_table"], MISSING,
     "missing", [], "I could not find a coffee table."),
    ("a mug is not offered for a cup", "cup", ["mug", "mug"], MISSING, "missing", [],
     "I could not find a cup."),
    ("crimson is red", "red cup", ["crimson cup"], CONFIRM, "unique_match", [1],
     "Okay, I will take the crimson cup."),
    ("red is not known to be crimson", "crimson cup", ["red cup"], MISMATCH, "unknown", [],
     "I found one red cup, but I could not tell whether it is crimson. Should I take it?"),
    ("oak is wood", "wooden table", ["table on[rug]"], MISMATCH, "unknown", [],
     "I found one table on top of the rug, but I could not tell whether it is made of wood."
     " Should I take it?"),
    ("blue and white is blue", "blue cup", ["blue_and_white cup"], CONFIRM, "unique_match", [1],
     "Okay, I will take the blue and white cup."),
    ("light blue is no dark blue, but both are blue", "blue cup",
     ["light_blue cup", "dark_blue cup"], AMBIGUITY, "several_match", [1, 2],
     f"I found one light blue cup, and one dark blue cup; {WHICH}"),
    # --- nested landmarks
    ("a landmark's color tells them apart", "lamp near[table]",
     ["lamp near[white table]", "lamp near[black table]"], AMBIGUITY, "several_match", [1, 2],
     f"I found one lamp near the white table, and one lamp near the black table; {WHICH}"),
    ("a landmark's color that nobody saw", "lamp near[white table]",
     ["lamp near[table]", "lamp near[black table]"], AMBIGUITY, "unknown", [],
     "I found one lamp near the black table, and one other lamp, but I could not tell whether"
     f" either of them is near the white table; {WHICH}"),
    ("a landmark's landmark tells them apart", "cup on[table]",
     ["cup on[table near[window]]", "cup on[table near[door]]"], AMBIGUITY, "several_match",
     [1, 2], "I found one cup on top of the table near the window, and one cup on top of the"
     f" table near the door; {WHICH}"),
    ("two landmarks deep", "cup on[table near[white sofa]]",
     ["cup on[table near[black sofa]]", "cup on[table near[white sofa]]"], CONFIRM,
     "unique_match", [2], "Okay, I will take the cup on top of the table near the white sofa."),
    ("contradicted two deep", "cup on[table near[white sofa]]", ["cup on[table near[black sofa]]"],
     MISMATCH, "mismatch", [], "I found one cup, but it is on top of the table near the black"
     " sofa. Should I take it?"),
    ("a landmark's material", "key on[wooden shelf]", ["key on[metal shelf]", "key on[wood shelf]"],
     CONFIRM, "unique_match", [2], "Okay, I will take the key on top of the wooden shelf."),
    ("landmark of another class", "book on[table]", ["book on[shelf]", "book on[table]"], CONFIRM,
     "unique_match", [2], "Okay, I will take the book on top of the table."),
    ("both places hold", "book on[shelf] near[lamp]",
     ["book on[shelf] near[lamp]", "book on[shelf]"], CONFIRM, "unique_match", [1],
     "Okay, I will take the book on top of the shelf and near the lamp. I could not tell whether"
     " another book is near the lamp."),
    ("one place holds, one is contradicted", "book on[shelf] near[lamp]",
     ["book on[table] near[lamp]"], MISMATCH, "mismatch", [],
     "I found one book near the lamp, but it is on top of the table. Should I take it?"),
    ("what was said is repeated, not all that is known", "pen at[drawer]", ["pen at[white drawer]"],
     CONFIRM, "unique_match", [1], "Okay, I will take the pen in the drawer."),
    ("in is not on", "cup on[sink]", ["cup at[sink]"], MISMATCH, "mismatch", [],
     "I found one cup, but it is in the sink. Should I take it?"),
    ("from where it stands", "cup at[table]", ["cup on[table]"], CONFIRM, "unique_match", [1],
     "Okay, I will take the cup on top of the table."),
    ("near the wrong one of two", "cup near[red lamp]", ["cup near[blue lamp]"], MISMATCH,
     "mismatch", [], "I found one cup, but it is near the blue lamp. Should I take it?"),
    ("near one of two lamps", "cup near[red lamp]", ["cup near[blue lamp] near[red lamp]"], CONFIRM,
     "unique_match", [1], "Okay, I will take the cup near the red lamp."),
    # --- five instances
    ("five by color", "cup", ["red cup", "blue cup", "green cup", "white cup", "black cup"],
     AMBIGUITY, "several_match", [1, 2, 3, 4, 5],
     "I found one red cup, one blue cup, one green cup, one white cup, and one black cup;"
     f" {WHICH}"),
    ("five by place", "red cup",
     ["red cup on[table]", "red cup on[desk]", "red cup at[sink]", "red cup near[stove]",
      "red cup on[shelf]"], AMBIGUITY, "several_match", [1, 2, 3, 4, 5],
     "I found one red cup on top of the table, one red cup on top of the desk, one red cup in the"
     f" sink, one red cup near the stove, and one red cup on top of the shelf; {WHICH}"),
    ("five, one matches", "red glass cup",
     ["red plastic cup", "blue glass cup", "red glass cup", "green cup", "white plastic cup"],
     CONFIRM, "unique_match", [3], "Okay, I will take the red glass cup."),
    ("five, two match", "red cup",
     ["red plastic cup", "blue cup", "red glass cup", "green cup", "white cup"], AMBIGUITY,
     "several_match", [1, 3], f"I found one red plastic cup, and one red glass cup; {WHICH}"),
    ("five, none matches", "purple cup",
     ["red cup", "blue cup", "green cup", "white cup", "black cup"], AMBIGUITY, "no_match", [],
     "I found one red cup, one blue cup, one green cup, one white cup, and one black cup, but no"
     f" purple cup; {WHICH}"),
    ("five of which three are twins", "cup",
     ["red cup on[table]"] * 3 + ["blue cup", "green cup"], AMBIGUITY, "several_match",
     [1, 2, 3, 4, 5],
     f"I found three identical red cups, one blue cup, and one green cup; {WHICH}"),
    ("five twins", "white plate", ["white plate"] * 5, AMBIGUITY, "several_match",
     [1, 2, 3, 4, 5], "I found five identical white plates; is any of them fine?"),
    ("five, two colors, two places", "cup",
     ["red cup on[table]", "red cup on[desk]", "blue cup on[table]", "blue cup on[desk]",
      "green cup on[table]"], AMBIGUITY, "several_match", [1, 2, 3, 4, 5],
     "I found one red cup on top of the table, one red cup on top of the desk, one blue cup on top"
     f" of the table, one blue cup on top of the desk, and one green cup; {WHICH}"),
    ("five, one of which little is known", "cup",
     ["red cup", "blue cup", "green cup", "white cup", "cup"], AMBIGUITY, "several_match",
     [1, 2, 3, 4, 5], "I found one red cup, one blue cup, one green cup, one white cup, and one"
     f" other cup; {WHICH}"),
    # --- twins
    ("twins of the wrong color", "red mug", ["blue mug on[shelf]", "blue mug on[shelf]"],
     AMBIGUITY, "no_match", [],
     "I found two identical blue mugs on top of the shelf, but no red mug; is either of them"
     " fine?"),
    ("twins among the matches only", "red mug", ["red mug", "red mug", "blue mug"], AMBIGUITY,
     "several_match", [1, 2], "I found two identical red mugs; is either of them fine?"),
    ("twins and one of which more is known", "mug", ["red mug", "red mug", "red mug on[table]"],
     AMBIGUITY, "several_match", [1, 2, 3],
     f"I found one mug on top of the table, and two other mugs; {WHICH}"),
    ("a pair of pairs", "scissors", ["red scissors", "red scissors"], AMBIGUITY, "several_match",
     [1, 2], "I found two identical pairs of red scissors; is either of them fine?"),
    ("twins whose landmarks differ in words only", "cup", ["cup on[couch]", "cup on[sofa]"],
     AMBIGUITY, "several_match", [1, 2],
     "I found two cups on top of the sofa; is either of them fine?"),
    ("three twins and one other color", "cup", ["red cup", "red cup", "red cup", "blue cup"],
     AMBIGUITY, "several_match", [1, 2, 3, 4],
     f"I found three identical red cups, and one blue cup; {WHICH}"),
    # --- what nobody observed
    ("two unknowns, no match", "red cup", ["cup on[table]", "cup on[desk]"], AMBIGUITY, "unknown",
     [], "I found one cup on top of the table, and one cup on top of the desk, but I could not tell"
     f" whether either of them is red; {WHICH}"),
    ("material not observed", "plastic bowl", ["red bowl"], MISMATCH, "unknown", [],
     "I found one bowl, but I could not tell whether it is made of plastic. Should I take it?"),
    ("a match and a contradiction: the unknown is told", "red cup", ["red cup", "blue cup", "cup"],
     CONFIRM, "unique_match", [1],
     "Okay, I will take the red cup. I could not tell whether another cup is red."),
    ("near says nothing about the others", "cup near[sink]",
     ["cup near[sink]", "cup near[stove]"], CONFIRM, "unique_match", [1],
     "Okay, I will take the cup near the sink. I could not tell whether another cup is near the"
     " sink."),
    ("two facts unknown", "red plastic cup", ["cup"], MISMATCH, "unknown", [],
     "I found one cup, but I could not tell whether it is red and made of plastic."
     " Should I take it?"),
    ("nothing at all is known of two", "red cup", ["cup", "cup"], AMBIGUITY, "unknown", [],
     "I found two cups, but I could not tell whether either of them is red; is either of them"
     " fine?"),
    # --- articles, plurals, words
    ("an before orange", "orange mug", [], MISSING, "missing", [],
     "I could not find an orange mug."),
    ("an before a vowel sound only", "umbrella", [], MISSING, "missing", [],
     "I could not find an umbrella."),
    ("irregular plurals", "knife", ["knife", "knife"], AMBIGUITY, "several_match", [1, 2],
     "I found two knives; is either of them fine?"),
    ("shelves", "shelf", ["wood shelf"] * 3, AMBIGUITY, "several_match", [1, 2, 3],
     "I found three identical wooden shelves; is any of them fine?"),
    ("boxes", "box", ["red box", "red box"], AMBIGUITY, "several_match", [1, 2],
     "I found two identical red boxes; is either of them fine?"),
    ("the head noun carries the plural", "roll_of_toilet_paper", ["roll_of_toilet_paper"] * 2,
     AMBIGUITY, "several_match", [1, 2],
     "I found two rolls of toilet paper; is either of them fine?"),
    ("compounds are whole", "remote_control", ["black remote_control", "white remote_control"],
     AMBIGUITY, "several_match", [1, 2],
     f"I found one black remote control, and one white remote control; {WHICH}"),
    ("glasses to drink from", "wine_glass", ["wine_glass", "wine_glass"], AMBIGUITY,
     "several_match", [1, 2], "I found two wine glasses; is either of them fine?"),
    ("wooden stands before the noun, made of wood behind it", "wooden spoon", ["metal spoon"],
     MISMATCH, "mismatch", [],
     "I found one spoon, but it is made of metal. Should I take it?"),
    ("color before material", "red wooden box", ["red wood box"], CONFIRM, "unique_match", [1],
     "Okay, I will take the red wooden box."),
    ("relations right of the noun, joined by and", "cup on[table] near[lamp]",
     ["cup on[table] near[lamp]"], CONFIRM, "unique_match", [1],
     "Okay, I will take the cup on top of the table and near the lamp."),
    # --- the smallest set, no more
    ("material where color is shared", "cup",
     ["red glass cup on[table]", "red plastic cup on[table]"], AMBIGUITY, "several_match", [1, 2],
     f"I found one glass cup, and one plastic cup; {WHICH}"),
    ("place where color and material are shared", "cup",
     ["red glass cup on[table]", "red glass cup at[sink]"], AMBIGUITY, "several_match", [1, 2],
     f"I found one cup on top of the table, and one cup in the sink; {WHICH}"),
    ("each by its own", "cup", ["red cup on[table]", "blue cup on[table]", "blue cup at[sink]"],
     AMBIGUITY, "several_match", [1, 2, 3],
     f"I found one red cup, one blue cup on top of the table, and one cup in the sink; {WHICH}"),
    ("near as a last resort", "cup",
     ["red cup on[table] near[lamp]", "red cup on[table] near[plate]"], AMBIGUITY,
     "several_match", [1, 2],
     f"I found one cup near the lamp, and one cup near the plate; {WHICH}"),
    ("the landmark's color costs a word more than another fact", "cup",
     ["red cup on[white table]", "blue cup on[black table]"], AMBIGUITY, "several_match", [1, 2],
     f"I found one red cup, and one blue cup; {WHICH}"),
]  # fmt: skip


@pytest.mark.parametrize("scene", SCENES, ids=[scene[0] for scene in SCENES])
def test_scene(scene):
    _, said, seen, state, reason, matches, text = scene
    decision = decide(graph(said), candidates(seen))
    assert (decision.state, decision.reason) == (state, reason)
    assert decision.matches == [f"x-{number}" for number in matches]
    assert compose(decision).wordings[0] == text


def test_the_specification_has_at_least_150_scenes():
    modules = (test_dialogue_scenes.SCENES, SCENES, test_dialogue_readings.SCENES)
    rows = (test_dialogue_rows.ROWS, test_dialogue_rows.CROWDS)
    scenes = [scene for module in (*modules, *rows) for scene in module]
    assert len(scenes) >= 150
    told = [repr(scene[1:3]) for scene in scenes]
    assert len(set(told)) == len(told)
