"""CoNLL-U in: sentences of dependency-parsed words, checked, with the line in every refusal.

The format is that of Universal Dependencies v2, as spaCy, Stanza and UDPipe write it. The lines are
read by the package ``conllu``; what it does not check is checked here.
"""

from __future__ import annotations

from typing import NamedTuple

from conllu.exceptions import ParseException
from conllu.parser import parse_comment_line, parse_line

from doro_schemas.errors import Refused
from doro_schemas.messages.base import MAX_TEXT_CHARS

MAX_WORDS = 500
MAX_NESTED = 60
_FIELDS = ("id", "form", "lemma", "upos", "xpos", "feats", "head", "deprel", "deps", "misc")
_ROOT = 0
_RENAMED = {
    "dobj": "obj", "dative": "iobj", "nsubjpass": "nsubj", "relcl": "acl", "nn": "compound",
    "prt": "compound", "npadvmod": "obl",
}  # fmt: skip
"""Labels of spaCy's English models that only have other names."""


class Word(NamedTuple):
    """A syntactic word.

    Attributes:
        form, lemma: lower case.
        upos: universal part of speech, upper case.
        head: index (from 0) of its head in the sentence; -1 for the root.
        deprel: its relation to the head, without subtype ("nmod:poss" is "nmod").
        subtype: the subtype, or empty.
    """

    form: str
    lemma: str
    upos: str
    head: int
    deprel: str
    subtype: str


class Dependencies(NamedTuple):
    """A sentence: its id and text as the comments give them, and its words."""

    id: str
    text: str
    words: list[Word]


def read_conllu(text: str) -> list[Dependencies]:
    """Return the sentences of a CoNLL-U text.

    Multiword tokens ("1-2") and empty nodes ("1.1") are skipped: the words between carry the tree.

    Raises:
        Refused: a line that is none, an id out of order, a head that is not there, no root or
            several, a circle, more words or deeper nesting than speech has; the line is named.
    """
    sentences: list[Dependencies] = []
    block: list[tuple[int, str]] = []
    for number, line in enumerate([*text.splitlines(), ""], 1):
        if line.strip():
            block.append((number, line))
        elif block:
            sentences.append(_sentence(block, len(sentences) + 1))
            block = []
    return sentences


def _sentence(block: list[tuple[int, str]], count: int) -> Dependencies:
    comments: dict[str, str] = {}
    rows: list[tuple[int, Word]] = []
    for number, line in block:
        if line.startswith("#"):
            comments.update({key: value or "" for key, value in parse_comment_line(line)})
            continue
        word = _word(number, line, len(rows) + 1)
        if word is not None:
            rows.append((number, word))
    first = block[0][0]
    if not rows:
        raise Refused(f"CoNLL-U, line {first}: a sentence without words")
    if len(rows) > MAX_WORDS:
        raise Refused(
            f"CoNLL-U, line {first}: a sentence of {len(rows)} words, at most {MAX_WORDS} are taken"
        )
    _check_tree(rows)
    words = universal([word for _, word in rows])
    said = comments.get("text") or " ".join(word.form for word in words)
    return Dependencies(comments.get("sent_id") or str(count), said[:MAX_TEXT_CHARS], words)


def universal(words: list[Word]) -> list[Word]:
    """Return the words with the labels of spaCy's English models turned into universal ones.

    There a preposition heads its noun ("cup -prep-> on -pobj-> table"); here it hangs on it
    ("cup -nmod-> table -case-> on"). A tree that is universal already stays as it is.
    """
    found = [word._replace(deprel=_RENAMED.get(word.deprel, word.deprel)) for word in words]
    for index, word in enumerate(words):
        if word.deprel not in ("pobj", "pcomp") or word.head < 0:
            continue
        first = last = word.head
        while words[first].deprel == "prep" and words[words[first].head].deprel == "prep":
            first = words[first].head  # "out of", "from under"
        above = words[first].head
        if words[first].deprel != "prep" or above < 0:
            continue
        relation = "nmod" if words[above].upos in ("NOUN", "PROPN", "PRON") else "obl"
        found[index] = word._replace(head=above, deprel=relation)
        for case in range(first, last + 1):
            if words[case].deprel == "prep":
                found[case] = words[case]._replace(head=index, deprel="case")
    return found


def _word(number: int, line: str, expected: int) -> Word | None:
    """Return the word of a line; None for multiword tokens and empty nodes."""
    columns = line.split("\t")
    if len(columns) != len(_FIELDS):
        raise Refused(
            f"CoNLL-U, line {number}: {len(columns)} columns separated by tabs, not {len(_FIELDS)}"
        )
    try:
        token = parse_line(line, _FIELDS, {"id": _ident, "head": _number})
    except (ParseException, ValueError) as error:
        raise Refused(f"CoNLL-U, line {number}: {error}") from error
    if token["id"] is None:
        return None
    if token["id"] != expected:
        raise Refused(f"CoNLL-U, line {number}: word {token['id']} where {expected} is due")
    form, head = str(token["form"]).strip().lower(), token["head"]
    if not form or head is None:
        missing = "HEAD" if form else "FORM"
        raise Refused(f"CoNLL-U, line {number}: the column {missing} is empty")
    relation, _, subtype = str(token["deprel"]).lower().partition(":")
    lemma = str(token["lemma"]).lower()
    return Word(
        form=form,
        lemma=form if lemma in ("_", "") else lemma,
        upos=str(token["upos"]).upper(),
        head=head - 1,
        deprel=relation,
        subtype=subtype,
    )


def _ident(columns: list[str], index: int) -> int | None:
    if any(mark in columns[index] for mark in "-."):
        return None
    return _number(columns, index)


def _number(columns: list[str], index: int) -> int | None:
    text = columns[index]
    if text == "_":
        return None
    if not (text.isascii() and text.isdigit()):
        raise ParseException(f"{_FIELDS[index].upper()} is '{text[:20]}', not a number")
    return int(text)


def _check_tree(rows: list[tuple[int, Word]]) -> None:
    """Raise Refused unless the heads are there, one is the root, and all lead to it."""
    roots = [number for number, word in rows if word.head == _ROOT - 1]
    if len(roots) != 1:
        where = roots[1] if roots else rows[0][0]
        raise Refused(f"CoNLL-U, line {where}: a sentence has one root (HEAD 0), not {len(roots)}")
    for number, word in rows:
        if not -1 <= word.head < len(rows):
            raise Refused(
                f"CoNLL-U, line {number}: head {word.head + 1} of '{word.form[:40]}' is not there"
            )
    depths: dict[int, int] = {-1: 0}
    for index, (number, _) in enumerate(rows):
        path: list[int] = []
        at = index
        while at not in depths:
            if at in path:
                raise Refused(f"CoNLL-U, line {number}: the heads run in a circle")
            path.append(at)
            at = rows[at][1].head
        for one in reversed(path):
            depths[one] = depths[rows[one][1].head] + 1
        if depths[index] > MAX_NESTED:
            raise Refused(
                f"CoNLL-U, line {number}: '{rows[index][1].form[:40]}' is more than {MAX_NESTED}"
                " heads below the root"
            )
