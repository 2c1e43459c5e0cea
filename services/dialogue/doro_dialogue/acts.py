"""The dialogue-act layer: what a person does with an answer, read from its words.

An answer is a list of alternatives ("the red one or the blue one"), each a list of phrases
that all hold of one thing ("the red one, near the lamp, not the first"). What a phrase
says of the thing is left to nlu's parser: "one" becomes the class name and the text goes
there. Nothing is decided here.
"""

from __future__ import annotations

import re
from typing import Literal

import msgspec

from doro_dialogue.act_words import (
    ALL,
    ALL_BUT,
    ANY,
    ANY_OF_THE,
    CANCEL,
    CORRECTION,
    DESCRIBING,
    EMPTY,
    FILLER,
    FROM_SIDE,
    IT_IS,
    LEADING_NO,
    LEADING_YES,
    NEGATION,
    NO_CONTENT,
    NONE,
    ORDINAL,
    ORDINALS,
    OTHER,
    PLACE_PHRASE,
    PREPOSITION,
    REPEAT,
    RIGHT,
    SEARCH,
    SIDE,
    THANKS,
    UNCLEAR,
    UNSURE,
)
from doro_dialogue.facts import words
from doro_dialogue.mend import mended
from doro_dialogue.surface import is_plural

Act = Literal[
    "describe", "cancel", "search", "none", "any", "all", "yes", "no", "repeat", "unclear"
]
LISTED = DESCRIBING | {"the", "one", "ones"}
MAX_PHRASES = 8
"""More is no answer to a question, and each would be a request to the parser."""


class Phrase(msgspec.Struct, frozen=True):
    """One description of the thing meant, or of what is not meant.

    Attributes:
        text: what the parser is to read, the class name in place of "one"; may be empty.
        negative: the thing is not so.
        ordinal: 1 the first, -1 the last, 0 none given.
        side: left, middle or right, or empty; with an ordinal it is counted from there.
        other: "the other one".
        named: the class itself is said ("the other cup"), as a clause says it.
        plural: "the red ones".
        unclear: says something that no observation answers ("the biggest", "mine").
    """

    text: str = ""
    negative: bool = False
    ordinal: int = 0
    side: str = ""
    other: bool = False
    plural: bool = False
    unclear: bool = False
    named: bool = False


class Heard(msgspec.Struct, frozen=True):
    """An answer's act.

    Attributes:
        act: what is done; everything but ``describe`` needs no parser.
        alternatives: phrases by alternative; more than one only for "or" and "and".
        joined: how the alternatives hang together.
        corrects: the person takes something back ("no", "I meant", "instead").
        count: "all three": 3; 0 where no number was said.
        pick: "any red one": whichever of those described.
        said: the words, lower case and without courtesies.
    """

    act: Act
    alternatives: list[list[Phrase]] = []
    joined: Literal["", "and", "or"] = ""
    corrects: bool = False
    count: int = 0
    pick: Literal["", "any", "all"] = ""
    said: str = ""

    @property
    def texts(self) -> list[str]:
        """What the parser has to read, in order."""
        return [one.text for phrases in self.alternatives for one in phrases if one.text]


def hear(text: str, name: str, known: frozenset[str] = frozenset()) -> Heard:
    """Return the act of an answer to a question about things called ``name``.

    Args:
        known: words that were observed; slips towards them are repaired.
    """
    said = _normal(mended(text.lower(), known | words(name)))
    if found := CANCEL.search(said):
        rest = said[found.end() :].strip(" ,.")
        if not rest:
            return Heard("cancel")
        # "never mind the red one" takes back the red one; after a comma something new comes.
        taken_back = not said[found.end() :].lstrip(" ").startswith((",", "."))
        return _describe(f" NOT {rest}" if taken_back else rest, name, corrects=True)
    whole = _whole(said, name)
    if whole is not None:
        return msgspec.structs.replace(whole, said=said)
    if RIGHT.search(said):
        return Heard("yes", [[Phrase(side="right")]])
    no, said = _leading(LEADING_NO, said)
    yes, said = _leading(LEADING_YES, said) if not no else (False, said)
    if not said:
        thanks = not no and THANKS.search(text.lower()) is not None
        return Heard("yes" if yes or thanks else "no" if no else "unclear")
    return msgspec.structs.replace(_describe(said, name, corrects=no), said=said)


def _whole(said: str, name: str) -> Heard | None:
    """Return the act of an answer that says one thing as a whole."""
    if REPEAT.search(said):
        return Heard("repeat")
    if UNSURE.search(said):
        return Heard("unclear")
    if SEARCH.search(said):
        return Heard("search", [[Phrase(text=_place(said, name))]])
    return Heard("none") if NONE.search(said) else None


def _normal(text: str) -> str:
    said = text.lower().replace("\u2019", "'").strip()
    said = re.sub(r"[!?;:\"()]", " , ", said)
    said = re.sub(r"\.(?!\d)", " , ", said)
    said = ANY_OF_THE.sub("any", FILLER.sub(" ", said))
    said = re.sub(r"\b(\w+)(?: \1\b)+", r"\1", said)
    return re.sub(r"\s+", " ", re.sub(r"(\s*,)+\s*", ", ", said)).strip(" ,")


def _leading(pattern: re.Pattern[str], said: str) -> tuple[bool, str]:
    found = False
    while said and (match := pattern.match(said)):
        found, said = True, said[match.end() :].strip(" ,")
    return found, said


def _describe(said: str, name: str, *, corrects: bool) -> Heard:
    said, marks = CORRECTION.subn(" ", said)
    corrects = corrects or marks > 0
    pick: Literal["", "any", "all"] = ""
    count = 0
    if match := ALL_BUT.search(said):
        pick, said = "all", f"{said[: match.start()]} NOT {said[match.end() :]}"
    elif match := ANY.search(said):
        pick, said = "any", f"{said[: match.start()]} {said[match.end() :]}"
    elif match := ALL.search(said):
        pick, said = "all", f"{said[: match.start()]} {said[match.end() :]}"
        words = {"both": 2, "two": 2, "three": 3, "four": 4, "five": 5}
        count = next((words[w] for w in match.group().split() if w in words), 0)
    said = NEGATION.sub(" NOT ", said)
    said = re.sub(r"\s+", " ", said).strip(" ,")
    if not EMPTY.sub("", said).strip(" ,"):
        return Heard(pick or "unclear", count=count, pick=pick)
    alternatives, joined = _alternatives(said, name)
    phrases = [[_phrase(part, name) for part in _parts(one)] for one in alternatives]
    phrases = [[p for p in one if p != Phrase()] for one in phrases]
    phrases = [one for one in phrases if one]
    if sum(map(len, phrases)) > MAX_PHRASES:
        return Heard("unclear")
    if not phrases:
        return Heard(pick or "unclear", count=count, pick=pick)
    return Heard("describe", phrases, joined if len(phrases) > 1 else "", corrects, count, pick)


def _alternatives(said: str, name: str) -> tuple[list[str], Literal["", "and", "or"]]:
    """Split "the red one and the blue one", but not "near the lamp and the sink"."""
    for joint in ("or", "and"):
        parts = [part.strip(" ,") for part in re.split(rf",? \b{joint}\b ", said)]
        head = re.compile(rf"\b(ones?|{re.escape(name)}s?)\b|{ORDINAL.pattern}")
        if len(parts) < 2:
            continue
        if any(part.startswith("NOT") for part in parts):
            # "not the red or the blue one", "not the red one and not the blue one"
            rest = [part if part.startswith("NOT") else f"NOT {part}" for part in parts]
            if joint == "or" or rest == parts:
                return [", ".join(rest)], ""
        listed = all(set(part.split()) <= LISTED for part in parts)
        # "the red and the blue one", "the red and blue ones", not "the blue and white one"
        several = listed and (parts[-1].startswith("the ") or parts[-1].endswith(" ones"))
        if joint == "or" or several or all(head.search(part) for part in parts):
            return parts, "or" if joint == "or" else "and"
    return [said], ""


def _parts(said: str) -> list[str]:
    """Split at commas and before every negation, which then stands first."""
    parts = []
    for piece in re.split(r", | but ", said):
        first, *negated = piece.split("NOT")
        parts += [first, *(f"NOT {part}" for part in negated)]
    return [part.strip(" ,") for part in parts if part.strip(" ,")]


def _phrase(said: str, name: str) -> Phrase:
    negative = said.startswith("NOT")
    said = said.removeprefix("NOT").strip()
    plural = bool(re.search(r"\bones\b", said))
    unclear = bool(UNCLEAR.search(said))
    said = UNCLEAR.sub(" ", said)
    other = bool(OTHER.search(said))
    named = other and bool(re.search(rf"\b{re.escape(name)}\b", said))
    said = OTHER.sub(lambda found: " one " if "one" in found.group() else " ", said)
    side = ""
    if match := FROM_SIDE.search(said):
        side, ordinal, mixed = match.group("side"), ORDINALS[match.group("number")], False
        said = _without(said, match)
    else:
        ordinal, said, mixed = _ordinal(said)
    if not side and (match := SIDE.search(said)):
        side = {"l": "left", "r": "right"}.get(match.group("side")[0], "middle")
        said = _without(said, match)
    text = _to_parse(said, name)
    if negative and not (text or ordinal or side or other):
        unclear = True
    return Phrase(text, negative, ordinal, side, other, plural, unclear or mixed, named)


def _without(said: str, side: re.Match[str]) -> str:
    """Return the phrase without its side; with nothing else left it is still "one"."""
    before, after = said[: side.start()].strip(), said[side.end() :].strip()
    return f"{before} {after}" if before else f"the {after or 'one'}"


def _ordinal(said: str) -> tuple[int, str, bool]:
    """Return the ordinal, the rest, and whether it belongs to a landmark ("near the first")."""
    match = ORDINAL.search(said)
    if match is None:
        return 0, said, False
    word = next(group for group in match.groups() if group)
    if PREPOSITION.search(said[: match.start()]):
        return 0, said, True
    rest = f"{said[: match.start()]} {said[match.end() :]}"
    return ORDINALS[word], rest, bool(ORDINAL.search(rest))


def _to_parse(said: str, name: str) -> str:
    """Return the phrase with a head noun that the parser knows; empty if nothing is said."""
    said = IT_IS.sub(" ", said)
    said = re.sub(r"\bby (?=the|a|my)\b", "near ", said)
    said = re.sub(r"\b(?:closest|nearest) to\b", "near", said)
    said = re.sub(r"\b(ones?|thing|object|item)\b", name, said)
    if is_plural(name):
        said = re.sub(r"\b(?:pair|set)s? of\b", " ", said)
        said = re.sub(r"\b(?:pair|set)s?\b", name, said)
    said = re.sub(r"\s+", " ", said)
    said = re.sub(rf"\b({re.escape(name)})( \1)+\b", r"\1", said)
    said = re.sub(r"\s+", " ", said).strip(" ,")
    if not re.sub(rf"{NO_CONTENT.pattern}|\b{re.escape(name)}\b", "", said).strip(" ,'"):
        return ""
    if re.search(rf"\b{re.escape(name)}\b", said):
        return said
    said = re.sub(r"^(?:(?:bring|take|get|give|fetch|grab|hand|want|i|me|to) )+", "", said)
    head = PREPOSITION.search(said)
    before, after = (said[: head.start()], said[head.start() :]) if head else (said, "")
    words = re.sub(r"^(?:the|a|an)\b ?", "", before.strip()).split()
    if all(word in DESCRIBING for word in words):
        return " ".join(["the", *words, name, *after.split()])
    return said


def _place(said: str, name: str) -> str:
    match = PLACE_PHRASE.search(said)
    return f"the {name} {match.group()}" if match else ""
