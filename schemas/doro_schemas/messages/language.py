"""Instructions and their graphs."""

from __future__ import annotations

from typing import ClassVar

from doro_schemas.graph import ObjectGraph
from doro_schemas.messages.base import MAX_TEXT_CHARS, Message


def check_text(text: str, what: str) -> None:
    """Raise ValueError unless ``text`` says something and is not absurdly long."""
    if not text.strip():
        raise ValueError(f"the {what} is empty: say what is wanted, e.g. 'bring me the red cup'")
    if len(text) > MAX_TEXT_CHARS:
        raise ValueError(
            f"the {what} has {len(text)} characters, at most {MAX_TEXT_CHARS} are taken:"
            " say it in a sentence"
        )


class Instruction(Message, kw_only=True):
    """What the person said. Plain UTF-8 on the same key becomes one of these.

    Attributes:
        text: the words.
        person: who said it, where several talk at once; comes back in graph and Query.
    """

    ADDED: ClassVar[dict[str, object]] = {"person": ""}

    text: str
    person: str = ""

    def __post_init__(self) -> None:
        check_text(self.text, "instruction")


class Parsed(Message, kw_only=True):
    """What nlu understood of a text.

    Attributes:
        text: the instruction or caption.
        task: the verb phrase of the task ("bring"), empty where unknown.
        tokens, labels: the tagger's sequence (BIO labels), of equal length.
        probabilities: of each label, 0..1, of the same length; empty = not given.
        graph: the object graph; None if not understood.
        readings: other graphs that the sentence may mean (an attachment that is open), the
            likelier ones first, none of them twice, ``graph`` not among them.
        reading_confidences: of each reading, 0..1, of the same length; empty = not given.
        reason: why it was not understood; empty if it was.
        reason_kind: the same as one word for programs: ``no_word``, ``language``,
            ``no_object``, ``navigation``, ``two_targets`` or ``unsure``; empty if understood.
        confidence: of ``graph``, 0..1: the lowest probability over the labels that made it.
    """

    ADDED: ClassVar[dict[str, object]] = {
        "probabilities": [],
        "reading_confidences": [],
        "reason_kind": "",
    }

    text: str
    task: str = ""
    tokens: list[str] = []
    labels: list[str] = []
    graph: ObjectGraph | None = None
    readings: list[ObjectGraph] = []
    reason: str = ""
    confidence: float = 0.0
    probabilities: list[float] = []
    reading_confidences: list[float] = []
    reason_kind: str = ""


class InstructionGraph(Parsed, kw_only=True):
    """An instruction and its input graph; fields as in :class:`Parsed`.

    Attributes:
        person: as in :class:`Instruction`.
    """

    ADDED: ClassVar[dict[str, object]] = {**Parsed.ADDED, "person": ""}

    person: str = ""


class ParseRequest(Message, kw_only=True):
    """A question to ``doro/nlu/parse``; plain UTF-8 text works as well."""

    text: str
    caption: bool = False

    def __post_init__(self) -> None:
        check_text(self.text, "text")


class ParseReply(Parsed, kw_only=True):
    """The parser's answer; fields as in :class:`Parsed`."""
