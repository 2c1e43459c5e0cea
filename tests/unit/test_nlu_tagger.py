"""The shipped tagger end to end, on sentences that are not from its templates."""

import json
import random
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from nlu_sentences import CAPTIONS, MUST, NOT_UNDERSTOOD, OTHERS, show

from doro_nlu.core import Nlu
from doro_nlu.decode import Decoder
from doro_nlu.labels import LABELS, may_follow
from doro_nlu.settings import NluSettings
from doro_nlu.tagger import DEFAULT_MODEL, MODEL_FILE, VOCABULARY_FILE, BiLstmTagger
from doro_nlu.tokens import tokenize
from doro_schemas.errors import Refused
from doro_schemas.messages.base import MAX_TEXT_CHARS


@pytest.fixture(scope="module")
def nlu() -> Nlu:
    return Nlu(NluSettings(tagger="bilstm"))


@pytest.mark.parametrize(("text", "graph", "task"), MUST)
def test_sentences_that_must_be_right(nlu: Nlu, text: str, graph: str, task: str) -> None:
    reply = nlu.parse_text(text)
    assert (show(reply.graph), reply.task) == (graph, task)
    assert 0.5 < reply.confidence <= 1.0
    assert len(reply.tokens) == len(reply.labels)


def test_most_hand_written_sentences_are_right(nlu: Nlu) -> None:
    wrong = [
        (text, show(nlu.parse_text(text).graph))
        for text, graph, task in OTHERS
        if (show(nlu.parse_text(text).graph), nlu.parse_text(text).task) != (graph, task)
    ]
    assert len(wrong) <= 2, wrong


def test_captions_are_right(nlu: Nlu) -> None:
    wrong = [
        (text, show(nlu.parse_text(text, caption=True).graph))
        for text, graph in CAPTIONS
        if show(nlu.parse_text(text, caption=True).graph) != graph
    ]
    assert len(wrong) <= 1, wrong
    assert all(nlu.parse_text(text, caption=True).task == "" for text, _ in CAPTIONS)


@pytest.mark.parametrize("text", NOT_UNDERSTOOD)
def test_a_reason_instead_of_a_guess(nlu: Nlu, text: str) -> None:
    reply = nlu.parse_text(text)
    assert reply.graph is None
    assert reply.reason
    assert reply.readings == []


def test_batch_and_single_agree() -> None:
    tagger = BiLstmTagger()
    sentences = [tokenize(text) for text, *_ in MUST + OTHERS] + [[]]
    together = tagger.tag(sentences)
    for tokens, tagged in zip(sentences, together, strict=True):
        alone = tagger.tag([tokens])[0]
        assert alone.labels == tagged.labels
        np.testing.assert_allclose(alone.probabilities, tagged.probabilities, atol=1e-4)


def _garbage(rng: random.Random) -> str:
    pools: Sequence[str] = (
        "abcdefghij klmnop",
        " .,;:!?'\"()-/",
        "0123456789 ",
        "äöüßéñ漢字かな한글\u200b\u0301\U0001f600 \n\t",
        "the a red cup on table near of and in plastic ".replace(" ", "\x1f"),
    )
    length = rng.choice((1, 5, 40, 200, MAX_TEXT_CHARS))
    text = ""
    while len(text) < length:
        pool = rng.choice(pools)
        text += rng.choice(pool.split("\x1f")) + " " if "\x1f" in pool else rng.choice(pool)
    return text[:length]


def test_garbage_never_crashes(nlu: Nlu) -> None:
    rng = random.Random(7)
    for _ in range(150):
        text = _garbage(rng)
        reply = nlu.parse_text(text, caption=rng.random() < 0.5)
        assert len(reply.tokens) == len(reply.labels)
        assert (reply.graph is None) == bool(reply.reason)
        assert 0.0 <= reply.confidence <= 1.0
        for before, label in zip(["O", *reply.labels], reply.labels, strict=False):
            assert may_follow(before, label)


def test_text_of_greatest_length_and_beyond(nlu: Nlu) -> None:
    phrase = "bring me the red cup on the table near the sink and "
    text = (phrase * 100)[:MAX_TEXT_CHARS]
    reply = nlu.parse_text(text)
    assert reply.graph is not None
    assert reply.graph.name == "cup"
    with pytest.raises(Refused, match="2001 characters"):
        nlu.parse_text("a" * (MAX_TEXT_CHARS + 1))


def test_viterbi_keeps_bio_where_the_best_labels_do_not() -> None:
    logits = np.zeros((2, len(LABELS)), np.float32)
    logits[0, LABELS.index("O")] = 1.0
    logits[1, LABELS.index("I-color")] = 3.0
    labels, probabilities = Decoder(LABELS).decode(logits)
    assert labels == ["B-color", "I-color"]
    assert probabilities[1] > 0.5
    assert Decoder(LABELS).decode(logits[:0]) == ([], [])


def _copy(directory: Path, **changes: object) -> None:
    """Copy the shipped model with changes to its vocabulary file."""
    (directory / MODEL_FILE).write_bytes((DEFAULT_MODEL / MODEL_FILE).read_bytes())
    fields = json.loads((DEFAULT_MODEL / VOCABULARY_FILE).read_bytes()) | changes
    (directory / VOCABULARY_FILE).write_text(json.dumps(fields), encoding="utf-8")


def test_missing_and_corrupt_model(tmp_path: Path) -> None:
    with pytest.raises(Refused, match="vocabulary"):
        BiLstmTagger(tmp_path)
    _copy(tmp_path)
    (tmp_path / MODEL_FILE).unlink()
    with pytest.raises(Refused, match="is missing"):
        BiLstmTagger(tmp_path)
    (tmp_path / MODEL_FILE).write_bytes((DEFAULT_MODEL / MODEL_FILE).read_bytes()[:1000])
    with pytest.raises(Refused, match="sha256 differs"):
        BiLstmTagger(tmp_path)
    _copy(tmp_path, model_sha256="")
    (tmp_path / MODEL_FILE).write_bytes((DEFAULT_MODEL / MODEL_FILE).read_bytes()[:1000])
    with pytest.raises(Refused, match="no usable ONNX file"):
        BiLstmTagger(tmp_path)


def test_vocabulary_of_another_model(tmp_path: Path) -> None:
    _copy(tmp_path, labels=["O"])
    with pytest.raises(Refused, match="1 labels"):
        BiLstmTagger(tmp_path)
    words = json.loads((DEFAULT_MODEL / VOCABULARY_FILE).read_bytes())["words"]
    _copy(tmp_path, words=[*words, "zzzextra"])
    with pytest.raises(Refused, match="more than its model has"):
        BiLstmTagger(tmp_path)
