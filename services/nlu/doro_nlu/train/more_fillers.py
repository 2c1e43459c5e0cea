"""Words and phrases for the slots of ``more_frames.py``."""

from __future__ import annotations

from collections.abc import Callable
from random import Random

from doro_nlu.train import lexicon as lex
from doro_nlu.train.fillers import lines
from doro_nlu.train.nouns import place, plural, thing
from doro_nlu.train.phrases import Phrases, strip_labels

MORE_WORDS: dict[str, tuple[str, ...]] = {
    "verb0": lines(
        """bring|take|get|fetch|grab|pick up|touch|move|give me|choose|hand me|want|use|carry"""
    ),
    "verbing": lines(
        """picking up|grabbing|taking|getting|bringing|fetching|finding|looking for|moving|
        retrieving|locating|removing|holding|examining"""
    ),
    "verbing0": lines("""pick up|grab|bring|carry|hold|fetch|hand me|take"""),
    "putting": lines("""putting|placing|moving|setting|leaving|storing|dropping|throwing"""),
    "part": lines("""pick|take|pull|lift|get|bring|carry|move|slide|grab|hold|push"""),
    "particle": lines("""up|up|up|out|out|over|down|away|off|back|along"""),
    "cook": lines(
        """cook|heat|warm up|microwave|wash|rinse|clean|chill|cool|slice|cut|heat up|boil|fry|
        refrigerate|warm|soak|dry|cool down|toast|wipe|slice up|freeze"""
    ),
    "cooking": lines(
        """cooking|heating|warming|microwaving|washing|rinsing|cleaning|chilling|cooling|slicing"""
    ),
    "cooked": lines(
        """cooked|heated|warm|microwaved|washed|rinsed|clean|chilled|cooled|sliced|hot|cold|
        cleaned|cut|freshly washed|warmed|cooled down|cut up|wet|boiled|warmed up|washed|rinsed"""
    ),
    "appliance": lines(
        """in the microwave|in the fridge|in the sink|with the knife|in the refrigerator|
        under the faucet|in the oven|with a knife|on the stove|in the dishwasher|with water|
        in the basin|using the microwave|for a few seconds|with a sponge|into slices|in half"""
    ),
    "doingside": lines(
        """turning on the lamp|holding the tray|standing at the door|you are there|
        turning the light on|keeping the door open|walking to the sofa|switching on a lamp"""
    ),
    "state": lines(
        """hungry|thirsty|cold|tired|in the kitchen|on the couch|sick|late|bored|in a hurry|
        cooking|at the table|going to bed|sad|busy|done|wet|ready|leaving the house"""
    ),
    "use": lines(
        """drink|eat|read|write with|cut bread|clean the table|sit on|drink from|play with|
        wipe the floor|put on the wall"""
    ),
    "nturn": lines("""90|180|45|30|ninety|a hundred and eighty|ten|60|360"""),
}
_MANY = ("two", "three", "four", "five", "several", "some", "many", "six", "a few", "both")
_CONTAINED = ("{P on}", "{P on}", "{P on top of}", "{A in}", "{A inside}", "{A inside of}")


def more_slots(phrases: Phrases, rng: Random) -> dict[str, Callable[[str], str]]:
    """Return the slots by name; each takes the slot's argument, which they do not need."""
    return {
        "name": lambda _: thing(rng),
        "names": lambda _: plural(thing(rng)),
        "name2": lambda _: thing(rng),
        "name3": lambda _: thing(rng),
        "place": lambda _: place(rng, "P"),
        "room": lambda _: rng.choice(lex.ROOMS),
        "adj": lambda _: rng.choice(lex.ADJECTIVES),
        "col2": lambda _: phrases.color(),
        "col3": lambda _: phrases.color(),
        "set": lambda _: _set_told(phrases, rng),
        "setof": lambda _: f"the {rng.choice(_MANY)} {_plain_plural(phrases, rng)}",
        "wrong2": lambda _: strip_labels(phrases.determined("O", thing(rng), 0.5, 0.1)),
        "notrel": lambda _: strip_labels(phrases.relation(depth=2)),
        "wpart": lambda _: _part(phrases, rng),
        "inverse": lambda _: _inverse(phrases, rng),
    }


def _plain_plural(phrases: Phrases, rng: Random) -> str:
    return strip_labels(phrases.noun("O", plural(thing(rng)), 0.3))


def _set_told(phrases: Phrases, rng: Random) -> str:
    """Return a comparison set told beforehand ("there are two cups on the table"); all O."""
    opening = rng.choice(("there are", "i see", "we have", "you see", "here are", "there 're"))
    where = strip_labels(phrases.relation(depth=2)) if rng.random() < 0.7 else ""
    return f"{opening} {rng.choice(_MANY)} {_plain_plural(phrases, rng)} {where}"


def _part(phrases: Phrases, rng: Random) -> str:
    """Return a part, its value labelled, its noun O ("a {C black} handle")."""
    value = rng.choice((phrases.color, phrases.color, phrases.material))()
    article = rng.choice(("a", "the", "", "its", "two", "a big"))
    return f"{article} {value if rng.random() < 0.8 else ''} {rng.choice(lex.PARTS)}"


def _inverse(phrases: Phrases, rng: Random) -> str:
    """Return an inverse relation: the landmark is on or in the object."""
    other = phrases.determined("R", thing(rng), 0.15, 0.5)
    on = rng.choice(_CONTAINED)
    it = rng.choice(("it", "it", "it", "them"))
    return rng.choice((
        f"with {other} {on} {it}", f"with {other} {on} {it}", f"that has {other} {on} {it}",
        f"which has {other} {on} {it}", f"having {other} {on} {it}", f"with {other}",
        f"with {other}", f"containing {other}", f"that {other} is {on}", f"that {other} is {on}",
        f"which {other} is standing {on}", f"where {other} is", f"holding {other}",
        f"that contains {other}", f"full of {strip_labels(phrases.noun('R', thing(rng), 0))}",
    ))  # fmt: skip
