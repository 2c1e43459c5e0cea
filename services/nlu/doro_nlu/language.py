"""Is it English? A gate before the tagger, so that other languages are refused, not guessed at."""

from __future__ import annotations

import unicodedata
from collections.abc import Callable, Sequence

from doro_nlu.reasons import LANGUAGE, NO_WORD, Reason, plain


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


_ENGLISH = _words(
    """
    the a an of to from with at near next by is are that which there my your me please
    can could would you i it and not this these those some any between behind under
    inside front top left right for one was has have where what bring pick take get find
    fetch give grab hand put show it's i'm i'd don't let's then turn go up off into on
    """
)
"""Function words and the commonest verbs of requests."""

_FOREIGN = _words(
    """
    der das dem ein eine einen einem einer und mir ich bitte auf nicht ist mit
    von zum zur neben hol gib bringe nimm welche wo unter hinter zwischen den die
    la le les une des du et moi sur dans avec est pas qui où près mon ma ce cette au aux
    apporte donne prends s'il plaît l'
    el los las una y por favor en del con mi está trae tráeme dame coge sobre cerca
    il lo gli di sul della nella per che dammi prendi portami vicino sopra
    um uma meu para na da perto traga pegue o os em
    het een naar mij op geef breng pak bij naast van
    och ett med til jag på av ge ta mig bredvid hent tag meg
    dla jest na przynieś mi proszę obok w z
    bana getir lütfen üzerinde ve bir
    tuo minulle se ja hozd ide az egy
    lorem ipsum dolor sit amet
    """
)
"""Function words and commonest verbs of other languages; those that English has as well are left
out or outweighed: "the den" is English, "den Becher" is not."""

_BOTH = _words("die den do no me an so am in also will was war bad rot hat on to o w z")
_MIN_KNOWN_SHARE = 0.5


def not_english(tokens: Sequence[str], knows: Callable[[str], bool]) -> Reason | None:
    """Return why a text is not taken for English, or None if it may be.

    Refused: letters of another script; more foreign than English function words; at least as
    many and hardly a known word; a foreign one and no known word that names anything; no
    English function word and hardly a known one.
    Unknown names are fine ("bring the flibber"), a lone unknown word as well.
    """
    words = [token.lower() for token in tokens if token[0].isalpha()]
    shown = plain(" ".join(tokens))
    if not words:
        what = f"no word was found in '{shown}'" if shown else "the text is empty"
        return Reason(NO_WORD, f"{what}: say in English what to fetch or find")
    for word in words:
        if not (word.isascii() or all(_is_latin(char) for char in word if char.isalpha())):
            return Reason(
                LANGUAGE, f"'{plain(word[:40])}' is not written in Latin letters: say it in English"
            )
    english = sum(word in _ENGLISH for word in words)
    foreign = sum(word in _FOREIGN and word not in _BOTH for word in words)
    either = sum(word in _FOREIGN and word in _BOTH for word in words)
    known = sum(word in _ENGLISH or knows(word) for word in words)
    if foreign and not all(word.isascii() for word in words):
        foreign += sum(not word.isascii() and word not in _FOREIGN for word in words)
    few = len(words) > 1 and known - foreign - either < _MIN_KNOWN_SHARE * len(words)
    content = [word for word in words if word not in _ENGLISH and word not in _FOREIGN]
    strange = foreign > 0 and not any(knows(word) for word in content)
    if foreign > english or strange or (few and foreign + either >= english):
        return Reason(
            LANGUAGE,
            f"'{shown}' does not read as English ({known} of {len(words)} words are known):"
            " say it in English",
        )
    return None


def _is_latin(char: str) -> bool:
    return char.isascii() or unicodedata.name(char, "").startswith("LATIN")
