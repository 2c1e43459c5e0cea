"""The seeded generator of exactly labelled sentences."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from random import Random

from doro_nlu.train import lexicon as lex
from doro_nlu.train.annotate import Example, annotate
from doro_nlu.train.fillers import FOREIGN_PARTS, WORDS
from doro_nlu.train.frames import SHARES, frames_of
from doro_nlu.train.more_fillers import MORE_WORDS, more_slots
from doro_nlu.train.noise import add_typos
from doro_nlu.train.nouns import AMBIGUOUS, COMMON, invented, plural, thing
from doro_nlu.train.phrases import Phrases, strip_labels

_SLOT = re.compile(r"<([a-z_0-9]+)(?::([a-zA-Z]+))?>")
TYPO_SHARE = 0.15
_SOURCES = ("<ref:on>", "<rel:", "<from>")
_NEGATIONS = (", not", " not", " but not", ", and not")
_GO = (
    "go to", "walk to", "move to", "head to", "go into", "go over to", "walk over to", "approach",
    "turn around and go to", "run to", "navigate to", "turn to face", "turn left to", "step to",
    "enter", "go back to", "cross to", "turn right and walk towards", "go in", "walk past",
)  # fmt: skip
_LATER = (
    "turn to face", "walk to", "go to", "open", "close", "turn on", "find", "bring it to",
    "take it to", "move to", "carry it to", "turn left to find", "look at", "clean",
)  # fmt: skip
_IT_VERBS = ("bring", "take", "get", "wash", "clean", "pick up", "fetch", "find", "give me")
_OUT_VERBS = ("take", "get", "pull", "bring")
_REPAIRS = ("", "sorry , ", "i mean ", "rather ")


class Generator:
    """An endless, seeded source of examples.

    Args:
        seed: equal seeds give equal sentences.
        held_out: use the frames that training never sees.
    """

    def __init__(self, seed: int, *, held_out: bool = False) -> None:
        self.rng = Random(seed)
        self.phrases = Phrases(self.rng)
        self.frames = {kind: frames_of(kind, held_out) for kind in SHARES}
        self.kept = ""
        self.same = ""
        self.moved = False
        self.slots = self._slots() | more_slots(self.phrases, rng=self.rng)
        self.slots["samecol"] = lambda _: self._same_color()

    def __iter__(self) -> Iterator[Example]:
        while True:
            example = self.example()
            if example.tokens:
                yield example

    def example(self) -> Example:
        """Return one labelled sentence."""
        rng = self.rng
        kind = rng.choices(list(SHARES), weights=list(SHARES.values()))[0]
        frame = rng.choice(self.frames[kind])
        self.same, self.moved = "", any(slot in frame for slot in _SOURCES)
        text = re.sub(r"\s+", " ", _SLOT.sub(self._fill, frame)).strip()
        example = annotate(text)
        return add_typos(example, rng) if rng.random() < TYPO_SHARE else example

    def _fill(self, slot: re.Match[str]) -> str:
        name, argument = slot[1], slot[2] or ""
        if name in MORE_WORDS:
            return self.rng.choice(MORE_WORDS[name])
        if name in WORDS and not (name in self.slots and self.rng.random() < 0.5):
            return (" " if name == "end" else "") + self.rng.choice(WORDS[name])
        return self.slots[name](argument)

    def _slots(self) -> dict[str, Callable[[str], str]]:
        rng, phrases = self.rng, self.phrases
        return {
            "ref": lambda start: (
                phrases.object() + (phrases.source() if start else phrases.related(0.55))
            ),
            "obj": lambda _: phrases.object(),
            "obj2": lambda _: phrases.object(0.2),
            "rel": lambda start: _after(phrases.relation(start=start or None), start),
            "from": lambda _: phrases.related(0.75, start="A"),
            "front": lambda _: phrases.relation(depth=1, start=rng.choice("PAAAN")),
            "dest": lambda _: phrases.destination(moved=self.moved),
            "todest": lambda _: _toward(phrases, rng),
            "plain": lambda _: phrases.plain(),
            "out": lambda _: f"{rng.choice(_OUT_VERBS)} {phrases.object()} out",
            "notthis": lambda _: _not_this(phrases, rng),
            "wrong": lambda _: strip_labels(f"{phrases.color()} {thing(rng)}"),
            "repair": lambda _: rng.choice(_REPAIRS) + phrases.object(0.6),
            "onlyobj": lambda _: f"{{O {thing(rng)}}}",
            "several": lambda _: _several(phrases, rng),
            "plurals": lambda _: phrases.noun("O", plural(thing(rng)), 0.5),
            "col": lambda _: phrases.color(),
            "cols": lambda _: _values(phrases, rng),
            "xcol": lambda _: rng.choice(lex.BASE_COLORS),
            "mat": lambda _: phrases.material(),
            "cap": lambda _: phrases.determined("O", thing(rng), 0.6, 0.85),
            "capbare": lambda _: phrases.noun("O", rng.choice(COMMON), 0.6),
            "belong": lambda _: phrases.belonging(),
            "predicate": lambda _: phrases.predicate(),
            "foreign2": lambda _: " ".join(rng.choices(FOREIGN_PARTS, k=rng.randint(2, 8))),
            "noise": lambda _: _garbage(rng),
            "go": lambda _: _navigation(phrases, rng),
            "tail": lambda _: _next_task(phrases, rng),
            "keep": lambda _: self._keep(),
            "it": lambda _: _with_it(phrases, rng),
            "again": lambda _: f"the {self.kept}",
            "colornoun": lambda _: phrases.determined("O", rng.choice(AMBIGUOUS), 0.2, 0.8),
        }

    def _same_color(self) -> str:
        """Return a colour span, the same one throughout a sentence."""
        self.same = self.same or self.phrases.color()
        return self.same

    def _keep(self) -> str:
        """Return an object and remember its name, for a bare re-mention later."""
        self.kept = thing(self.rng)
        return self.phrases.determined("O", self.kept, 0.3, 0.2)


def _navigation(phrases: Phrases, rng: Random) -> str:
    where = strip_labels(phrases.relation()) if rng.random() < 0.25 else ""
    return f"{rng.choice(_GO)} {phrases.plain()} {where}"


def _with_it(phrases: Phrases, rng: Random) -> str:
    if rng.random() < 0.3:
        verb = rng.choice(_IT_VERBS)
        return f"{verb} {rng.choice(('it', 'them', 'that', 'this', 'it here', 'it to me'))}"
    verb = rng.choice(("put", "place", "set", "drop", "leave", "hang"))
    return f"{verb} {rng.choice(('it', 'it', 'them', 'that'))} {phrases.destination()}"


def _next_task(phrases: Phrases, rng: Random) -> str:
    if rng.random() < 0.5:
        return _with_it(phrases, rng)
    return f"{rng.choice(_LATER)} {phrases.plain()}"


def _after(relation: str, start: str) -> str:
    """Drop the connector where the frame has written it itself ("from" + landmark)."""
    return re.sub(r"^.*?\{[NPA] [^}]*\} ", "", relation, count=1) if start else relation


def _not_this(phrases: Phrases, rng: Random) -> str:
    other = (phrases.object(0.5), f"the one {phrases.relation()}", f"the {phrases.color()} one")
    return f"{rng.choice(_NEGATIONS)} {strip_labels(rng.choice(other))}"


def _several(phrases: Phrases, rng: Random) -> str:
    return f"all the {phrases.noun('O', plural(thing(rng)), 0.4)}{phrases.related(0.6)}"


def _values(phrases: Phrases, rng: Random) -> str:
    second = phrases.material() if rng.random() < 0.5 else phrases.color()
    return f"{phrases.color()} {rng.choice((',', 'and'))} {second}"


def _toward(phrases: Phrases, rng: Random) -> str:
    where = rng.choice(("to", "to", "to", "over to", "back to", "into", "towards"))
    return f"{where} {rng.choice((phrases.plain(), phrases.plain(), 'me', 'my desk', 'my friend'))}"


def _garbage(rng: Random) -> str:
    words = [
        invented(rng) if rng.random() < 0.6 else str(rng.randint(0, 99))
        for _ in range(rng.randint(2, 6))
    ]
    return " ".join(words) + rng.choice(("", " ?", " ???", " ...", " ; #"))
