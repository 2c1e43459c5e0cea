"""What surrounds the training and needs neither torch nor onnx."""

import itertools
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from doro_nlu.decode import Decoder, log_softmax
from doro_nlu.labels import LABELS, may_follow
from doro_nlu.onnx_files import Tagged
from doro_nlu.tagger import load_tagger
from doro_nlu.train.annotate import annotate
from doro_nlu.train.evaluate import evaluate
from doro_nlu.train.own_dev import own_examples
from doro_nlu.train.speed import beside_reference, measure, reference_session
from doro_nlu.train.weak import read_labelled, read_texts, weak_examples
from doro_nlu.train.weights import bert_name, read_safetensors, write_safetensors
from doro_schemas.errors import Refused

KNOWN = {
    "bring the cup on the table": "bring the {O cup} {P on} the {R table}",
    "find the cup": "find the {O cup}",
    "go near": "go {N near}",
}


class Teacher:
    """A tagger that knows three sentences, each label as sure as told."""

    labels = LABELS

    def __init__(self, sure: float, *, silent: str = "") -> None:
        self.sure = sure
        self.silent = silent

    def tag(self, sentences: Sequence[Sequence[str]]) -> list[Tagged]:
        found = []
        for tokens in sentences:
            text = " ".join(tokens)
            labels = annotate(KNOWN[text]).labels
            if text == self.silent:
                labels = ["O"] * len(tokens)
            found.append(Tagged(list(tokens), labels, [self.sure] * len(tokens)))
        return found

    def knows(self, word: str) -> bool:
        return True


def test_weak_labels_need_sure_teachers_that_agree() -> None:
    texts = list(KNOWN)
    kept = weak_examples([Teacher(0.9)], texts, 0.8)
    assert [" ".join(item.tokens) for item in kept] == texts[:2]  # no landmark: a wrong label
    assert weak_examples([Teacher(0.9), Teacher(0.7)], texts, 0.8) == []
    agreed = weak_examples([Teacher(0.9), Teacher(0.9, silent="find the cup")], texts, 0.8)
    assert [" ".join(item.tokens) for item in agreed] == texts[:1]


def test_texts_and_labelled_sentences_are_read(tmp_path: Path) -> None:
    path = tmp_path / "a.jsonl"
    path.write_text('{"text": " a cup "}\n{"text": "a cup"}\n{"text": "b"}\n', encoding="utf-8")
    assert read_texts([path, path]) == ["a cup", "b"]
    path.write_text('{"tokens": ["a"], "labels": ["O"]}\n', encoding="utf-8")
    assert read_labelled(path) == [annotate("a")]


def test_safetensors_round_trip(tmp_path: Path) -> None:
    arrays = {"a": np.arange(6, dtype=np.float32).reshape(2, 3), "b": np.ones(1, np.float32)}
    write_safetensors(tmp_path / "x", arrays)
    found = read_safetensors(tmp_path / "x")
    assert list(found) == ["a", "b"]
    for name, value in arrays.items():
        np.testing.assert_array_equal(found[name], value)


@pytest.mark.parametrize(
    ("variable", "name"),
    [
        ("module/bert/embeddings/word_embeddings", "embeddings.word_embeddings.weight"),
        ("module/bert/embeddings/LayerNorm/gamma", "embeddings.LayerNorm.weight"),
        ("module/bert/encoder/layer_11/attention/self/key/kernel",
         "encoder.layer.11.attention.self.key.weight"),
        ("module/bert/encoder/layer_0/output/dense/bias", "encoder.layer.0.output.dense.bias"),
        ("module/cls/predictions/output_bias", "cls.predictions.output_bias"),
    ],
)  # fmt: skip
def test_names_of_bert_variables(variable: str, name: str) -> None:
    assert bert_name(variable) == name


def test_the_decoder_finds_the_best_legal_sequence() -> None:
    labels = LABELS[:5]
    draw = np.random.default_rng(3)
    decoder = Decoder(labels)
    for _ in range(50):
        logits = draw.normal(size=(4, len(labels))).astype(np.float32)
        log_p = log_softmax(logits.astype(np.float64))
        best, path = -np.inf, ()
        for index in np.ndindex(*[len(labels)] * 4):
            names = ["O", *(labels[at] for at in index)]
            legal = all(may_follow(a, b) for a, b in itertools.pairwise(names))
            score = log_p[np.arange(4), list(index)].sum()
            if legal and score > best:
                best, path = score, index
        assert decoder.decode(logits)[0] == [labels[at] for at in path]


def test_own_sentences_are_labelled_well_and_found_well() -> None:
    examples = own_examples()
    for example in examples:
        labels = ["O", *example.labels]
        assert all(may_follow(a, b) for a, b in itertools.pairwise(labels))
    assert evaluate(load_tagger(None, "default"), examples).entity_f1 > 0.9


def test_times_are_taken_and_a_missing_onnx_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    calls: list[int] = []
    times = measure(lambda: calls.append(0), 20)
    assert len(calls) == 21
    assert 0 <= times.p50_us <= times.p99_us
    ours, theirs = beside_reference(load_tagger(), lambda: calls.append(1), repeats=2)
    assert ours.cpu_p50_us > 0 <= theirs.cpu_p50_us
    monkeypatch.setitem(sys.modules, "onnx", None)
    monkeypatch.delitem(sys.modules, "doro_nlu.train.graph", raising=False)
    with pytest.raises(Refused, match="needs onnx"):
        reference_session(None)
    with pytest.raises(Refused, match="cannot be read"):
        reference_session(Path("nowhere"))
