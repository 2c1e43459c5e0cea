"""Is it English? A gate before the tagger, so that other languages are refused, not guessed at."""

from __future__ import annotations

import unicodedata
from collections.abc import Callable, Sequence

from doro_nlu.reasons import LANGUAGE, NO_WORD, Reason


def _words(text: str) -> list[str]:
    return text.split()


_ENGLISH = frozenset(
    _words(
        """
    the a an of to from with at near next by is are that which there my your me please
    can could would you i it and not this these those some any between behind under
    inside front top left right for one was has have where what bring pick take get find
    fetch give grab hand put show
    """
    )
)
_FOREIGN = frozenset(
    _words(
        """
    der das den dem ein eine einen einem und mir ich bitte auf dem neben nicht ist mit
    von zum le les une des du et moi sur dans avec est pas qui où près mon ma el los las
    una y por favor en del con mi está tu il lo gli di sul della per che het een naar
    mij op och ett med til jag på av não uma um meu para na och dla jest lorem ipsum
    dolor
    """
    )
)
_MIN_KNOWN_SHARE = 0.34


def not_english(tokens: Sequence[str], knows: Callable[[str], bool]) -> Reason | None:
    """Return why a text is not taken for English, or None if it may be.

    Letters of another script, more foreign than English function words, or hardly a known
    word at all. Unknown names are fine ("bring the flibber"), a lone unknown word as well.
    """
    words = [token.lower() for token in tokens if token[0].isalpha()]
    shown = " ".join(tokens)[:60]
    if not words:
        return Reason(
            NO_WORD, f"no word was found in '{shown}': say in English what to fetch or find"
        )
    for word in words:
        if not all(_is_latin(char) for char in word if char.isalpha()):
            return Reason(
                LANGUAGE, f"'{word[:40]}' is not written in Latin letters: say it in English"
            )
    english = sum(word in _ENGLISH for word in words)
    foreign = sum(word in _FOREIGN for word in words)
    known = sum(word in _ENGLISH or knows(word) for word in words)
    if foreign > english or (len(words) > 1 and known < _MIN_KNOWN_SHARE * len(words)):
        return Reason(
            LANGUAGE,
            f"'{shown}' does not read as English ({known} of {len(words)} words are known):"
            " say it in English",
        )
    return None


def _is_latin(char: str) -> bool:
    return char.isascii() or unicodedata.name(char, "").startswith("LATIN")
