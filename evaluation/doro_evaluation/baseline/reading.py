"""What a query says, read from its text: state, and the things named with their number.

For systems that answer with text alone. The words of the paper's templates tell the state; the
clauses are parsed by nlu, as captions are.
"""

from __future__ import annotations

import re
from collections.abc import Callable

import msgspec

from doro_dialogue.surface import NUMBERS
from doro_schemas.graph import ObjectGraph
from doro_schemas.messages.talk import State

Parser = Callable[[str], ObjectGraph | None]
"""A noun phrase to its graph; None where it is not understood."""

_NUMBER = rf"(?:{'|'.join(NUMBERS)}|\d+)\b"
_CONFIRM = re.compile(
    r"^(?:okay|sure|alright|got it), (?:i will take|it is|i found) (?P<what>[^.]+)\."
)
_MISSING = re.compile(r"^i could not find (?P<what>[^.;]+)")
_WHICH = re.compile(r"^i found (?P<what>[^;]+?)(?:, but (?:no|i could not) [^;]+)?; .+[?.]$")
_MISMATCH = re.compile(
    r"^i found (?P<what>[^.]+?), but (?:(?:it is|they are) (?P<differs>[^.]+?))?"
    r"(?:(?:, and )?i could not tell [^.]+)?\. .+\?$"
)
_NEXT = re.compile(rf"(?:, and|,| and) (?={_NUMBER})")
_COUNT = re.compile(rf"^(?P<count>{_NUMBER}) (?P<sort>(?:other |identical |more )*)(?P<what>.+)$")
_SIDES = re.compile(
    r", (?:one (?:on|in) the (?:left|middle|right)[^;]*|side by side, [^;]*as i saw them)"
)
_FACTS = re.compile(r", and | and |, ")
_PLACE = re.compile(r"^(?:on|in|at|near|with|the one)\b")


class Clause(msgspec.Struct, frozen=True):
    """What one clause names: how many, of which graph; ``other``: "one other cup"."""

    count: int
    graph: ObjectGraph
    other: bool = False


class Reading(msgspec.Struct, frozen=True):
    """State and clauses of a text; the state is empty where no template fits.

    Attributes:
        understood: every clause was parsed.
    """

    state: State | str
    clauses: tuple[Clause, ...] = ()
    understood: bool = True


def read_query(text: str, parse: Parser) -> Reading:
    """Return what a query says."""
    plain = " ".join(text.lower().split())
    if found := _CONFIRM.match(plain):
        return _reading("CONFIRM", [(1, found["what"], False)], parse)
    if found := _MISSING.match(plain):
        return _reading("INFORM-MISSING", [(1, found["what"], False)], parse)
    if found := _WHICH.match(plain):
        return _reading("INFORM-AMBIGUITY", _clauses(found["what"]), parse)
    if found := _MISMATCH.match(plain):
        clauses = _clauses(found["what"])
        count, what, other = clauses[0] if clauses else (0, "", False)
        with_facts = _with_facts(what, found["differs"] or "")
        return _reading("INFORM-MISMATCH", [(count, with_facts, other)], parse)
    return Reading("", (), understood=False)


def _reading(state: State, clauses: list[tuple[int, str, bool]], parse: Parser) -> Reading:
    graphs = [(count, parse(what), other) for count, what, other in clauses]
    known = tuple(Clause(c, graph, other) for c, graph, other in graphs if graph is not None)
    return Reading(state, known, understood=len(known) == len(graphs) > 0)


def _clauses(text: str) -> list[tuple[int, str, bool]]:
    """Return number, words and "other" of each clause; a crowd's kinds become clauses."""
    head, colon, kinds = _SIDES.sub("", text).partition(": ")
    if colon:
        whole = _COUNT.match(head)
        name = whole["what"] if whole else ""
        return [_kind(part, name) for part in _NEXT.split(kinds)]
    return [_counted(part) for part in _NEXT.split(head)]


def _counted(text: str) -> tuple[int, str, bool]:
    found = _COUNT.match(text.strip())
    if found is None:
        return 0, text, False
    return _number(found["count"]), found["what"], "other" in found["sort"]


def _kind(text: str, name: str) -> tuple[int, str, bool]:
    """Return a kind of a crowd: "three blue", "two near the sink", "one more"."""
    word, _, rest = text.strip().partition(" ")
    if rest in ("", "more"):
        return _number(word), name, True
    return _number(word), f"{name} {rest}" if _PLACE.match(rest) else f"{rest} {name}", False


def _number(word: str) -> int:
    if word in NUMBERS:
        return NUMBERS.index(word)
    return int(word) if word.isdigit() else 0


def _with_facts(what: str, predicate: str) -> str:
    """Return a noun phrase with what "it is": "cup" and "red and on top of the desk"."""
    for fact in filter(None, _FACTS.split(predicate)):
        if _PLACE.match(fact):
            what = f"{what} {fact.removeprefix('the one ')}"
        else:
            what = f"{fact.removeprefix('made of ')} {what}"
    return what
