"""The decision and the question as a specification: what is said, what was seen, what follows.

Notation of a graph: adjectives, noun, then relations with their landmark in brackets,
"red plastic cup on[white table] near[sink]"; an underscore joins words ("dark_blue").
"""

from __future__ import annotations

import re

import pytest

from doro_dialogue.decision import decide
from doro_dialogue.facts import Candidate
from doro_dialogue.question import compose
from doro_schemas.graph import ObjectGraph, Relation

MATERIALS = ["plastic", "wood", "wooden", "metal", "glass", "ceramic", "porcelain"]


def graph(text: str) -> ObjectGraph:
    words, relations, depth, start = "", [], 0, 0
    for i, char in enumerate(text):
        if char == "[":
            if depth == 0:
                start = i
            depth += 1
        elif char == "]":
            depth -= 1
            if depth == 0:
                kind = re.search(r"([\w-]+)$", words).group(1)
                words = words[: -len(kind)]
                relations.append(Relation(f"is-{kind}", graph(text[start + 1 : i])))
        elif depth == 0:
            words += char
    *adjectives, noun = words.split()
    own = {}
    for word in adjectives:
        own["material" if word in MATERIALS else "color"] = word.replace("_", " ")
    return ObjectGraph(noun.replace("_", " "), own, relations)


CONFIRM, MISMATCH = "CONFIRM", "INFORM-MISMATCH"
AMBIGUITY, MISSING = "INFORM-AMBIGUITY", "INFORM-MISSING"
WHICH = "which one do you mean?"

# what it shows | said | seen | state | reason | numbers of the matches | first wording
SCENES = [
    # nothing of the class
    ("nothing seen", "red cup", [], MISSING, "missing", [], "I could not find a red cup."),
    ("only other classes", "red cup", ["red mug", "red bowl"], MISSING, "missing", [],
     "I could not find a red cup."),
    ("an before a vowel", "orange cup", [], MISSING, "missing", [],
     "I could not find an orange cup."),
    ("a mass noun", "bread", [], MISSING, "missing", [], "I could not find any bread."),
    ("a pair", "black scissors", [], MISSING, "missing", [],
     "I could not find a pair of black scissors."),
    ("all that was said is repeated", "cup on[white table]", [], MISSING, "missing", [],
     "I could not find a cup on top of the white table."),
    ("a cup is no mug", "mug", ["cup"], MISSING, "missing", [], "I could not find a mug."),
    ("a sofa is no arm chair", "sofa", ["arm_chair"], MISSING, "missing", [],
     "I could not find a sofa."),
    ("a lamp need not be a desk lamp", "desk_lamp", ["lamp"], MISSING, "missing", [],
     "I could not find a desk lamp."),
    ("a landmark is no instance", "table", ["cup on[table]"], MISSING, "missing", [],
     "I could not find a table."),
    # one match
    ("the only one", "cup", ["cup"], CONFIRM, "unique_match", [1], "Okay, I will take the cup."),
    ("it says where", "cup", ["red cup on[table]"], CONFIRM, "unique_match", [1],
     "Okay, I will take the cup on top of the table."),
    ("attribute", "red cup", ["red cup"], CONFIRM, "unique_match", [1],
     "Okay, I will take the red cup."),
    ("attribute and place", "red cup on[table]", ["red cup on[table]"], CONFIRM,
     "unique_match", [1], "Okay, I will take the red cup on top of the table."),
    ("one right, one wrong", "red cup", ["red cup", "blue cup"], CONFIRM, "unique_match", [1],
     "Okay, I will take the red cup."),
    ("one right, three wrong", "red cup",
     ["blue cup", "green cup", "red cup near[sink]", "white cup"], CONFIRM, "unique_match", [3],
     "Okay, I will take the red cup near the sink."),
    ("told apart by the place", "red cup on[table]", ["red cup on[desk]", "red cup on[table]"],
     CONFIRM, "unique_match", [2], "Okay, I will take the red cup on top of the table."),
    ("said less than seen", "cup", ["blue glass cup on[table] near[sink]"], CONFIRM,
     "unique_match", [1], "Okay, I will take the cup on top of the table."),
    ("couch and sofa", "couch", ["sofa"], CONFIRM, "unique_match", [1],
     "Okay, I will take the sofa."),
    ("grey and gray", "grey cup", ["gray cup"], CONFIRM, "unique_match", [1],
     "Okay, I will take the gray cup."),
    ("wooden and wood", "wooden chair", ["wood chair"], CONFIRM, "unique_match", [1],
     "Okay, I will take the wooden chair."),
    ("tv and television", "remote near[tv]", ["remote_control near[television]"], CONFIRM,
     "unique_match", [1], "Okay, I will take the remote control near the television."),
    ("fridge and refrigerator", "egg at[fridge]", ["egg at[refrigerator]"], CONFIRM,
     "unique_match", [1], "Okay, I will take the egg in the refrigerator."),
    ("a kind of it", "lamp", ["desk_lamp"], CONFIRM, "unique_match", [1],
     "Okay, I will take the desk lamp."),
    ("a kind of the landmark", "cup on[table]", ["cup on[coffee_table]"], CONFIRM,
     "unique_match", [1], "Okay, I will take the cup on top of the coffee table."),
    ("from the desk", "pen at[desk]", ["pen on[desk]"], CONFIRM, "unique_match", [1],
     "Okay, I will take the pen on top of the desk."),
    ("in the arm chair is on it", "pillow on[arm_chair]", ["pillow at[arm_chair]"], CONFIRM,
     "unique_match", [1], "Okay, I will take the pillow in the arm chair."),
    ("on a tray on the table", "cup on[table]", ["cup on[tray on[table]]"], CONFIRM,
     "unique_match", [1],
     "Okay, I will take the cup on top of the tray on top of the table."),
    ("on a plate in the microwave", "egg at[microwave]", ["egg on[plate at[microwave]]"],
     CONFIRM, "unique_match", [1],
     "Okay, I will take the egg on top of the plate in the microwave."),
    ("landmark's color", "lamp near[white table]",
     ["lamp near[black table]", "lamp near[white table]"], CONFIRM, "unique_match", [2],
     "Okay, I will take the lamp near the white table."),
    ("landmark's landmark", "cup on[table near[window]]", ["cup on[table near[window]]"],
     CONFIRM, "unique_match", [1],
     "Okay, I will take the cup on top of the table near the window."),
    ("near one of several", "cup near[sink]", ["cup near[stove] near[sink]"], CONFIRM,
     "unique_match", [1], "Okay, I will take the cup near the sink."),
    ("dark blue is blue", "blue cup", ["dark_blue cup"], CONFIRM, "unique_match", [1],
     "Okay, I will take the dark blue cup."),
    ("navy is blue", "blue cup", ["navy cup"], CONFIRM, "unique_match", [1],
     "Okay, I will take the navy cup."),
    ("porcelain is ceramic", "ceramic cup", ["porcelain cup"], CONFIRM, "unique_match", [1],
     "Okay, I will take the porcelain cup."),
    ("an unknown beside a match is not kept silent", "red cup", ["red cup", "cup on[table]"],
     CONFIRM, "unique_match", [1],
     "Okay, I will take the red cup. I could not tell whether another cup is red."),
    ("two unknowns beside a match", "red cup", ["red cup", "cup on[table]", "cup"],
     CONFIRM, "unique_match", [1],
     "Okay, I will take the red cup. I could not tell whether two other cups are red."),
    # one, and it differs
    ("other color", "red cup", ["blue cup"], MISMATCH, "mismatch", [],
     "I found one cup, but it is blue. Should I take it?"),
    ("other material", "plastic cup", ["wooden cup"], MISMATCH, "mismatch", [],
     "I found one cup, but it is made of wood. Should I take it?"),
    ("other place", "red cup on[table]", ["red cup on[desk]"], MISMATCH, "mismatch", [],
     "I found one red cup, but it is on top of the desk. Should I take it?"),
    ("what holds is said too", "red cup on[table]", ["blue cup on[table]"], MISMATCH,
     "mismatch", [], "I found one cup on top of the table, but it is blue. Should I take it?"),
    ("all differs", "red cup on[table]", ["blue cup on[desk]"], MISMATCH, "mismatch", [],
     "I found one cup, but it is blue and on top of the desk. Should I take it?"),
    ("landmark's color differs", "lamp near[white table]", ["lamp near[black table]"], MISMATCH,
     "mismatch", [], "I found one lamp, but it is near the black table. Should I take it?"),
    ("from the desk, but on the table", "pen at[desk]", ["pen on[table]"], MISMATCH,
     "mismatch", [], "I found one pen, but it is on top of the table. Should I take it?"),
    ("in the fridge is not on it", "cup on[fridge]", ["cup at[refrigerator]"], MISMATCH,
     "mismatch", [], "I found one cup, but it is in the refrigerator. Should I take it?"),
    ("on the table is not near it", "cup near[table]", ["cup on[table]"], MISMATCH, "mismatch",
     [], "I found one cup, but it is on top of the table. Should I take it?"),
    ("dark blue is not light blue", "dark_blue cup", ["light_blue cup"], MISMATCH, "mismatch",
     [], "I found one cup, but it is light blue. Should I take it?"),
    ("a pair differs", "red scissors", ["blue scissors"], MISMATCH, "mismatch", [],
     "I found one pair of scissors, but they are blue. Should I take them?"),
    ("one differs, one was not observed", "red plastic cup", ["blue cup"], MISMATCH,
     "mismatch", [], "I found one cup, but it is blue, and I could not tell whether it is"
     " made of plastic. Should I take it?"),
    # one, and something was not observed
    ("color not observed", "red cup", ["cup near[sink]"], MISMATCH, "unknown", [],
     "I found one cup near the sink, but I could not tell whether it is red."
     " Should I take it?"),
    ("place not observed", "red cup on[table]", ["red cup"], MISMATCH, "unknown", [],
     "I found one red cup, but I could not tell whether it is on top of the table."
     " Should I take it?"),
    ("near something else excludes nothing", "cup near[sink]", ["cup near[stove]"], MISMATCH,
     "unknown", [], "I found one cup near the stove, but I could not tell whether it is"
     " near the sink. Should I take it?"),
    ("landmark's color not observed", "lamp near[white table]", ["lamp near[table]"], MISMATCH,
     "unknown", [], "I found one lamp near the table, but I could not tell whether it is"
     " near the white table. Should I take it?"),
    ("a broader landmark", "cup on[coffee_table]", ["cup on[table]"], MISMATCH, "unknown", [],
     "I found one cup on top of the table, but I could not tell whether it is on top of the"
     " coffee table. Should I take it?"),
    ("the sink may be in the kitchen", "cup at[kitchen]", ["cup at[sink]"], MISMATCH, "unknown",
     [], "I found one cup in the sink, but I could not tell whether it is in the kitchen."
     " Should I take it?"),
    ("the shade was not observed", "dark_blue cup", ["blue cup"], MISMATCH, "unknown", [],
     "I found one blue cup, but I could not tell whether it is dark blue. Should I take it?"),
    ("silver may be gray", "silver cup", ["gray cup"], MISMATCH, "unknown", [],
     "I found one gray cup, but I could not tell whether it is silver. Should I take it?"),
    # several match
    ("by color", "cup", ["red cup", "blue cup"], AMBIGUITY, "several_match", [1, 2],
     f"I found one red cup, and one blue cup; {WHICH}"),
    ("color before place", "cup", ["red cup on[table]", "blue cup near[sink]"], AMBIGUITY,
     "several_match", [1, 2], f"I found one red cup, and one blue cup; {WHICH}"),
    ("by place, where the color is shared", "red cup",
     ["red cup on[table]", "red cup near[sink]"], AMBIGUITY, "several_match", [1, 2],
     f"I found one red cup on top of the table, and one red cup near the sink; {WHICH}"),
    ("by material", "cup", ["red plastic cup", "red glass cup"], AMBIGUITY, "several_match",
     [1, 2], f"I found one plastic cup, and one glass cup; {WHICH}"),
    ("by kind", "lamp", ["desk_lamp", "floor_lamp"], AMBIGUITY, "several_match", [1, 2],
     f"I found one desk lamp, and one floor lamp; {WHICH}"),
    ("by the landmark's color", "cup", ["cup on[white table]", "cup on[black table]"],
     AMBIGUITY, "several_match", [1, 2],
     f"I found one cup on top of the white table, and one cup on top of the black table; {WHICH}"),
    ("two facts where one is not enough", "cup",
     ["red plastic cup", "red glass cup", "blue plastic cup", "blue glass cup"], AMBIGUITY,
     "several_match", [1, 2, 3, 4],
     "I found one red plastic cup, one red glass cup, one blue plastic cup, and one blue"
     f" glass cup; {WHICH}"),
    ("each by what it needs", "cup",
     ["red wood cup on[table]", "red wood cup on[desk]", "red plastic cup on[table]",
      "blue cup on[table]", "blue wood cup"], AMBIGUITY, "several_match", [1, 2, 3, 4, 5],
     "I found one wooden cup on top of the table, one cup on top of the desk, one plastic"
     f" cup, one blue cup on top of the table, and one blue wooden cup; {WHICH}"),
    ("only the matches are asked about", "red cup",
     ["red cup on[table]", "blue cup on[desk]", "red cup on[shelf]"], AMBIGUITY,
     "several_match", [1, 3],
     f"I found one red cup on top of the table, and one red cup on top of the shelf; {WHICH}"),
    ("a shade beside its color", "blue cup", ["blue cup", "dark_blue cup"], AMBIGUITY,
     "several_match", [1, 2], f"I found one blue cup, and one dark blue cup; {WHICH}"),
    ("one known better than the other", "cup", ["cup", "red cup"], AMBIGUITY, "several_match",
     [1, 2], f"I found one red cup, and one other cup; {WHICH}"),
    ("a chain of less and less known", "cup", ["cup", "red cup", "red cup on[table]"],
     AMBIGUITY, "several_match", [1, 2, 3],
     f"I found one cup on top of the table, one other red cup, and one other cup; {WHICH}"),
    ("what is known to differ comes before what is not known", "cup",
     ["red cup on[table]", "cup on[desk]"], AMBIGUITY, "several_match", [1, 2],
     f"I found one cup on top of the table, and one cup on top of the desk; {WHICH}"),
    ("pairs", "scissors", ["blue scissors", "red scissors"], AMBIGUITY, "several_match", [1, 2],
     f"I found one pair of blue scissors, and one pair of red scissors; {WHICH}"),
    # twins
    ("twins", "red cup", ["red cup on[table]", "red cup on[table]"], AMBIGUITY,
     "several_match", [1, 2],
     "I found two identical red cups on top of the table; is either of them fine?"),
    ("twins of which little is known", "cup", ["cup", "cup"], AMBIGUITY, "several_match",
     [1, 2], "I found two cups; is either of them fine?"),
    ("three of a kind", "white_mug", ["white_mug", "white_mug", "white_mug"], AMBIGUITY,
     "several_match", [1, 2, 3], "I found three white mugs; is any of them fine?"),
    ("knives", "metal knife", ["metal knife", "metal knife"], AMBIGUITY, "several_match",
     [1, 2], "I found two identical metal knives; is either of them fine?"),
    ("twins in other words", "grey cup", ["grey cup", "gray cup"], AMBIGUITY, "several_match",
     [1, 2], "I found two identical gray cups; is either of them fine?"),
    ("twins by look, told apart by place", "red cup", ["red cup on[table]", "red cup on[desk]"],
     AMBIGUITY, "several_match", [1, 2],
     f"I found one red cup on top of the table, and one red cup on top of the desk; {WHICH}"),
    ("twins and another", "cup", ["red cup on[table]", "red cup on[table]", "blue cup"],
     AMBIGUITY, "several_match", [1, 2, 3],
     f"I found two identical red cups, and one blue cup; {WHICH}"),
    ("two twins", "cup", ["red cup", "blue cup", "red cup", "blue cup"], AMBIGUITY,
     "several_match", [1, 2, 3, 4],
     f"I found two identical red cups, and two identical blue cups; {WHICH}"),
    ("five, two of them twins", "glass",
     ["red glass", "blue glass", "green glass", "white glass", "white glass"], AMBIGUITY,
     "several_match", [1, 2, 3, 4, 5],
     "I found one red glass, one blue glass, one green glass, and two identical white"
     f" glasses; {WHICH}"),
    # several, none matches
    ("none is red", "red cup", ["blue cup", "green cup"], AMBIGUITY, "no_match", [],
     f"I found one blue cup, and one green cup, but no red cup; {WHICH}"),
    ("right color, wrong place and the other way round", "red cup on[table]",
     ["red cup on[desk]", "blue cup on[table]"], AMBIGUITY, "no_match", [],
     f"I found one red cup, and one blue cup, but no red cup on top of the table; {WHICH}"),
    ("twins, but wrong", "red cup", ["blue cup", "blue cup"], AMBIGUITY, "no_match", [],
     "I found two identical blue cups, but no red cup; is either of them fine?"),
    ("one wrong, one not observed", "red cup", ["blue cup", "cup on[table]"], AMBIGUITY,
     "unknown", [], "I found one blue cup, and one cup on top of the table, but I could not"
     f" tell whether either of them is red; {WHICH}"),
    ("three not observed", "red cup", ["cup on[table]", "cup at[sink]", "cup on[desk]"],
     AMBIGUITY, "unknown", [], "I found one cup on top of the table, one cup in the sink, and"
     f" one cup on top of the desk, but I could not tell whether any of them is red; {WHICH}"),
    ("another label set's relation", "cup under[table]", ["cup under[table]", "cup under[desk]"],
     CONFIRM, "unique_match", [1], "Okay, I will take the cup under the table."
     " I could not tell whether another cup is under the table."),
]  # fmt: skip


def candidates(seen: list[str]) -> list[Candidate]:
    return [Candidate(f"x-{i + 1}", graph(text)) for i, text in enumerate(seen)]


@pytest.mark.parametrize("scene", SCENES, ids=[scene[0] for scene in SCENES])
def test_scene(scene):
    _, said, seen, state, reason, matches, text = scene
    decision = decide(graph(said), candidates(seen))
    assert (decision.state, decision.reason) == (state, reason)
    assert decision.matches == [f"x-{number}" for number in matches]
    assert compose(decision).wordings[0] == text


def test_the_specification_covers_every_state_and_reason():
    assert len(SCENES) >= 60
    assert {scene[3] for scene in SCENES} == {CONFIRM, MISMATCH, AMBIGUITY, MISSING}
    reasons = {"unique_match", "several_match", "no_match", "mismatch", "unknown", "missing"}
    assert {scene[4] for scene in SCENES} == reasons


@pytest.mark.parametrize(
    ("share", "tail"),
    [
        (0.0, "a red cup."),
        (0.002, "; less than 1 % of the area has not been seen."),
        (0.2, "; about 20 % of the area has not been seen."),
        (0.996, "; about 100 % of the area has not been seen."),
    ],
)
def test_missing_says_how_much_was_not_seen(share, tail):
    wordings = compose(decide(graph("red cup"), []), unseen_share=share).wordings
    assert wordings[0].endswith(tail)


@pytest.mark.parametrize(
    ("seen", "task", "text"),
    [
        (["red cup"], "find", "Okay, it is the red cup."),
        (["red cup"], "pick up", "Okay, I will take the red cup."),
        (["blue cup"], "find", "I found one cup, but it is blue. Is that what you mean?"),
        (["red cup on[table]", "red cup on[desk]"], "go to", "I found one red cup on top"
         f" of the table, and one red cup on top of the desk; {WHICH}"),
    ],
)  # fmt: skip
def test_a_task_that_carries_nothing_is_not_answered_with_taking(seen, task, text):
    wordings = compose(decide(graph("red cup"), candidates(seen)), task=task).wordings
    assert wordings[0] == text
    assert not any("take" in wording for wording in wordings) or task == "pick up"
