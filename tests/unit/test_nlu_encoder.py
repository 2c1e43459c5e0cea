"""The shipped encoder end to end: hand-written sentences, batches, broken files."""

import hashlib
import json
from pathlib import Path

import pytest
from nlu_fresh import FRESH
from nlu_sentences import CAPTIONS, MUST, NOT_UNDERSTOOD, OTHERS, show

import doro_nlu
from doro_nlu.core import Nlu
from doro_nlu.encoder import EncoderTagger
from doro_nlu.settings import NluSettings
from doro_nlu.tagger import MODEL_FILE, VOCABULARY_FILE, BiLstmTagger, load_tagger
from doro_nlu.tokens import tokenize
from doro_schemas.errors import Refused
from doro_schemas.messages.base import MAX_TEXT_CHARS

MODEL = Path(doro_nlu.__path__[0]) / "models" / "encoder"


@pytest.fixture(scope="module")
def nlu() -> Nlu:
    return Nlu(NluSettings(tagger="default"))


def test_hand_written_sentences_are_right(nlu: Nlu) -> None:
    wrong = [
        text
        for text, graph, task in MUST + OTHERS
        if (show(nlu.parse_text(text).graph), nlu.parse_text(text).task) != (graph, task)
    ]
    wrong += [
        text for text, graph in CAPTIONS
        if show(nlu.parse_text(text, caption=True).graph) != graph
    ]  # fmt: skip
    wrong += [text for text in NOT_UNDERSTOOD if nlu.parse_text(text).graph is not None]
    assert len(wrong) <= 3, wrong


@pytest.mark.parametrize(("tagger", "most"), [("bilstm", 4), ("default", 4)])
def test_fresh_sentences_are_mostly_right(tagger: str, most: int) -> None:
    reader = Nlu(NluSettings(tagger=tagger))
    wrong = [text for text, graph in FRESH if show(reader.parse_text(text).graph) != graph]
    assert len(wrong) <= most, wrong


def test_the_vocabulary_tells_the_kind_of_tagger() -> None:
    assert isinstance(load_tagger(None, "bilstm"), BiLstmTagger)
    assert isinstance(load_tagger(), EncoderTagger)
    assert isinstance(load_tagger(MODEL), EncoderTagger)


def test_a_sentence_does_not_depend_on_its_batch() -> None:
    tagger = load_tagger(None, "default")
    sentences = [tokenize(text) for text, *_ in MUST + OTHERS] + [[]]
    for tokens, tagged in zip(sentences, tagger.tag(sentences), strict=True):
        alone = tagger.tag([tokens])[0]
        assert alone == tagged


@pytest.mark.parametrize(
    "text", ["!" * MAX_TEXT_CHARS, "\u6f22" * MAX_TEXT_CHARS, "\x00", "a b " * 500]
)
def test_odd_text_has_a_label_per_token(nlu: Nlu, text: str) -> None:
    reply = nlu.parse_text(text[:MAX_TEXT_CHARS])
    assert len(reply.tokens) == len(reply.labels)
    assert (reply.graph is None) == bool(reply.reason)


def test_card_and_vocabulary_name_the_model() -> None:
    content = (MODEL / MODEL_FILE).read_bytes()
    digest = hashlib.sha256(content).hexdigest()
    assert digest in (MODEL / "README.md").read_text(encoding="utf-8")
    assert json.loads((MODEL / VOCABULARY_FILE).read_bytes())["model_sha256"] == digest
    assert len(content) < 20_000_000


def test_vocabulary_of_another_model(tmp_path: Path) -> None:
    fields = json.loads((MODEL / VOCABULARY_FILE).read_bytes())
    (tmp_path / MODEL_FILE).write_bytes((MODEL / MODEL_FILE).read_bytes())
    for change, words in (
        ({"labels": ["O"]}, "1 labels"),
        ({"pieces": fields["pieces"][4:]}, "begins with"),
        ({"pieces": [*fields["pieces"], "zzzextra"]}, "more than its model has"),
    ):
        (tmp_path / VOCABULARY_FILE).write_text(json.dumps(fields | change), encoding="utf-8")
        with pytest.raises(Refused, match=words):
            EncoderTagger(tmp_path)
