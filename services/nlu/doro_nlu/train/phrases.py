"""Referring expressions in bracket notation: noun phrases, their attributes and relations."""

from __future__ import annotations

from random import Random

from doro_nlu.train import lexicon as lex
from doro_nlu.train.nouns import invented, place, plural, thing

_DEFINITE = ("the",) * 20 + ("my", "my", "your", "our", "this", "that", "her", "their", "its")
_INDEFINITE = ("a", "a", "a", "a", "some", "any", "another", "one", "one of the", "")
_SEVERAL = (
    "the", "the", "the two", "two", "three", "both", "all the", "some", "the", "a couple of",
    "these", "those", "several", "a few", "5",
)  # fmt: skip
_LINKS = (
    "that is", "which is", "that's", "that are", "sitting", "lying", "placed", "kept",
    "standing", "located", "resting", "laying", "positioned", "that is sitting",
    "that is lying", "hanging", "which stands", "that sits", "you see", "stored", "left",
    "found", "which is placed", "that was left", "you can find", "that I left", "that i put",
    "which has been placed", "that lies", "situated", "leaning", "visible",
)  # fmt: skip
_TOWARD = (
    "on", "in", "into", "onto", "to", "near", "next to", "inside", "under", "beside", "on top of",
    "by", "to the left of", "in front of", "back in", "back on", "at", "in to", "on to", "atop",
    "inside of", "over on", "gently on", "on the right side of", "in the middle of",
)  # fmt: skip
_INTO = (
    "into", "into", "onto", "to", "over to", "in", "in", "on", "on", "inside", "back in",
    "back into", "on to", "in to", "inside of", "and into", "back to", "down on", "back on",
)  # fmt: skip
_PLACED = (
    "near", "next to", "by", "beside", "to the left of", "to the right of", "in front of", "behind",
    "in", "on", "under", "that is next to", "that is near", "across from", "against", "with",
)  # fmt: skip
_ADVERBS = ("right", "directly", "just", "immediately", "somewhere", "still", "all the way")
_EGOCENTRIC = (
    "on the left", "on the right", "to your right", "to your left", "in front of you",
    "closest to you", "over there", "nearest to you", "second from the left", "in the middle",
    "on your right", "on your left", "in the back", "at the top", "on top", "in the front",
    "to the left", "to the right", "behind you", "there", "near you", "at the bottom",
    "on the far left", "next to me", "near me", "in the corner", "farthest from you",
)  # fmt: skip


class Phrases:
    """Random referring expressions; every choice comes from the one generator given."""

    def __init__(self, rng: Random) -> None:
        self.rng = rng

    def maybe(self, probability: float, text: str) -> str:
        """Return ``text`` with a probability, else nothing."""
        return text if self.rng.random() < probability else ""

    def color(self) -> str:
        """Return one or more colour spans ("{C dark green}", "{C red} and {C white}")."""
        rng = self.rng
        base = rng.choice(lex.BASE_COLORS if rng.random() < 0.75 else lex.COLORS)
        roll = rng.random()
        if roll < 0.13:
            base = f"{rng.choice(lex.SHADES[:3] if roll < 0.1 else lex.SHADES)} {base}"
        elif roll < 0.17:
            base = f"{base} {rng.choice(('colored', 'coloured'))}"
        elif roll < 0.21:
            joint = rng.choice(("and", "and", ",", "/", "or"))
            return f"{{C {base}}} {joint} {{C {rng.choice(lex.BASE_COLORS)}}}"
        elif roll < 0.22:
            base = f"{base}-{rng.choice(lex.BASE_COLORS)}"
        return f"{{C {base}}}"

    def material(self) -> str:
        """Return a material span, rarely two."""
        rng = self.rng
        one = rng.choice(lex.COMMON_MATERIALS if rng.random() < 0.6 else lex.MATERIALS)
        if rng.random() < 0.03:
            return f"{{M {one}}} and {{M {rng.choice(lex.MATERIALS)}}}"
        return f"{{M {one}}}"

    def adjectives(self, probability: float) -> str:
        """Return adjectives that are no attribute ("very small", "dirty")."""
        rng = self.rng
        if rng.random() >= probability:
            return ""
        words = [rng.choice(lex.ADJECTIVES) for _ in range(rng.choice((1, 1, 1, 1, 2)))]
        if rng.random() < 0.06:
            words.insert(0, rng.choice(("very", "really", "quite", "slightly", "most")))
        return rng.choice((" ", " ", " ", ", ")).join(words)

    def _before_color(self, probability: float) -> str:
        """Return adjectives that do not read as a shade of the colour after them ("deep")."""
        text = self.adjectives(probability)
        return "" if text.rpartition(" ")[2] in lex.SHADES else text

    def noun(self, code: str, name: str, rich: float) -> str:
        """Return attributes and noun in one of the orders that people use."""
        rng = self.rng
        color = self.color() if rng.random() < rich else ""
        material = self.material() if rng.random() < rich * 0.6 else ""
        head = f"{{{code} {name}}}"
        first, second = (color, material) if rng.random() < 0.75 else (material, color)
        comma = "," if first and second and rng.random() < 0.06 else ""
        if first and second and rng.random() < 0.04:
            comma = " and"
        opening = self._before_color(0.22) if first else self.adjectives(0.22)
        inner = self._before_color(0.05) if second else self.adjectives(0.05)
        parts = [opening, first + comma, inner, second, head]
        return " ".join(part for part in parts if part)

    def determined(self, code: str, name: str, rich: float, indefinite: float) -> str:
        """Return determiner + noun; singular or plural."""
        rng = self.rng
        if rng.random() < 0.08 or name in lex.PLURAL_ONLY:
            return f"{rng.choice(_SEVERAL)} {self.noun(code, plural(name), rich)}"
        if rng.random() < 0.09:
            return self.noun(code, name, rich)
        if rng.random() < 0.02:
            owner = rng.choice(
                (invented(rng) + "'s", "john's", "mom's", "the baby's", "daniele 's")
            )
            return f"{owner} {self.noun(code, name, rich)}"
        words = _INDEFINITE if rng.random() < indefinite else _DEFINITE
        inner = self.noun(code, name, rich)
        article = rng.choice(words)
        if article == "a" and _starts_with_vowel(inner) and rng.random() < 0.9:
            article = "an"
        return f"{article} {inner}".strip()

    def connector(self, code: str, landmark: str) -> str:
        """Return a connector span for a code; ``on the left side of`` is by meaning."""
        rng = self.rng
        words = {"N": lex.NEAR, "P": lex.ON, "A": lex.AT}[code]
        if rng.random() < 0.05:
            words = {"N": lex.FROM_NEAR, "P": lex.FROM_ON, "A": lex.FROM_AT}[code]
        text = rng.choice(words)
        if " of" in text and code == "P" and landmark not in lex.SURFACES and text != "on top of":
            text = "on"
        return f"{{{code} {text}}}"

    def landmark(self, code: str, rich: float) -> tuple[str, str]:
        """Return (connector, landmark phrase) of a relation, ``between`` with two landmarks."""
        rng = self.rng
        name = place(rng, code)
        connector = self.connector(code, name)
        phrase = self.determined("R", name, rich, 0.15)
        if "between" in connector and rng.random() < 0.8:
            phrase += f" and {self.determined('R', place(rng, 'N'), rich, 0.2)}"
        elif rng.random() < 0.015 and code != "N":
            part = rng.choice(("burner", "shelf", "drawer", "seat", "rack", "floor", "door", "end"))
            phrase = f"the {self.adjectives(0.6)} {{R {part}}} of {phrase}"
        return connector, phrase

    def relation(self, rich: float = 0.2, depth: int = 0, start: str | None = None) -> str:
        """Return a relation, with further ones hanging on it or beside it."""
        rng = self.rng
        code = start or rng.choice("NNPPPAAA" if depth == 0 else "NNNPPAA")
        connector, phrase = self.landmark(code, rich)
        text = f"{self.maybe(0.05, rng.choice(_ADVERBS))} {connector} {phrase}"
        if rng.random() < (0.24, 0.15, 0.06)[min(depth, 2)]:
            joint = rng.choice(
                ("", "", "", "", ",", "and", "that is", ", which is", "which is", "and is")
            )
            space = "" if joint.startswith(",") else " "
            text += f"{space}{joint} {self.relation(rich, depth + 1)}"
        elif rng.random() < 0.03:
            text += f" {self.predicate()}"
        return text.strip()

    def predicate(self) -> str:
        """Return a relative clause or participle that names a value ("that is red")."""
        rng = self.rng
        link = rng.choice(("that is", "which is", "that's", "that are", "which are"))
        made = rng.choice(
            ("made of", "made out of", "made from", "that is made of", "which is made of")
        )
        return rng.choice((
            f"{link} {self.color()}", f"{link} {self.color()}", f"{made} {self.material()}",
            f"{made} {self.material()}", f"{link} {self.color()} and {made} {self.material()}",
            f"{link} {self.color()} and {self.material()}", f"{link} {self.adjectives(1)}",
            f"in {self.color()}", f"of {self.color()} color", f"with {self.color()} color",
            f"{link} {self.color()} in color", f"{link} {self.material()}",
            f"that has {self.color()} color",
        ))  # fmt: skip

    def belonging(self) -> str:
        """Return a ``with`` phrase: a part, contents (inverse relation) or company."""
        rng = self.rng
        part = rng.choice(lex.PARTS)
        other = self.determined("R", thing(rng), 0.12, 0.5)
        it = rng.choice(("it", "it", "top of it", "them"))
        on = rng.choice(
            (
                "{P on}",
                "{P on}",
                "{A in}",
                "{A inside}",
                "{A inside of}",
                "{N near}",
                "{P on top of}",
            )
        )
        return rng.choice((
            f"with {rng.choice(('a', 'the', ''))} {self.color()} {part}",
            f"with {rng.choice(('a', 'the', ''))} {self.material()} {part}",
            f"with {rng.choice(('a', 'the', 'a round', 'a broken'))} {part}",
            f"with {other} {on} {it}", f"with {other} {on} {it}", f"that has {other} {on} {it}",
            f"with {other}", f"containing {other}",
        ))  # fmt: skip

    def object(self, rich: float = 0.38) -> str:
        """Return the noun phrase of the object, without relations."""
        rng = self.rng
        text = self.determined("O", thing(rng), rich, 0.28)
        if rng.random() < 0.05:
            text += f" {self.predicate()}"
        if rng.random() < 0.04:
            text += f" {self.belonging()}"
        return text

    def related(self, probability: float = 0.6, start: str | None = None) -> str:
        """Return `` that is on the table`` or nothing, or an egocentric phrase without landmark."""
        rng = self.rng
        if rng.random() >= probability:
            return f" {rng.choice(_EGOCENTRIC)}" if rng.random() < 0.09 else ""
        link = self.maybe(0.25, rng.choice(_LINKS))
        comma = self.maybe(0.05, ",")
        tail = f" {rng.choice(_EGOCENTRIC)}" if rng.random() < 0.03 else ""
        return f"{comma} {link} {self.relation(start=start)}{tail}"

    def reference(self, probability: float = 0.55) -> str:
        """Return the object with its relations."""
        return self.object() + self.related(probability)

    def plain(self) -> str:
        """Return a noun phrase whose words are all O (destinations, distractors)."""
        text = self.determined("O", place(self.rng, self.rng.choice("NPA")), 0.3, 0.2)
        return strip_labels(text)

    def destination(self, *, moved: bool = False) -> str:
        """Return where something is to go; all O.

        Args:
            moved: the sentence has told where the thing is now, so that only a preposition of
                motion tells the destination from one more relation of the source.
        """
        rng = self.rng
        if moved:
            return f"{rng.choice(_INTO)} {self.plain()}"
        text = f"{rng.choice(_TOWARD)} {self.plain()}"
        if rng.random() < 0.2:
            text += f" {rng.choice(_PLACED)} {self.plain()}"
        return text

    def source(self) -> str:
        """Return where a thing is before it is put elsewhere: one relation, marked as such."""
        rng = self.rng
        link = rng.choice(_LINKS) if rng.random() < 0.7 else ""
        code = rng.choice("NNPPPA") if link else "P"
        connector, phrase = self.landmark(code, 0.2)
        if not link:
            connector = rng.choice(("{A from}", "{A from}", "{A off}", "{P on}", "{A off of}"))
        return f" {link} {connector} {phrase}"


def strip_labels(text: str) -> str:
    """Return a bracketed text without its brackets: every word O."""
    for code in "ORCMNPA":
        text = text.replace(f"{{{code} ", "")
    return text.replace("}", "")


def _starts_with_vowel(text: str) -> bool:
    return strip_labels(text)[:1].lower() in tuple("aeiou")
