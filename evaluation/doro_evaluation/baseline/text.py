"""What the baseline reads and writes: captions as one text, word pieces, and English back.

The paper joins captions "with a delimiter"; ours are ``;`` between the captions of a view and ``|``
between views. Of the captions only those are read whose noun is the instruction's: a filter by
plain string comparison in favour of the baseline, whose input would else be full of cabinets.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import msgspec

from doro_nlu.tokens import tokenize
from doro_nlu.wordpiece import BEGIN, END, PAD, SPECIALS, UNKNOWN, split_word
from doro_schemas.errors import Refused

__all__ = ["BEGIN", "END", "PAD", "UNKNOWN", "Vocabulary"]

CAPTION_MARK, VIEW_MARK = ";", "|"
INPUT_PIECES = 256
"""Pieces of instruction and captions together; what is longer is cut at the end."""
OUTPUT_PIECES = 160
"""Pieces of an answer at most."""
# Where the noun phrase of a caption or of an instruction ends.
_AFTER_NOUN = re.compile(
    r"\b(?:on|in|near|next|beside|inside|at|from|by|under|behind|with|close|onto|to)\b"
)
_BEFORE_MARK = re.compile(r" (?=[,.;:?!|])")
_SENTENCE_START = re.compile(r"(?:^|(?<=[.?!] ))[a-z]")
_PRONOUN = re.compile(r"\bi\b")


class Vocabulary:
    """The pieces that the model knows, and texts to their numbers and back.

    Args:
        names: the pieces, the four special ones first.
    """

    def __init__(self, names: Sequence[str]) -> None:
        if tuple(names[: len(SPECIALS)]) != SPECIALS:
            raise Refused(f"a vocabulary begins with {', '.join(SPECIALS)}, this one does not")
        self.names = list(names)
        self._ids: Mapping[str, int] = {name: number for number, name in enumerate(names)}
        self._words: dict[str, list[int]] = {}

    def pieces(self, text: str) -> list[int]:
        """Return the piece ids of a text, without begin and end."""
        found: list[int] = []
        for word in tokenize(text):
            known = self._words.get(word)
            if known is None:
                known = self._words[word] = split_word(word, self._ids)
            found += known
        return found

    def input(self, captions: Sequence[Sequence[str]], instruction: str) -> list[int]:
        """Return what the encoder reads: begin, instruction, end, captions, end.

        Args:
            captions: of each view; cut where :data:`INPUT_PIECES` are reached.
        """
        ids = [BEGIN, *self.pieces(instruction)[: INPUT_PIECES // 2], END]
        ids += self.pieces(joined(captions))
        return [*ids[: INPUT_PIECES - 1], END]

    def target(self, text: str) -> list[int]:
        """Return what the decoder is to write: the pieces and an end."""
        return [*self.pieces(text)[: OUTPUT_PIECES - 1], END]

    def text(self, ids: Sequence[int]) -> str:
        """Return the English of pieces: joined, with capitals where a sentence begins."""
        words: list[str] = []
        for number in ids:
            name = self.names[number]
            if number in (PAD, BEGIN, END):
                continue
            if name.startswith("##") and words:
                words[-1] += name[2:]
            else:
                words.append(name)
        plain = _BEFORE_MARK.sub("", " ".join(words))
        plain = _PRONOUN.sub("I", plain)
        return _SENTENCE_START.sub(lambda found: found.group().upper(), plain)


class VocabularyFile(msgspec.Struct, frozen=True):
    """``vocabulary.json`` beside a model; ``sha256`` holds the digest of each file by name."""

    pieces: list[str]
    sha256: dict[str, str]


def read_vocabulary(path: Path) -> VocabularyFile:
    """Return the vocabulary file of a model.

    Raises:
        Refused: it is missing or damaged.
    """
    try:
        return msgspec.json.decode(path.read_bytes(), type=VocabularyFile)
    except OSError as error:
        raise Refused(
            f"{path} cannot be read: restore it, or name the folder of a trained model"
        ) from error
    except msgspec.DecodeError as error:
        raise Refused(f"{path} is damaged ({error}): restore it, or train again") from error


def joined(captions: Sequence[Sequence[str]]) -> str:
    """Return the captions of all views as one text; a view without captions leaves nothing."""
    views = [f" {CAPTION_MARK} ".join(view) for view in captions if view]
    return f" {VIEW_MARK} ".join(views)


def noun_of(phrase: str) -> str:
    """Return the last word before the first preposition: "cup" of "a red cup on the table"."""
    words = tokenize(_AFTER_NOUN.split(phrase.lower(), maxsplit=1)[0])
    return words[-1] if words else ""


def about(captions: Sequence[str], instruction: str) -> list[str]:
    """Return the captions whose noun is the instruction's, in order; twins stay.

    "arm chair" and "chair" share their last word: which of them is meant the model must know.
    """
    noun = noun_of(instruction)
    return [caption for caption in captions if noun and noun_of(caption) == noun]
