"""CoNLL-U to graphs: dependency-parsed sentences through the same parser, without a tagger."""

from __future__ import annotations

from typing import NamedTuple

from doro_nlu.conllu import read_conllu
from doro_nlu.core import reply_of
from doro_nlu.dependencies import label
from doro_nlu.language import not_english
from doro_nlu.parser import parse, refused
from doro_schemas.messages import ParseReply


class ParsedSentence(NamedTuple):
    """A sentence's id (``# sent_id``, or its number) and what was understood of it."""

    id: str
    reply: ParseReply


def parse_conllu(text: str, *, caption: bool = False) -> list[ParsedSentence]:
    """Return the graphs of the sentences of a CoNLL-U text, in their order.

    Labels carry probability 1 and so does ``confidence``: the tree is taken as it is.

    Raises:
        Refused: the text is no CoNLL-U; the line is named.
    """
    found = []
    for sentence in read_conllu(text):
        labelled = label(sentence)
        foreign = not_english(labelled.tagged.tokens, lambda _word: True)
        result = refused(foreign) if foreign else parse(
            labelled.tagged, sentence.text, labelled.heads
        )  # fmt: skip
        reply = reply_of(sentence.text, labelled.tagged, result, caption=caption)
        found.append(ParsedSentence(sentence.id, reply))
    return found
