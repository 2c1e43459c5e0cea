"""A slice of the fuzz of nlu; all of it: ``python -m tools.fuzz_nlu --count 100000``."""

from collections import Counter

import pytest

from doro_nlu.core import Nlu
from doro_nlu.reasons import KINDS
from doro_nlu.settings import NluSettings
from doro_schemas import codec
from doro_schemas.errors import Refused
from doro_schemas.messages import Instruction
from doro_schemas.messages.base import MAX_TEXT_CHARS
from tools.fuzz_nlu import Run, base_texts, strings

SLICE = 2000


@pytest.fixture(scope="module")
def nlu() -> Nlu:
    return Nlu(NluSettings())


def test_every_string_gives_a_graph_a_reason_or_a_refusal(nlu: Nlu) -> None:
    run = Run(nlu)
    for payload in strings(SLICE, 11, base_texts()):
        run.feed(payload)
    assert sum(run.outcomes.values()) == SLICE
    assert set(run.outcomes) <= {"graph", "refused", *KINDS}
    assert {"graph", "refused", "language", "no_object", "no_word"} <= set(run.outcomes)


def test_the_strings_are_of_every_kind() -> None:
    payloads = list(strings(SLICE, 11, base_texts()))
    assert payloads == list(strings(SLICE, 11, base_texts()))
    kinds = Counter(kind for payload in payloads for kind in _kinds(payload))
    wanted = ("empty", "huge", "no utf-8", "control", "right to left", "combining", "emoji")
    assert all(kinds[kind] for kind in wanted), kinds


def _kinds(payload: bytes) -> list[str]:
    sizes = {"empty": not payload.strip(), "huge": len(payload) > 50_000}
    found = [kind for kind, is_so in sizes.items() if is_so]
    try:
        text = payload.decode()
    except UnicodeDecodeError:
        return [*found, "no utf-8"]
    marks = {
        "control": "\x00\x07\x1b",
        "right to left": "א\u202e",
        "combining": "\u0301\u20e3",
        "emoji": "\U0001f600",
    }
    return found + [kind for kind, chars in marks.items() if any(char in text for char in chars)]


@pytest.mark.parametrize("text", ["\ud800", "bring the \udfff cup", "cup\ud83d"])
def test_lone_surrogates_are_replaced(nlu: Nlu, text: str) -> None:
    (reply,) = nlu.instruction(Instruction(text=text))
    assert codec.encode(reply)  # type: ignore[arg-type]
    assert codec.encode(nlu.parse_text(text, caption=True))


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("", "no_word"),
        (" \n\t", "no_word"),
        ("?!", "no_word"),
        ("😀", "no_word"),
        ("go to the kitchen", "navigation"),
        ("walk straight over to the window", "navigation"),
        ("turn around", "no_object"),
        ("give me the red one", "no_object"),
        ("take the cup and the plate", "two_targets"),
        ("bring the cup and bring the plate", "two_targets"),
        ("bring me the milk along with the sugar", "two_targets"),
        ("bring mir bitte die rote Tasse", "language"),
        ("please find die Tasse auf dem Tisch", "language"),
        ("принеси чашку", "language"),
        ("bring me 红色的 cup", "language"),
    ],
)
def test_each_reason_has_its_kind(nlu: Nlu, text: str, kind: str) -> None:
    reply = nlu.parse_text(text)
    assert (reply.graph, reply.reason_kind) == (None, kind)
    assert reply.reason.isprintable()
    assert reply.readings == reply.reading_confidences == []
    assert reply.confidence == 0.0


@pytest.mark.parametrize(
    "text",
    [
        "bring the flibber",
        "restart the wifi",
        "find the crème brûlée",
        "go to the den and get a pen",
    ],
)
def test_unknown_names_and_borrowed_words_are_english(nlu: Nlu, text: str) -> None:
    assert nlu.parse_text(text).reason_kind != "language"


def test_more_than_the_greatest_length_is_refused(nlu: Nlu) -> None:
    with pytest.raises(Refused, match="100000 characters"):
        nlu.parse_text("red cup " * 12_500)
    assert nlu.parse_text(("red cup " * 1000)[:MAX_TEXT_CHARS]).graph is not None
